//! Writing binary PLY, little-endian: all nodes in world coordinates as one mesh, distinguished by the property `node` of
//! the faces.

use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use crate::position::{in_world, to_f32};
use crate::unit::LengthUnit;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Mesh, Scene};
use std::collections::BTreeMap;

/// The source of a vertex property.
struct Column {
    property: String,
    attribute: String,
    component: usize,
    /// The value if a mesh lacks the attribute.
    default: f32,
}

/// The vertex properties besides positions.
fn columns(scene: &Scene) -> Vec<Column> {
    let mut widths: BTreeMap<&str, usize> = BTreeMap::new();
    for node in &scene.nodes {
        for (name, attribute) in &node.mesh.attributes {
            let width = widths.entry(name).or_default();
            *width = attribute.width.max(*width);
        }
    }
    let mut columns = Vec::new();
    let mut add = |attribute: &str, properties: &[&str], default: f32| {
        columns.extend(
            properties
                .iter()
                .enumerate()
                .map(|(component, property)| Column {
                    property: (*property).to_owned(),
                    attribute: attribute.to_owned(),
                    component,
                    default,
                }),
        );
    };
    if widths.contains_key("NORMAL") {
        add("NORMAL", &["nx", "ny", "nz"], 0.0);
    }
    if widths.get("TEXCOORD_0").is_some_and(|&w| w >= 2) {
        add("TEXCOORD_0", &["s", "t"], 0.0);
    }
    match widths.get("COLOR_0") {
        Some(3) => add("COLOR_0", &["red", "green", "blue"], 1.0),
        Some(4) => add("COLOR_0", &["red", "green", "blue", "alpha"], 1.0),
        _ => {}
    }
    for (name, &width) in widths.iter().filter(|(name, _)| name.starts_with('_')) {
        let safe: String = name
            .chars()
            .map(|c| if c.is_ascii_graphic() { c } else { '_' })
            .collect();
        if width == 1 {
            add(name, &[&safe], 0.0);
        } else {
            let names: Vec<String> = (0..width).map(|k| format!("{safe}_{k}")).collect();
            add(
                name,
                &names.iter().map(String::as_str).collect::<Vec<_>>(),
                0.0,
            );
        }
    }
    columns
}

/// The header of the file; `counts` are those of vertices and faces.
fn header(scene: &Scene, columns: &[Column], unit: LengthUnit, counts: [usize; 2]) -> String {
    let mut text =
        format!("ply\nformat binary_little_endian 1.0\ncomment by Greenstick, in {unit}\n");
    for line in scene.metadata.lines() {
        text += &format!("comment {line}\n");
    }
    let nodes = scene.nodes.iter().map(|n| ("node", &n.name));
    let materials = scene.materials.iter().map(|m| ("material", &m.name));
    for (number, (kind, name)) in nodes.enumerate().chain(materials.enumerate()) {
        if !name.is_empty() {
            let name = name.replace(char::is_control, " ");
            text += &format!("comment greenstick {kind} {number} {name}\n");
        }
    }
    text += &format!("element vertex {}\n", counts[0]);
    for name in ["x", "y", "z"]
        .into_iter()
        .chain(columns.iter().map(|c| c.property.as_str()))
    {
        text += &format!("property float {name}\n");
    }
    text += &format!(
        "element face {}\nproperty list uchar int vertex_indices\n",
        counts[1]
    );
    text += "property int node\nproperty int material\nend_header\n";
    text
}

/// Writes a PLY file.
pub(crate) fn write(
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let columns = columns(scene);
    let total = |count: fn(&Mesh) -> usize| scene.nodes.iter().map(|n| count(&n.mesh)).sum();
    let counts: [usize; 2] = [total(|m| m.positions.len()), total(|m| m.triangles.len())];
    if i32::try_from(counts[0]).is_err() {
        return Err(file.unwritable(format!("{} vertices", counts[0]), "fewer than 2^31 in PLY"));
    }
    let mut bytes = header(scene, &columns, unit, counts).into_bytes();
    bytes.reserve(counts[0] * (12 + 4 * columns.len()) + counts[1] * 21);
    let mut faces = Vec::with_capacity(counts[1] * 21);
    let mut base = 0;
    for (number, node) in scene.nodes.iter().enumerate() {
        let mesh = in_world(node, unit);
        let sources: Vec<_> = columns
            .iter()
            .map(|c| {
                let attribute = mesh.attributes.get(&c.attribute);
                (attribute.filter(|a| c.component < a.width), c)
            })
            .collect();
        for (i, &p) in mesh.positions.iter().enumerate() {
            for v in to_f32(p, file)? {
                bytes.extend_from_slice(&v.to_le_bytes());
            }
            for (source, column) in &sources {
                let value =
                    source.map_or(column.default, |a| a.data[i * a.width + column.component]);
                let value = if column.property == "t" {
                    1.0 - value
                } else {
                    value
                };
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        }
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            faces.push(3);
            for &i in triangle {
                faces.extend_from_slice(&(base + i).to_le_bytes());
            }
            faces.extend_from_slice(&(number as u32).to_le_bytes());
            let material = match mesh.material(t) {
                NO_MATERIAL => -1,
                m => m as i32,
            };
            faces.extend_from_slice(&material.to_le_bytes());
        }
        base += mesh.positions.len() as u32;
    }
    bytes.append(&mut faces);
    Ok(vec![Encoded {
        name: name.to_owned(),
        bytes,
    }])
}
