//! Reading the node hierarchy (§3.5), which is flattened.

use super::accessor::Source;
use super::primitive;
use super::schema::Node as NodeJson;
use crate::error::FormatError;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use greenstick_geometry::{Mesh, Node, Scene};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

/// Most vertices and triangles of a scene, with every instance counted. An instance takes only a few bytes in the file, so
/// that nothing else bounds the size of the scene.
const MAX_EXPANDED_SIZE: usize = 1 << 27;

/// Reads the nodes of the default scene in depth-first order.
pub(super) fn read(source: &Source, scene: &mut Scene) -> Result<(), FormatError> {
    let nodes = &source.document.nodes;
    let mut visited = vec![false; nodes.len()];
    let mut stack: Vec<Pending> = roots(source)?
        .into_iter()
        .rev()
        .map(|node| Pending {
            node,
            above: DAffine3::IDENTITY,
            parent: None,
        })
        .collect();
    let mut placements: Vec<Placement> = Vec::new();
    let mut dropped = [("skins", 0), ("cameras", 0), ("lights", 0)];
    while let Some(Pending {
        node: index,
        above,
        parent,
    }) = stack.pop()
    {
        let place = || format!("nodes[{index}]");
        let Some(json) = nodes.get(index) else {
            let right = format!("a number below {}", nodes.len());
            return Err(source.file.malformed(place(), "does not exist", right));
        };
        if std::mem::replace(&mut visited[index], true) {
            let found = "reached a second time";
            return Err(source
                .file
                .malformed(place(), found, "nodes that form a tree"));
        }
        let transform = above * local(json);
        if !transform.is_finite() {
            let found = "a transform that is not finite";
            return Err(source.file.malformed(place(), found, "finite numbers"));
        }
        dropped[0].1 += usize::from(json.skin.is_some());
        dropped[1].1 += usize::from(json.camera.is_some());
        dropped[2].1 += usize::from(json.extensions.contains_key("KHR_lights_punctual"));
        let mut below = parent;
        if let Some(mesh) = json.mesh {
            below = Some(placements.len());
            placements.push(Placement {
                name: &json.name,
                mesh,
                transform,
                parent,
            });
        }
        stack.extend(json.children.iter().rev().map(|&node| Pending {
            node,
            above: transform,
            parent: below,
        }));
    }
    for (kind, count) in dropped {
        if count > 0 {
            scene.notes.push(format!("{count} {kind} were dropped."));
        }
    }
    add_nodes(source, &placements, scene)
}

/// A node that is still to be visited.
struct Pending {
    node: usize,
    /// Transform of its parent to the world.
    above: DAffine3,
    /// The nearest placement above it.
    parent: Option<usize>,
}

/// A mesh in the world; `parent` is another placement.
struct Placement<'a> {
    name: &'a str,
    mesh: usize,
    transform: DAffine3,
    parent: Option<usize>,
}

/// Reads each mesh once and adds a node for each placement; instances of a mesh share it.
fn add_nodes(
    source: &Source,
    placements: &[Placement],
    scene: &mut Scene,
) -> Result<(), FormatError> {
    let mut meshes: BTreeMap<usize, Arc<Mesh>> = BTreeMap::new();
    let mut expanded = 0_usize;
    for placement in placements {
        let index = placement.mesh;
        let mesh = match meshes.entry(index) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                entry.insert(Arc::new(primitive::read_mesh(source, index, scene)?))
            }
        };
        expanded = expanded.saturating_add(mesh.positions.len() + mesh.triangles.len());
        if expanded > MAX_EXPANDED_SIZE {
            let found = format!("more than {MAX_EXPANDED_SIZE} vertices and triangles");
            let right = "fewer, with every instance counted";
            return Err(source.file.malformed("nodes", found, right));
        }
    }
    // Node of each placement; the children of one without triangles become those of its parent.
    let mut numbers: Vec<Option<usize>> = Vec::with_capacity(placements.len());
    for placement in placements {
        let parent = placement.parent.and_then(|p| numbers[p]);
        let mesh = meshes.get(&placement.mesh).cloned().unwrap_or_default();
        if mesh.triangles.is_empty() {
            numbers.push(parent);
            continue;
        }
        numbers.push(Some(scene.nodes.len()));
        let name = match placement.name {
            "" => source.document.meshes[placement.mesh].name.clone(),
            name => name.to_owned(),
        };
        scene.nodes.push(Node {
            name,
            transform: placement.transform,
            mesh,
            parent,
            is_detail: false,
        });
    }
    Ok(())
}

/// Root nodes of the default scene, or of the first scene if none is the default; all roots if there are no scenes.
fn roots(source: &Source) -> Result<Vec<usize>, FormatError> {
    let document = source.document;
    match document.scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if document.scenes.is_empty() => {
            let mut is_child = vec![false; document.nodes.len()];
            for &child in document.nodes.iter().flat_map(|n| &n.children) {
                if let Some(flag) = is_child.get_mut(child) {
                    *flag = true;
                }
            }
            Ok((0..is_child.len()).filter(|&i| !is_child[i]).collect())
        }
        None => {
            let right = format!("a number below {}", document.scenes.len());
            Err(source
                .file
                .malformed("scene", "refers to a scene that does not exist", right))
        }
    }
}

/// The transform of a node relative to its parent.
fn local(node: &NodeJson) -> DAffine3 {
    if let Some(m) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(m));
    }
    let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
    // Rotations may be unit quaternions in single precision only.
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let rotation = if rotation.length_squared() > 0.0 {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    };
    DAffine3 {
        matrix3: DMat3::from_quat(rotation) * DMat3::from_diagonal(scale),
        translation: DVec3::from_array(node.translation.unwrap_or_default()),
    }
}
