//! Triangle meshes, as arrays.

use crate::arrays::{self, Expected};
use crate::convert::{Reduced, report};
use crate::failure::Failure;
use glam::DVec3;
use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::geometry::{Attribute, CheckOptions, Mesh as Triangles};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A triangle mesh with attributes of its vertices and materials of its triangles.
///
/// `positions` are of shape (n, 3) in metres of the node that holds the mesh; `triangles` are of shape (m, 3), counter-clockwise
/// seen from outside; `attributes` are of shape (n, k) under their glTF names (`NORMAL`, `TEXCOORD_0`, `_RING` ...);
/// `materials` are of shape (m,). Arrays of any strides and number types are taken, and copied; those that a mesh gives look
/// into its memory without a copy, and are read-only.
#[pyclass(module = "greenstick", frozen)]
pub struct Mesh {
    pub mesh: Arc<Triangles>,
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (positions, triangles, attributes=None, materials=None))]
    fn new(
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        attributes: Option<&Bound<'_, PyDict>>,
        materials: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (flat, vertices) = arrays::rows::<f64>(
            positions,
            &Expected {
                name: "positions",
                columns: 3,
                dtype: "float64",
                kinds: "fiu",
            },
        )?;
        arrays::check_finite("positions", &flat, 3)?;
        let triangles = indices(triangles, vertices)?;
        let mut mesh = Triangles {
            positions: flat.chunks_exact(3).map(DVec3::from_slice).collect(),
            materials: match materials {
                Some(given) => material_numbers(given, triangles.len())?,
                None => Vec::new(),
            },
            triangles,
            attributes: BTreeMap::new(),
        };
        for (name, given) in attributes.into_iter().flatten() {
            let name: String = name.extract()?;
            let attribute = attribute(&name, &given, vertices)?;
            mesh.attributes.insert(name, attribute);
        }
        Ok(Mesh {
            mesh: Arc::new(mesh),
        })
    }

    /// Vertex positions: shape (n, 3), float64, metres of the node. A read-only view without a copy.
    #[getter]
    fn positions<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat: &[f64] = bytemuck::cast_slice(&slf.get().mesh.positions);
        arrays::view(slf.as_any(), flat, 3)
    }

    /// Vertices of each triangle: shape (m, 3), uint32, counter-clockwise seen from outside. A read-only view without a copy.
    #[getter]
    fn triangles<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let flat: &[u32] = bytemuck::cast_slice(&slf.get().mesh.triangles);
        arrays::view(slf.as_any(), flat, 3)
    }

    /// Attributes of the vertices by name: shape (n, k), float32. Read-only views without a copy.
    #[getter]
    fn attributes<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(slf.py());
        for (name, attribute) in &slf.get().mesh.attributes {
            let array = arrays::view(slf.as_any(), &attribute.data, attribute.width)?;
            dictionary.set_item(name, array)?;
        }
        Ok(dictionary)
    }

    /// Material of each triangle: shape (m,), uint32, an index into the materials of the scene, 4294967295 for none; `None`
    /// where no triangle has one. A read-only view without a copy.
    #[getter]
    fn materials<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArray1<u32>>>> {
        let materials = &slf.get().mesh.materials;
        if materials.is_empty() {
            return Ok(None);
        }
        let flat = arrays::view(slf.as_any(), materials, 1)?;
        flat.reshape([materials.len()]).map(Some)
    }

    /// Signed volume, m³ where positions are in metres: positive for a closed mesh oriented outwards, meaningless for an open
    /// one.
    #[getter]
    fn volume(&self) -> f64 {
        self.mesh.volume()
    }

    /// Sum of the triangles' areas, m² where positions are in metres.
    #[getter]
    fn area(&self) -> f64 {
        self.mesh.area()
    }

    /// Says whether the mesh is closed, oriented, manifold and, unless that is not asked for, free of crossings.
    #[pyo3(signature = (self_intersections=true))]
    fn check<'py>(&self, py: Python<'py>, self_intersections: bool) -> PyResult<Bound<'py, PyAny>> {
        let found = py.detach(|| self.mesh.check_with(CheckOptions { self_intersections }));
        report(py, &found)
    }

    /// The mesh as a `trimesh.Trimesh`, which copies the arrays. Attributes go into `vertex_attributes`.
    fn to_trimesh<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        foreign(slf.py())?.call_method1("mesh_to_trimesh", (slf,))
    }

    /// The mesh as a `pyvista.PolyData`, which copies the arrays. Attributes go into `point_data`, materials into `cell_data`.
    fn to_pyvista<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        foreign(slf.py())?.call_method1("mesh_to_pyvista", (slf,))
    }

    /// A mesh of a `trimesh.Trimesh`, whose arrays are copied.
    #[staticmethod]
    fn from_trimesh<'py>(py: Python<'py>, mesh: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        foreign(py)?.call_method1("mesh_from_trimesh", (mesh,))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Mesh>().ok();
        other.is_some_and(|other| other.get().mesh == self.mesh)
    }

    pub fn __repr__(&self) -> String {
        format!(
            "<greenstick.Mesh {} vertices, {} triangles>",
            self.mesh.positions.len(),
            self.mesh.triangles.len()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, MeshParts<'py>> {
        let parts = (
            Mesh::positions(slf)?,
            Mesh::triangles(slf)?,
            Mesh::attributes(slf)?,
            Mesh::materials(slf)?,
        );
        Ok((slf.get_type().into_any(), parts))
    }
}

/// What a pickle of a mesh holds.
type MeshParts<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<u32>>,
    Bound<'py, PyDict>,
    Option<Bound<'py, PyArray1<u32>>>,
);

fn foreign(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("greenstick._foreign")
}

/// Reads indices of vertices.
fn indices(given: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Vec<[u32; 3]>> {
    let expected = Expected {
        name: "triangles",
        columns: 3,
        dtype: "int64",
        kinds: "iu",
    };
    let (flat, _) = arrays::rows::<i64>(given, &expected)?;
    if let Some(at) = flat.iter().position(|&i| i < 0 || i >= vertices as i64) {
        let (row, column, found) = (at / 3, at % 3, flat[at]);
        return Err(Failure::value(format!(
            "triangles[{row}, {column}] is {found}; there are {vertices} vertices"
        ))
        .into());
    }
    let corner = |c: &[i64]| [c[0] as u32, c[1] as u32, c[2] as u32];
    Ok(flat.chunks_exact(3).map(corner).collect())
}

/// Reads materials of triangles.
fn material_numbers(given: &Bound<'_, PyAny>, triangles: usize) -> PyResult<Vec<u32>> {
    let column = given
        .py()
        .import("numpy")?
        .call_method1("asarray", (given,))?;
    let column = column.call_method1("reshape", ((-1, 1),))?;
    let expected = Expected {
        name: "materials",
        columns: 1,
        dtype: "int64",
        kinds: "iu",
    };
    let (flat, count) = arrays::rows::<i64>(&column, &expected)?;
    if count != triangles {
        return Err(Failure::value(format!(
            "materials has {count} numbers; expected {triangles}, one for each triangle"
        ))
        .into());
    }
    let number = |&m: &i64| u32::try_from(m).ok();
    let all: Option<Vec<u32>> = flat.iter().map(number).collect();
    Ok(all.ok_or_else(|| {
        Failure::value(format!("materials has numbers beyond 0 to {NO_MATERIAL}"))
    })?)
}

/// Reads an attribute of vertices.
fn attribute(name: &str, given: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Attribute> {
    let array = given
        .py()
        .import("numpy")?
        .call_method1("asarray", (given,))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let width = match shape[..] {
        [n] if n == vertices => 1,
        [n, width] if n == vertices && (1..=16).contains(&width) => width,
        _ => {
            return Err(Failure::value(format!(
                "the attribute {name} has the shape {shape:?}; expected ({vertices}, k), k from 1 to 16"
            ))
            .into());
        }
    };
    let rows = array.call_method1("reshape", ((vertices, width),))?;
    let expected = Expected {
        name: "an attribute",
        columns: width,
        dtype: "float32",
        kinds: "fiu",
    };
    let (data, _) = arrays::rows::<f32>(&rows, &expected)?;
    Ok(Attribute { width, data })
}
