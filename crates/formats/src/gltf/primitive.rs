//! Reading meshes and their primitives (§3.7). The primitives of a mesh are joined; each triangle has a material.

use super::accessor::Source;
use super::attributes::join_components;
use super::extensions::draco_error;
use super::schema::Primitive;
use crate::attribute::clean_attributes;
use crate::error::FormatError;
use glam::DVec3;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Mesh, Scene};
use std::collections::BTreeMap;

/// Reads mesh number `index`. Notes are added to the scene.
pub(super) fn read_mesh(
    source: &Source,
    index: usize,
    scene: &mut Scene,
) -> Result<Mesh, FormatError> {
    let meshes = &source.document.meshes;
    let Some(json) = meshes.get(index) else {
        let right = format!("a number below {}", meshes.len());
        return Err(source
            .file
            .malformed(format!("meshes[{index}]"), "does not exist", right));
    };
    let mut mesh = Mesh::default();
    // Primitives may share their vertices, which are then read once.
    let mut ranges: BTreeMap<&BTreeMap<String, usize>, VertexRange> = BTreeMap::new();
    let mut materials = Vec::new();
    for (number, primitive) in json.primitives.iter().enumerate() {
        let place = format!("meshes[{index}].primitives[{number}]");
        let mode = primitive.mode.unwrap_or(4);
        if mode < 4 {
            scene
                .notes
                .push(format!("{place} holds points or lines and was dropped."));
            continue;
        }
        if !primitive.targets.is_empty() {
            scene
                .notes
                .push(format!("Morph targets of {place} were dropped."));
        }
        check_draco(source, primitive)?;
        if !primitive.attributes.contains_key("POSITION") {
            scene
                .notes
                .push(format!("{place} has no POSITION and was dropped."));
            continue;
        }
        let range = match ranges.get(&primitive.attributes) {
            Some(&range) => range,
            None => {
                let base = mesh.positions.len();
                append_vertices(source, primitive, &place, &mut mesh, &mut scene.notes)?;
                let range = VertexRange {
                    base,
                    count: mesh.positions.len() - base,
                };
                ranges.insert(&primitive.attributes, range);
                range
            }
        };
        let before = mesh.triangles.len();
        append_triangles(source, primitive, mode, range, &place, &mut mesh)?;
        let material = match primitive.material {
            None => NO_MATERIAL,
            Some(m) if m < scene.materials.len() => m as u32,
            Some(m) => {
                let right = format!("a number below {}", scene.materials.len());
                return Err(source.file.malformed(place, format!("material {m}"), right));
            }
        };
        materials.extend(std::iter::repeat_n(material, mesh.triangles.len() - before));
    }
    if materials.iter().any(|&m| m != NO_MATERIAL) {
        mesh.materials = materials;
    }
    join_components(&mut mesh);
    clean_attributes(&mut mesh, &mut scene.notes);
    Ok(mesh)
}

/// The vertices of a primitive among those of its mesh.
#[derive(Clone, Copy)]
struct VertexRange {
    base: usize,
    count: usize,
}

/// Refuses primitives whose only data are compressed with Draco.
fn check_draco(source: &Source, primitive: &Primitive) -> Result<(), FormatError> {
    let accessors = &source.document.accessors;
    let lacks_data = primitive
        .attributes
        .get("POSITION")
        .and_then(|&i| accessors.get(i))
        .is_some_and(|a| a.buffer_view.is_none());
    if lacks_data
        && primitive
            .extensions
            .contains_key("KHR_draco_mesh_compression")
    {
        return Err(draco_error(source.file));
    }
    Ok(())
}

/// Appends the vertices of a primitive to the mesh.
fn append_vertices(
    source: &Source,
    primitive: &Primitive,
    place: &str,
    mesh: &mut Mesh,
    notes: &mut Vec<String>,
) -> Result<(), FormatError> {
    let base = mesh.positions.len();
    let mut count = 0;
    for (name, &accessor) in &primitive.attributes {
        if name != "POSITION" {
            continue;
        }
        let (width, data) = source.numbers(accessor)?;
        if width != 3 {
            let found = format!("POSITION of width {width}");
            return Err(source.file.malformed(place, found, "VEC3"));
        }
        count = data.len() / 3;
        mesh.positions.extend(
            data.as_chunks::<3>()
                .0
                .iter()
                .map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())),
        );
    }
    source
        .file
        .check_finite(|| format!("{place} POSITION"), &mesh.positions[base..])?;
    if mesh.positions.len() > NO_MATERIAL as usize {
        let found = format!("{} vertices", mesh.positions.len());
        return Err(source
            .file
            .malformed(place, found, "fewer than 2^32 in a mesh"));
    }
    let names = mesh.attributes.len() + primitive.attributes.len();
    source.charge(names.saturating_mul(12 * mesh.positions.len()), place)?;
    for (name, &accessor) in &primitive.attributes {
        if name == "POSITION" {
            continue;
        }
        if name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_") {
            notes.push(format!("{name} of {place} was dropped."));
            continue;
        }
        let (width, data) = source.numbers(accessor)?;
        let right = match name.as_str() {
            "NORMAL" => width == 3,
            "TANGENT" => width == 4,
            _ => true,
        };
        if !right || data.len() != width * count {
            let found = format!("{} entries of width {width} in {name}", data.len() / width);
            let right = format!("as many as there are positions, {count}");
            return Err(source.file.malformed(place, found, right));
        }
        append_attribute(mesh, name, width, data, base, notes);
    }
    let total = mesh.positions.len();
    for (name, attribute) in &mut mesh.attributes {
        if attribute.data.len() < total * attribute.width {
            notes.push(format!(
                "{place} lacks {name}; it was filled with zeros there."
            ));
            attribute.data.resize(total * attribute.width, 0.0);
        }
    }
    Ok(())
}

/// Appends values of an attribute for the vertices from `base` on.
fn append_attribute(
    mesh: &mut Mesh,
    name: &str,
    width: usize,
    data: Vec<f32>,
    base: usize,
    notes: &mut Vec<String>,
) {
    let count = data.len() / width;
    let Some(attribute) = mesh.attributes.get_mut(name) else {
        let mut all = data;
        if base > 0 {
            notes.push(format!(
                "{name} is absent in some primitives; it was filled with zeros there."
            ));
            all.splice(0..0, std::iter::repeat_n(0.0, base * width));
        }
        mesh.attributes
            .insert(name.to_owned(), Attribute { width, data: all });
        return;
    };
    // Colours without alpha become opaque; other missing components become 0.
    let absent = if name.starts_with("COLOR_") { 1.0 } else { 0.0 };
    let widen = |data: &[f32], from: usize, to: usize| -> Vec<f32> {
        let element = |v: &[f32]| -> Vec<f32> {
            (0..to)
                .map(|k| v.get(k).copied().unwrap_or(absent))
                .collect()
        };
        data.chunks_exact(from).flat_map(element).collect()
    };
    let common = width.max(attribute.width);
    if attribute.width < common {
        attribute.data = widen(&attribute.data, attribute.width, common);
        attribute.width = common;
    }
    if width < common {
        attribute.data.extend(widen(&data, width, common));
    } else {
        attribute.data.extend(data);
    }
    debug_assert_eq!(attribute.data.len(), (base + count) * common);
}

/// Appends the triangles of a primitive to the mesh.
fn append_triangles(
    source: &Source,
    primitive: &Primitive,
    mode: u32,
    range: VertexRange,
    place: &str,
    mesh: &mut Mesh,
) -> Result<(), FormatError> {
    let VertexRange { base, count } = range;
    let indices = match primitive.indices {
        Some(accessor) => source.integers(accessor)?,
        None => (0..count as u32).collect(),
    };
    if let Some(at) = indices.iter().position(|&i| i as usize >= count) {
        return Err(FormatError::IndexOutOfRange {
            file: source.file.0.to_owned(),
            element: format!("{place} (counted from 0)"),
            face: if mode == 4 {
                at / 3
            } else {
                at.saturating_sub(2)
            },
            index: indices[at].into(),
            count,
        });
    }
    source.charge(4 * indices.len(), place)?;
    let base = base as u32;
    let corner = |i: usize| base + indices[i];
    let strip = indices.len().saturating_sub(2);
    match mode {
        4 if !indices.len().is_multiple_of(3) => {
            let found = format!("{} indices", indices.len());
            return Err(source.file.malformed(place, found, "a multiple of 3"));
        }
        4 => mesh.triangles.extend(
            indices
                .as_chunks::<3>()
                .0
                .iter()
                .map(|t| t.map(|i| base + i)),
        ),
        // Every second triangle of a strip has the opposite orientation (§3.7.2.1).
        5 => mesh.triangles.extend((0..strip).map(|i| {
            let (b, c) = (i + 1 + i % 2, i + 2 - i % 2);
            [corner(i), corner(b), corner(c)]
        })),
        6 => mesh
            .triangles
            .extend((0..strip).map(|i| [corner(i + 1), corner(i + 2), corner(0)])),
        other => {
            return Err(source
                .file
                .malformed(place, format!("mode {other}"), "a mode up to 6"));
        }
    }
    Ok(())
}
