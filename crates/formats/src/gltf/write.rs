//! Writing glTF and GLB: nodes with their hierarchy, one primitive for each material.

use super::{container, vertices, write_material};
use crate::Encoded;
use crate::assemble::{CompanionNames, Surfaces, compact, narrow, textures_of};
use crate::error::{FormatError, InFile};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Material, Mesh, Node, Scene};
use serde_json::{Map, Value, json};

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;

/// The document under construction.
#[derive(Default)]
pub struct Builder {
    lists: BTreeMap<&'static str, Vec<Value>>,
    binary: Vec<u8>,
    companions: Vec<Encoded>,
    used: BTreeSet<String>,
    required: BTreeSet<String>,
}

impl Builder {
    /// Appends to a top-level list and returns the index.
    pub fn push(&mut self, list: &'static str, value: Value) -> usize {
        let entries = self.lists.entry(list).or_default();
        entries.push(value);
        entries.len() - 1
    }

    /// Notes that an extension is used.
    pub fn uses(&mut self, extension: &str, required: bool) {
        self.used.insert(extension.to_owned());
        if required {
            self.required.insert(extension.to_owned());
        }
    }

    /// Adds a file.
    pub fn companion(&mut self, name: String, bytes: Vec<u8>) {
        self.companions.push(Encoded { name, bytes });
    }

    /// Stores bytes in a buffer view of their own, and returns its index.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.view_with(target, |binary| binary.extend_from_slice(bytes))
    }

    fn view_with(&mut self, target: Option<u32>, fill: impl FnOnce(&mut Vec<u8>)) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        fill(&mut self.binary);
        let mut view = json!({
            "buffer": 0, "byteOffset": offset, "byteLength": self.binary.len() - offset
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.push("bufferViews", view)
    }

    /// Stores vertex data.
    pub fn floats(&mut self, data: &[f32], width: usize) -> usize {
        self.numbers(data, width, Some(ARRAY_BUFFER))
    }

    /// Stores matrices that are not vertex data, by columns.
    pub fn matrices(&mut self, data: &[[f32; 16]]) -> usize {
        self.numbers(data.as_flattened(), 16, None)
    }

    /// Stores small whole numbers of vertices, four for each, in as few bytes as they need.
    pub fn joints(&mut self, data: &[[u16; 4]]) -> usize {
        let short = data.as_flattened().iter().all(|&j| j < 256);
        let view = self.view_with(Some(ARRAY_BUFFER), |binary| {
            for &j in data.as_flattened() {
                if short {
                    binary.push(j as u8);
                } else {
                    binary.extend_from_slice(&j.to_le_bytes());
                }
            }
        });
        let code = if short { 5121 } else { 5123 };
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": code, "count": data.len(), "type": "VEC4" }),
        )
    }

    fn numbers(&mut self, data: &[f32], width: usize, target: Option<u32>) -> usize {
        let view = self.view_with(target, |binary| {
            binary.reserve(4 * data.len());
            for v in data {
                binary.extend_from_slice(&v.to_le_bytes());
            }
        });
        let shape = match width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let count = data.len() / width;
        let accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": shape });
        self.push("accessors", accessor)
    }

    fn positions(&mut self, points: &[[f32; 3]]) -> usize {
        let accessor = self.floats(points.as_flattened(), 3);
        let first = points.first().copied().unwrap_or_default();
        let (mut low, mut high) = (first, first);
        for p in points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        if let Some(json) = self
            .lists
            .get_mut("accessors")
            .and_then(|l| l.get_mut(accessor))
        {
            json["min"] = json!(low.map(f64::from));
            json["max"] = json!(high.map(f64::from));
        }
        accessor
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        // 65535 is no index in 16 bits: it restarts primitives (§3.7.2.1).
        let short = vertices <= 65535;
        let view = self.view_with(Some(ELEMENT_ARRAY_BUFFER), |binary| {
            for &i in triangles.as_flattened() {
                if short {
                    binary.extend_from_slice(&(i as u16).to_le_bytes());
                } else {
                    binary.extend_from_slice(&i.to_le_bytes());
                }
            }
        });
        let code = if short { 5123 } else { 5125 };
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": code, "count": 3 * triangles.len(), "type": "SCALAR"
            }),
        )
    }

    /// Length of the binary with its padding.
    pub fn length(&self) -> usize {
        self.binary.len().next_multiple_of(4)
    }

    /// Ends the document: its binary lies at `uri`, or in the file itself, and `further` bytes follow it there.
    pub fn finish(mut self, uri: Option<String>, further: usize) -> Finished {
        self.binary.resize(self.length(), 0);
        let mut buffer = json!({ "byteLength": self.binary.len() + further });
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        self.push("buffers", buffer);
        let mut document = Map::new();
        document.insert(
            "asset".to_owned(),
            json!({ "version": "2.0", "generator": "Greenstick" }),
        );
        document.insert("scene".to_owned(), json!(0));
        for (key, list) in self.lists {
            document.insert(key.to_owned(), Value::Array(list));
        }
        for (key, set) in [
            ("extensionsUsed", self.used),
            ("extensionsRequired", self.required),
        ] {
            if !set.is_empty() {
                document.insert(key.to_owned(), json!(set));
            }
        }
        Finished {
            json: Value::Object(document).to_string().into_bytes(),
            binary: self.binary,
            companions: self.companions,
        }
    }
}

/// A document that is complete.
pub struct Finished {
    /// The JSON.
    pub json: Vec<u8>,
    /// The binary, a multiple of 4 bytes.
    pub binary: Vec<u8>,
    /// Files besides.
    pub companions: Vec<Encoded>,
}

/// Writes a `.glb`, or a `.gltf` with its companions.
pub(crate) fn write(scene: &Scene, name: &str, glb: bool) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let surfaces = Surfaces::of(scene);
    surfaces.check(scene.nodes.iter().map(|n| &*n.mesh), file)?;
    let mut builder = Builder::default();
    let roots = write_nodes(&scene.nodes, scene.materials.as_slice(), &mut builder, file)?;
    builder.push("scenes", json!({ "nodes": roots }));
    let mut names = CompanionNames::new(name);
    let binary_name = names.beside("bin");
    write_material::write(surfaces, &mut builder, (!glb).then_some(names));
    let uri = (!glb).then(|| container::escape(&binary_name));
    let Finished {
        json,
        binary,
        mut companions,
    } = builder.finish(uri, 0);
    if glb {
        let bytes = container::join(json, binary, file)?;
        return Ok(vec![Encoded {
            name: name.to_owned(),
            bytes,
        }]);
    }
    let mut files = vec![
        Encoded {
            name: name.to_owned(),
            bytes: json,
        },
        Encoded {
            name: binary_name,
            bytes: binary,
        },
    ];
    files.append(&mut companions);
    Ok(files)
}

/// Writes placed meshes; gives the nodes that have no parent. Nodes have to be the first that are written.
pub fn write_nodes(
    nodes: &[Node],
    materials: &[Material],
    builder: &mut Builder,
    file: InFile,
) -> Result<Vec<usize>, FormatError> {
    let count = nodes.len();
    let parents = parents(nodes);
    // Where each node ends up in the world; a transform that no matrix of glTF may hold goes into the vertices.
    let baked: Vec<bool> = nodes.iter().map(|n| !decomposes(&n.transform)).collect();
    let global = |i: usize| {
        if baked[i] {
            DAffine3::IDENTITY
        } else {
            nodes[i].transform
        }
    };
    let mut children = vec![Vec::new(); count];
    let mut roots = Vec::new();
    let mut locals = Vec::with_capacity(count);
    for (i, &parent) in parents.iter().enumerate() {
        let relative = parent
            .map(|p| (p, global(p)))
            .filter(|(_, g)| g.matrix3.determinant() != 0.0)
            .map(|(p, g)| {
                (
                    p,
                    if g == global(i) {
                        DAffine3::IDENTITY
                    } else {
                        g.inverse() * global(i)
                    },
                )
            })
            .filter(|(_, local)| decomposes(local));
        match relative {
            Some((p, local)) => {
                children[p].push(i);
                locals.push(local);
            }
            None => {
                roots.push(i);
                locals.push(global(i));
            }
        }
    }
    // Instances of one mesh that are written as they are share it in the file, too.
    let mut shared: BTreeMap<*const Mesh, usize> = BTreeMap::new();
    for (i, node) in nodes.iter().enumerate() {
        let mut out = Map::new();
        if !node.name.is_empty() {
            out.insert("name".to_owned(), json!(node.name));
        }
        if !children[i].is_empty() {
            out.insert("children".to_owned(), json!(children[i]));
        }
        put_transform(&mut out, &locals[i]);
        if !node.mesh.triangles.is_empty() {
            let known = shared.get(&Arc::as_ptr(&node.mesh)).filter(|_| !baked[i]);
            let mesh = match known {
                Some(&mesh) => mesh,
                None => {
                    let mesh = if baked[i] {
                        &Arc::new(node.mesh.transformed(&node.transform))
                    } else {
                        &node.mesh
                    };
                    write_mesh(
                        mesh,
                        &node.name,
                        materials,
                        builder,
                        file,
                        &mut |_, _, _| {},
                    )?
                }
            };
            if !baked[i] {
                shared.insert(Arc::as_ptr(&node.mesh), mesh);
            }
            out.insert("mesh".to_owned(), json!(mesh));
        }
        builder.push("nodes", Value::Object(out));
    }
    Ok(roots)
}

/// Parents that exist and do not go round in circles.
fn parents(nodes: &[Node]) -> Vec<Option<usize>> {
    let count = nodes.len();
    let parent = |i: usize| nodes[i].parent.filter(|&p| p < count && p != i);
    // 0: not looked at, 1: on the way being walked, 2: known to end at a root.
    let mut state = vec![0_u8; count];
    let mut out: Vec<Option<usize>> = (0..count).map(parent).collect();
    for start in 0..count {
        let mut way = Vec::new();
        let mut at = start;
        while state[at] == 0 {
            state[at] = 1;
            way.push(at);
            match out[at] {
                Some(p) if state[p] == 1 => out[at] = None,
                Some(p) => at = p,
                None => {}
            }
        }
        way.into_iter().for_each(|i| state[i] = 2);
    }
    out
}

/// Whether the matrix is translation · rotation · scale, as §3.5.3 demands: its columns are perpendicular.
fn decomposes(map: &DAffine3) -> bool {
    let m = map.matrix3;
    let perpendicular = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-7 * a.length() * b.length();
    perpendicular(m.x_axis, m.y_axis)
        && perpendicular(m.y_axis, m.z_axis)
        && perpendicular(m.z_axis, m.x_axis)
}

fn put_transform(out: &mut Map<String, Value>, local: &DAffine3) {
    let m = local.matrix3;
    let scale = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    if m == glam::DMat3::from_diagonal(scale) {
        if local.translation != DVec3::ZERO {
            out.insert(
                "translation".to_owned(),
                json!(local.translation.to_array()),
            );
        }
        if scale != DVec3::ONE {
            out.insert("scale".to_owned(), json!(scale.to_array()));
        }
        return;
    }
    // A matrix keeps every bit; a quaternion would round.
    let matrix = glam::DMat4::from(*local).to_cols_array();
    out.insert("matrix".to_owned(), json!(matrix));
}

/// Adds attributes of its own to a primitive of the vertices given.
pub type Decorate<'a> = &'a mut dyn FnMut(&mut Builder, &[u32], &mut Map<String, Value>);

/// Writes a mesh and gives its index.
pub fn write_mesh(
    mesh: &Mesh,
    name: &str,
    materials: &[Material],
    builder: &mut Builder,
    file: InFile,
    decorate: Decorate,
) -> Result<usize, FormatError> {
    // Materials in the order in which the triangles first use them.
    let mut order: Vec<u32> = Vec::new();
    let mut parts: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for (t, &triangle) in mesh.triangles.iter().enumerate() {
        let material = mesh.material(t);
        parts
            .entry(material)
            .or_insert_with(|| {
                order.push(material);
                Vec::new()
            })
            .push(triangle);
    }
    let mut slots = vec![u32::MAX; mesh.positions.len()];
    let mut primitives = Vec::with_capacity(order.len());
    for material in order {
        let part = &parts[&material];
        let (used, triangles) = compact(part.iter().copied(), &mut slots);
        let points = used
            .iter()
            .map(|&i| narrow(mesh.positions[i as usize], file))
            .collect::<Result<Vec<_>, _>>()?;
        let mut attributes = Map::new();
        attributes.insert("POSITION".to_owned(), json!(builder.positions(&points)));
        let coordinates = materials.get(material as usize).map_or(0, sets_read);
        for (name, (width, data)) in vertices::attributes(mesh, &used, &triangles, coordinates) {
            attributes.insert(name, json!(builder.floats(&data, width)));
        }
        decorate(builder, &used, &mut attributes);
        let mut primitive = json!({
            "attributes": attributes, "indices": builder.indices(&triangles, used.len())
        });
        if material != greenstick_geometry::mesh::NO_MATERIAL {
            primitive["material"] = json!(material);
        }
        primitives.push(primitive);
    }
    let mut out = json!({ "primitives": primitives });
    if !name.is_empty() {
        out["name"] = json!(name);
    }
    Ok(builder.push("meshes", out))
}

/// How many sets of texture coordinates a material reads.
fn sets_read(material: &Material) -> u32 {
    let sets = textures_of(material).map(|t| t.coordinates.saturating_add(1));
    sets.max().unwrap_or(0).min(16)
}
