//! Reading PLY meshes.
//!
//! The origin of texture coordinates is at the bottom, as in files of Blender and MeshLab, so that they are flipped.

use super::body::Body;
use super::faces::{FaceColumns, read_faces};
use super::header::parse;
use super::vertices::read_vertices;
use crate::attribute::clean_attributes;
use crate::error::{FormatError, InFile};
use crate::subset::extract;
use glam::DAffine3;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Material, Mesh, Node, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Reads a PLY file.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let header = parse(bytes, file)?;
    let mut body = Body {
        bytes: &bytes[header.body..],
        encoding: header.encoding,
        file,
    };
    let mut scene = Scene::default();
    let mut mesh = None;
    let mut faces = FaceColumns::default();
    for element in &header.elements {
        let row_size = element.min_row_size(header.encoding);
        if row_size == 0 {
            continue;
        }
        file.check_count(&element.name, element.count, row_size, body.bytes.len() + 1)?;
        match (element.name.as_str(), &mut mesh) {
            ("vertex", None) => mesh = Some(read_vertices(&mut body, element, &mut scene.notes)?),
            ("face", Some(mesh)) => {
                faces = read_faces(&mut body, element, mesh, &mut scene.notes)?;
            }
            ("face", None) => {
                let found = "faces before the vertices";
                return Err(file.malformed("header", found, "element vertex first"));
            }
            ("tristrips", _) => {
                return Err(file.unsupported("triangle strips", "save it with separate faces"));
            }
            _ => {
                scene.notes.push(format!(
                    "{} entries of {} were dropped.",
                    element.count, element.name
                ));
                body.skip_element(element)?;
            }
        }
    }
    let Some(mut mesh) = mesh else {
        return Err(file.malformed("header", "no vertices", "`element vertex` with x, y and z"));
    };
    if mesh.triangles.is_empty() && !mesh.positions.is_empty() {
        return Err(FormatError::PointCloud {
            file: name.to_owned(),
            points: mesh.positions.len(),
        });
    }
    clean_attributes(&mut mesh, &mut scene.notes);
    add_nodes(mesh, &faces, &header.comments, &mut scene);
    Ok(scene)
}

/// Adds the mesh to the scene, split by the property `node` of its faces, with the names of nodes and materials from the
/// comments that [`super::write`] adds.
fn add_nodes(mut mesh: Mesh, faces: &FaceColumns, comments: &[String], scene: &mut Scene) {
    let name_of = |kind: &str, number: i64| {
        let prefix = format!("greenstick {kind} {number} ");
        comments
            .iter()
            .find_map(|c| c.strip_prefix(&prefix))
            .unwrap_or_default()
            .to_owned()
    };
    let materials: BTreeSet<i64> = faces
        .materials
        .iter()
        .copied()
        .filter(|&m| m >= 0)
        .collect();
    if !materials.is_empty() {
        let numbers: BTreeMap<i64, u32> = materials.iter().copied().zip(0..).collect();
        scene.materials.extend(materials.iter().map(|&m| Material {
            name: name_of("material", m),
            ..Material::default()
        }));
        mesh.materials = faces
            .materials
            .iter()
            .map(|m| numbers.get(m).copied().unwrap_or(NO_MATERIAL))
            .collect();
    }
    let mut parts: BTreeMap<i64, Vec<u32>> = BTreeMap::new();
    for (t, &node) in faces.nodes.iter().enumerate() {
        parts.entry(node).or_default().push(t as u32);
    }
    let node = |name, mesh| Node {
        name,
        transform: DAffine3::IDENTITY,
        mesh: Arc::new(mesh),
        parent: None,
        is_detail: false,
    };
    if parts.len() < 2 {
        let number = parts.keys().next().copied().unwrap_or(0);
        scene.nodes.push(node(name_of("node", number), mesh));
        return;
    }
    let mut slots = vec![u32::MAX; mesh.positions.len()];
    for (number, triangles) in parts {
        let part = extract(&mesh, &triangles, &mut slots);
        scene.nodes.push(node(name_of("node", number), part));
    }
}
