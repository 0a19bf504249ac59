//! The node hierarchy (§3.5), flattened.

use super::accessor::Source;
use super::primitive;
use super::schema::Node as NodeJson;
use crate::error::FormatError;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use greenstick_geometry::{Mesh, Node, Scene};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

/// Vertices and triangles that a scene may hold once its instances are copied out. A mesh placed a million times is
/// a few bytes each in the file, so that nothing else bounds the memory.
const MOST_EXPANDED: usize = 1 << 27;

/// Reads the nodes of the default scene in depth-first order.
pub fn read(source: &Source, scene: &mut Scene) -> Result<(), FormatError> {
    let nodes = &source.document.nodes;
    let mut visited = vec![false; nodes.len()];
    // Index, transform of the parent, and the placement that carries it.
    let mut stack: Vec<(usize, DAffine3, Option<usize>)> = roots(source)?
        .into_iter()
        .rev()
        .map(|i| (i, DAffine3::IDENTITY, None))
        .collect();
    let mut placements: Vec<Placement> = Vec::new();
    let mut dropped = [("skins", 0), ("cameras", 0), ("lights", 0)];
    while let Some((index, above, parent)) = stack.pop() {
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
        let mut carrier = parent;
        if let Some(mesh) = json.mesh {
            carrier = Some(placements.len());
            placements.push(Placement {
                name: &json.name,
                mesh,
                transform,
                parent,
            });
        }
        stack.extend(
            json.children
                .iter()
                .rev()
                .map(|&child| (child, transform, carrier)),
        );
    }
    for (what, count) in dropped {
        if count > 0 {
            scene.notes.push(format!("{count} {what} were dropped."));
        }
    }
    place(source, &placements, scene)
}

/// A mesh at its place; `parent` is another placement.
struct Placement<'a> {
    name: &'a str,
    mesh: usize,
    transform: DAffine3,
    parent: Option<usize>,
}

/// Reads each mesh once and puts it wherever it is used.
fn place(source: &Source, placements: &[Placement], scene: &mut Scene) -> Result<(), FormatError> {
    let mut meshes: BTreeMap<usize, Arc<Mesh>> = BTreeMap::new();
    let mut expanded = 0_usize;
    for placement in placements {
        let index = placement.mesh;
        let mesh = match meshes.entry(index) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(free) => {
                free.insert(Arc::new(primitive::read_mesh(source, index, scene)?))
            }
        };
        expanded = expanded.saturating_add(mesh.positions.len() + mesh.triangles.len());
        if expanded > MOST_EXPANDED {
            let found = format!("more than {MOST_EXPANDED} vertices and triangles");
            let right = "fewer, instances counted each";
            return Err(source.file.malformed("nodes", found, right));
        }
    }
    // Scene node of each placement; one without triangles passes its children up.
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
        });
    }
    Ok(())
}

/// Root nodes of the default scene; of the first one where none is named; all roots where there are no scenes.
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
                .malformed("scene", "names a scene that does not exist", right))
        }
    }
}

fn local(node: &NodeJson) -> DAffine3 {
    if let Some(m) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(m));
    }
    let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
    // Readers have to cope with rotations that are unit quaternions in 32 bits only.
    let turn = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let turn = if turn.length_squared() > 0.0 {
        turn.normalize()
    } else {
        DQuat::IDENTITY
    };
    DAffine3 {
        matrix3: DMat3::from_quat(turn) * DMat3::from_diagonal(scale),
        translation: DVec3::from_array(node.translation.unwrap_or_default()),
    }
}
