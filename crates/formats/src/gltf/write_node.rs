//! Writing nodes with their hierarchy (§3.5).

use super::builder::Builder;
use super::write_mesh::write_mesh;
use crate::error::{FormatError, InFile};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Material, Mesh, Node};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Writes nodes with their meshes. Returns the root nodes. These must be the first nodes that are written.
pub(super) fn write_nodes(
    nodes: &[Node],
    materials: &[Material],
    builder: &mut Builder,
    file: InFile,
) -> Result<Vec<usize>, FormatError> {
    let hierarchy = Hierarchy::new(nodes);
    // Instances of a mesh share it in the file, unless the transform goes into the vertices.
    let mut shared: BTreeMap<*const Mesh, usize> = BTreeMap::new();
    for (i, node) in nodes.iter().enumerate() {
        let mut out = Map::new();
        if !node.name.is_empty() {
            out.insert("name".to_owned(), json!(node.name));
        }
        let children = &hierarchy.children[i];
        if !children.is_empty() {
            out.insert("children".to_owned(), json!(children));
        }
        put_transform(&mut out, &hierarchy.locals[i]);
        if !node.mesh.triangles.is_empty() {
            let key = Arc::as_ptr(&node.mesh);
            let written = shared.get(&key).filter(|_| !hierarchy.baked[i]);
            let mesh = match written {
                Some(&mesh) => mesh,
                None if hierarchy.baked[i] => {
                    let mesh = node.mesh.transformed(&node.transform);
                    write_mesh(&mesh, &node.name, materials, builder, file)?
                }
                None => {
                    let mesh = write_mesh(&node.mesh, &node.name, materials, builder, file)?;
                    shared.insert(key, mesh);
                    mesh
                }
            };
            out.insert("mesh".to_owned(), json!(mesh));
        }
        builder.push("nodes", Value::Object(out));
    }
    Ok(hierarchy.roots)
}

/// The hierarchy of nodes as it is written.
struct Hierarchy {
    /// Whether the transform of a node goes into its vertices, because a node of glTF cannot have it.
    baked: Vec<bool>,
    /// Transform of each node relative to its parent, or to the world for roots.
    locals: Vec<DAffine3>,
    children: Vec<Vec<usize>>,
    roots: Vec<usize>,
}

impl Hierarchy {
    fn new(nodes: &[Node]) -> Self {
        let mut hierarchy = Hierarchy {
            baked: nodes.iter().map(|n| !decomposes(&n.transform)).collect(),
            locals: Vec::with_capacity(nodes.len()),
            children: vec![Vec::new(); nodes.len()],
            roots: Vec::new(),
        };
        let global = |i: usize, baked: &[bool]| {
            if baked[i] {
                DAffine3::IDENTITY
            } else {
                nodes[i].transform
            }
        };
        for (i, parent) in parents(nodes).into_iter().enumerate() {
            let own = global(i, &hierarchy.baked);
            match parent.and_then(|p| Some((p, relative(own, global(p, &hierarchy.baked))?))) {
                Some((parent, local)) => {
                    hierarchy.children[parent].push(i);
                    hierarchy.locals.push(local);
                }
                None => {
                    hierarchy.roots.push(i);
                    hierarchy.locals.push(own);
                }
            }
        }
        hierarchy
    }
}

/// The transform of a node relative to its parent, given both to the world, if a node of glTF can have it.
fn relative(own: DAffine3, parent: DAffine3) -> Option<DAffine3> {
    if parent.matrix3.determinant() == 0.0 {
        return None;
    }
    let local = if parent == own {
        DAffine3::IDENTITY
    } else {
        parent.inverse() * own
    };
    decomposes(&local).then_some(local)
}

/// The state of a node in the search for cycles.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Unvisited,
    /// On the path from the node where the search started.
    OnPath,
    /// The path from here ends at a root.
    Done,
}

/// The parents of nodes, except those that do not exist or form a cycle.
fn parents(nodes: &[Node]) -> Vec<Option<usize>> {
    let count = nodes.len();
    let parent = |i: usize| nodes[i].parent.filter(|&p| p < count && p != i);
    let mut states = vec![State::Unvisited; count];
    let mut out: Vec<Option<usize>> = (0..count).map(parent).collect();
    for start in 0..count {
        let mut path = Vec::new();
        let mut at = start;
        while states[at] == State::Unvisited {
            states[at] = State::OnPath;
            path.push(at);
            match out[at] {
                Some(p) if states[p] == State::OnPath => out[at] = None,
                Some(p) => at = p,
                None => {}
            }
        }
        path.into_iter().for_each(|i| states[i] = State::Done);
    }
    out
}

/// Whether the matrix is translation · rotation · scale, as §3.5.3 requires: its columns are perpendicular.
fn decomposes(map: &DAffine3) -> bool {
    let m = map.matrix3;
    let perpendicular = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-7 * a.length() * b.length();
    perpendicular(m.x_axis, m.y_axis)
        && perpendicular(m.y_axis, m.z_axis)
        && perpendicular(m.z_axis, m.x_axis)
}

/// Adds the transform of a node.
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
    // A matrix is exact; a quaternion would round.
    let matrix = glam::DMat4::from(*local).to_cols_array();
    out.insert("matrix".to_owned(), json!(matrix));
}
