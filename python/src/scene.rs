//! Nodes and scenes.

use crate::arrays::{self, Expected};
use crate::convert::Reduced;
use crate::failure::Failure;
use crate::mesh::Mesh;
use crate::pickled::{damaged, mesh_checksum, seal, unseal};
use crate::pictures::Picture;
use crate::values::each;
use crate::work;
use glam::{DAffine3, DMat3, DVec3};
use greenstick::ErrorKind;
use greenstick::files;
use greenstick::formats::LengthUnit;
use greenstick::geometry::{
    Image, Material, Mesh as Triangles, Metadata, Node as Placed, Scene as Meshes, Texture,
};
use greenstick::picture::PictureParameters;
use greenstick::schema::{Field, Parameters};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh placed in the world.
///
/// `transform` is of shape (3, 4) or (4, 4): local coordinates to world coordinates in metres; without it they are the same.
#[pyclass(module = "greenstick", frozen)]
pub struct Node {
    /// Its name, may be empty.
    #[pyo3(get)]
    name: String,
    /// Its mesh, in local coordinates.
    #[pyo3(get)]
    mesh: Py<Mesh>,
    transform: DAffine3,
    /// The index of the node that carries this one, if any.
    #[pyo3(get)]
    parent: Option<usize>,
    /// Whether it only adds to the looks of another node: files that hold one mesh leave it out.
    #[pyo3(get)]
    is_detail: bool,
}

#[pymethods]
impl Node {
    #[new]
    #[pyo3(signature = (name, mesh, transform=None, parent=None, is_detail=false))]
    fn new(
        name: String,
        mesh: Py<Mesh>,
        transform: Option<&Bound<'_, PyAny>>,
        parent: Option<usize>,
        is_detail: bool,
    ) -> PyResult<Self> {
        let transform = transform.map_or(Ok(DAffine3::IDENTITY), affine)?;
        Ok(Node {
            name,
            mesh,
            transform,
            parent,
            is_detail,
        })
    }

    /// Local coordinates to world coordinates in metres: shape (4, 4), float64. A copy.
    #[getter]
    fn transform<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, &self.transform)
    }

    /// The mesh in world coordinates, metres.
    fn world_mesh(&self, py: Python<'_>) -> Mesh {
        let mesh = self.mesh.get().mesh.clone();
        let mesh = py.detach(|| mesh.transformed(&self.transform));
        Mesh {
            mesh: Arc::new(mesh),
        }
    }

    fn __repr__(&self) -> String {
        let mesh = self.mesh.get();
        format!("<greenstick.Node {:?}: {}>", self.name, mesh.__repr__())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, NodeParts<'py>> {
        let node = slf.get();
        let parts = (
            node.name.clone(),
            node.mesh.clone_ref(slf.py()),
            node.transform(slf.py())?,
            node.parent,
            node.is_detail,
        );
        Ok((slf.get_type().into_any(), parts))
    }
}

/// What a pickle of a node holds.
type NodeParts<'py> = (
    String,
    Py<Mesh>,
    Bound<'py, PyArray2<f64>>,
    Option<usize>,
    bool,
);

/// Reads a transform.
fn affine(given: &Bound<'_, PyAny>) -> PyResult<DAffine3> {
    let expected = Expected {
        name: "transform",
        columns: 4,
        dtype: "float64",
        kinds: "fiu",
    };
    let (flat, rows) = arrays::rows::<f64>(given, &expected)?;
    let is_affine = rows == 3 || (rows == 4 && flat[12..] == [0.0, 0.0, 0.0, 1.0]);
    if !is_affine || !flat.iter().all(|x| x.is_finite()) {
        return Err(Failure::value(
            "transform is no affine map; expected finite numbers of shape (3, 4), or (4, 4) with 0, 0, 0, 1 as last row",
        )
        .into());
    }
    let at = |row: usize, column: usize| flat[4 * row + column];
    let column = |c: usize| DVec3::new(at(0, c), at(1, c), at(2, c));
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    })
}

/// What is pickled, in messages.
const SCENE: &str = "a scene";

/// What a scene has beside its nodes, as pickles hold it.
#[derive(Serialize, Deserialize)]
struct Surroundings {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    images: Vec<Image>,
    notes: Vec<String>,
    metadata: Metadata,
    /// A checksum of the mesh of each node.
    meshes: Vec<u64>,
}

/// Returns a checksum of the mesh of each node.
fn mesh_checksums(nodes: &[Placed]) -> Vec<u64> {
    let mut known: HashMap<*const Triangles, u64> = HashMap::new();
    let sum = |node: &Placed| {
        let sum = known.entry(Arc::as_ptr(&node.mesh));
        *sum.or_insert_with(|| mesh_checksum(&node.mesh))
    };
    nodes.iter().map(sum).collect()
}

/// Placed meshes with their materials: what files hold.
///
/// `Scene([Node("branch", mesh)])` or `Scene(mesh)` makes one without materials; `Scene.read` reads a file.
#[pyclass(module = "greenstick", frozen)]
pub struct Scene {
    pub scene: Arc<Meshes>,
    /// The file that it was read from.
    pub path: Option<PathBuf>,
}

impl Scene {
    pub fn new(scene: Meshes, path: Option<PathBuf>) -> Self {
        Scene {
            scene: Arc::new(scene),
            path,
        }
    }
}

/// Reads a unit of length.
pub fn unit(word: Option<&str>) -> Result<Option<LengthUnit>, Failure> {
    let Some(word) = word else { return Ok(None) };
    let found = LengthUnit::from_value(&greenstick::schema::Value::Text(word.to_owned()));
    found.map(Some).ok_or_else(|| {
        Failure::new(
            "ParameterError",
            ErrorKind::Request,
            format!("unit is \"{word}\", but it must be one of mm, cm, m"),
        )
    })
}

/// Encodes a scene that was read from `source` as the files at `path`. Images that `source` refers to are embedded where the
/// folders differ.
pub fn encode(
    scene: &Meshes,
    source: Option<&Path>,
    path: &Path,
    unit: Option<LengthUnit>,
) -> Result<Vec<files::Output>, Failure> {
    let mut scene = scene.clone();
    if let Some(source) = source {
        files::carry_images(&mut scene, source, path);
    }
    Ok(files::encode(&scene, path, unit.unwrap_or_default())?)
}

/// The files of `outputs` as a dictionary of names and bytes.
pub fn file_dictionary<'py>(
    py: Python<'py>,
    outputs: Vec<files::Output>,
) -> PyResult<Bound<'py, PyDict>> {
    let dictionary = PyDict::new(py);
    for output in outputs {
        let name = output.path.file_name().unwrap_or_default();
        dictionary.set_item(name.to_string_lossy(), PyBytes::new(py, &output.bytes))?;
    }
    Ok(dictionary)
}

/// Reads what is asked of a picture.
pub fn picture_parameters(keys: Option<&Bound<'_, PyDict>>) -> PyResult<PictureParameters> {
    let mut parameters = PictureParameters::default();
    each([keys, None], |key, value| Ok(parameters.set(key, value)?))?;
    Ok(parameters)
}

#[pymethods]
impl Scene {
    #[new]
    fn of_nodes(nodes: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mut scene = Meshes::default();
        if let Ok(mesh) = nodes.cast::<Mesh>() {
            let mesh = mesh.get().mesh.clone();
            scene
                .nodes
                .push(Placed::new("mesh", DAffine3::IDENTITY, mesh));
            return Ok(Scene::new(scene, None));
        }
        for node in nodes.try_iter()? {
            let node = node?;
            let node = node
                .cast::<Node>()
                .map_err(|_| Failure::value("a scene is made of a Mesh or of a list of Node"))?;
            scene.nodes.push(placed(node.get()));
        }
        check_parents(&scene)?;
        Ok(Scene::new(scene, None))
    }

    /// Reads a mesh file (.glb, .gltf, .obj, .ply, .stl or .off). `unit` ("mm", "cm" or "m") is the unit of length in it,
    /// where its format has none.
    #[staticmethod]
    #[pyo3(signature = (path, unit=None))]
    fn read(py: Python<'_>, path: PathBuf, unit: Option<&str>) -> PyResult<Self> {
        let unit = self::unit(unit)?;
        let read = work::run(py, None, |_| Ok(files::read(&path, unit)?))?;
        Ok(Scene::new(read, Some(path)))
    }

    /// The nodes. Their meshes are not copied, and nodes that hold the same mesh hold the same object.
    #[getter]
    fn nodes(&self, py: Python<'_>) -> PyResult<Vec<Node>> {
        let mut made: Vec<(*const Triangles, Py<Mesh>)> = Vec::new();
        let mut nodes = Vec::new();
        for node in &self.scene.nodes {
            let address = Arc::as_ptr(&node.mesh);
            let known = made.iter().find(|m| m.0 == address);
            let mesh = match known {
                Some((_, mesh)) => mesh.clone_ref(py),
                None => {
                    let mesh = Py::new(
                        py,
                        Mesh {
                            mesh: node.mesh.clone(),
                        },
                    )?;
                    made.push((address, mesh.clone_ref(py)));
                    mesh
                }
            };
            nodes.push(Node {
                name: node.name.clone(),
                mesh,
                transform: node.transform,
                parent: node.parent,
                is_detail: node.is_detail,
            });
        }
        Ok(nodes)
    }

    /// What the reader left out or repaired, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.scene.notes.clone()
    }

    /// Where the scene comes from: names and texts.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        for entry in &self.scene.metadata.entries {
            dictionary.set_item(&entry.name, &entry.text)?;
        }
        Ok(dictionary)
    }

    /// Names of the materials that `Mesh.materials` are indices of.
    #[getter]
    fn materials(&self) -> Vec<String> {
        self.scene
            .materials
            .iter()
            .map(|m| m.name.clone())
            .collect()
    }

    /// Encodes the scene in the format of the ending of `name`: names of files and their bytes, the first of `name`, then
    /// its companions.
    #[pyo3(signature = (name, unit=None))]
    fn encode<'py>(
        &self,
        py: Python<'py>,
        name: PathBuf,
        unit: Option<&str>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let unit = self::unit(unit)?;
        let (scene, source) = (&self.scene, self.path.as_deref());
        let outputs = work::run(py, None, |_| encode(scene, source, &name, unit))?;
        file_dictionary(py, outputs)
    }

    /// Writes the scene in the format of the ending of `path`, with its companions: all files or none. Returns the paths.
    #[pyo3(signature = (path, unit=None))]
    fn write(&self, py: Python<'_>, path: PathBuf, unit: Option<&str>) -> PyResult<Vec<PathBuf>> {
        let unit = self::unit(unit)?;
        let (scene, source) = (&self.scene, self.path.as_deref());
        work::run(py, None, |_| {
            let outputs = encode(scene, source, &path, unit)?;
            files::write_all(&outputs)?;
            Ok(outputs.into_iter().map(|o| o.path).collect())
        })
    }

    /// Takes a picture in the plain colours of the materials. Keys are those of pictures: `picture_size="640x480"`,
    /// `samples=16`, `view="30,15"`.
    #[pyo3(signature = (*, progress=None, **keys))]
    fn picture(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Picture> {
        let options = picture_parameters(keys)?.options();
        let scene = &self.scene;
        let drawn = work::run(py, progress, |context| {
            Ok(greenstick::picture_of_scene(scene, &options, context)?)
        })?;
        Ok(Picture::new(drawn, self.scene.metadata.clone()))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Scene>().ok();
        other.is_some_and(|other| other.get().scene == self.scene)
    }

    fn __len__(&self) -> usize {
        self.scene.nodes.len()
    }

    fn __repr__(&self) -> String {
        let triangles = self.scene.nodes.iter().map(|n| n.mesh.triangles.len());
        format!(
            "<greenstick.Scene {} nodes, {} triangles>",
            self.scene.nodes.len(),
            triangles.sum::<usize>()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, SceneParts<'py>> {
        let scene = slf.get();
        let whole = &scene.scene;
        let rest = Surroundings {
            materials: whole.materials.clone(),
            textures: whole.textures.clone(),
            images: whole.images.clone(),
            notes: whole.notes.clone(),
            metadata: whole.metadata.clone(),
            meshes: mesh_checksums(&whole.nodes),
        };
        let rest = postcard::to_stdvec(&rest)
            .map_err(|e| Failure::value(format!("the scene cannot be pickled: {e}")))?;
        let parts = (
            scene.nodes(slf.py())?,
            PyBytes::new(slf.py(), &seal(&rest)),
            scene.path.clone(),
        );
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The scene of a pickle.
    #[staticmethod]
    fn _again(nodes: Vec<Bound<'_, Node>>, rest: &[u8], path: Option<PathBuf>) -> PyResult<Self> {
        let rest: Surroundings = postcard::from_bytes(unseal(SCENE, rest)?)
            .map_err(|problem| damaged(SCENE, problem))?;
        let scene = Meshes {
            nodes: nodes.iter().map(|node| placed(node.get())).collect(),
            materials: rest.materials,
            textures: rest.textures,
            images: rest.images,
            notes: rest.notes,
            metadata: rest.metadata,
        };
        if mesh_checksums(&scene.nodes) != rest.meshes {
            return Err(damaged(SCENE, "the checksum of a mesh is wrong").into());
        }
        check_parents(&scene)?;
        Ok(Scene::new(scene, path))
    }
}

/// A map as an array of shape (4, 4).
pub fn matrix<'py>(py: Python<'py>, map: &DAffine3) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (m, t) = (map.matrix3, map.translation);
    let row = |k: usize| vec![m.x_axis[k], m.y_axis[k], m.z_axis[k], t[k]];
    let rows = [row(0), row(1), row(2), vec![0.0, 0.0, 0.0, 1.0]];
    Ok(PyArray2::from_vec2(py, &rows).map_err(|e| Failure::value(e.to_string()))?)
}

/// What a pickle of a scene holds.
type SceneParts<'py> = (Vec<Node>, Bound<'py, PyBytes>, Option<PathBuf>);

fn placed(node: &Node) -> Placed {
    Placed {
        parent: node.parent,
        is_detail: node.is_detail,
        ..Placed::new(
            node.name.clone(),
            node.transform,
            node.mesh.get().mesh.clone(),
        )
    }
}

/// Checks that every node that carries another exists.
fn check_parents(scene: &Meshes) -> Result<(), Failure> {
    let count = scene.nodes.len();
    for (number, node) in scene.nodes.iter().enumerate() {
        if node.parent.is_some_and(|p| p >= count || p == number) {
            return Err(Failure::value(format!(
                "node {number} has no parent among the {count} nodes"
            )));
        }
    }
    Ok(())
}

/// The branch that comes with the library.
#[pyfunction]
pub fn built_in_branch(py: Python<'_>) -> Scene {
    Scene::new(py.detach(greenstick::built_in_branch), None)
}
