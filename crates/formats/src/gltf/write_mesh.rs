//! Writing meshes, with one primitive for each material (§3.7).

use super::attributes::prepared_attributes;
use super::builder::Builder;
use crate::check::textures_of;
use crate::error::{FormatError, InFile};
use crate::position::to_f32;
use crate::subset::compact;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Material, Mesh};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Adds further attributes to a primitive with the given vertices.
pub(super) type Decorate<'a> = &'a mut dyn FnMut(&mut Builder, &[u32], &mut Map<String, Value>);

/// Writes a mesh. Returns its index.
pub(super) fn write_mesh(
    mesh: &Mesh,
    name: &str,
    materials: &[Material],
    builder: &mut Builder,
    file: InFile,
) -> Result<usize, FormatError> {
    write_decorated_mesh(mesh, name, materials, builder, file, &mut |_, _, _| {})
}

/// Writes a mesh with further attributes. Returns its index.
pub(super) fn write_decorated_mesh(
    mesh: &Mesh,
    name: &str,
    materials: &[Material],
    builder: &mut Builder,
    file: InFile,
    decorate: Decorate,
) -> Result<usize, FormatError> {
    // Primitives are in the order in which triangles first use their materials.
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
            .map(|&i| to_f32(mesh.positions[i as usize], file))
            .collect::<Result<Vec<_>, _>>()?;
        let mut attributes = Map::new();
        attributes.insert("POSITION".to_owned(), json!(builder.positions(&points)));
        let sets = materials.get(material as usize).map_or(0, coordinate_sets);
        for (name, attribute) in prepared_attributes(mesh, &used, &triangles, sets) {
            let accessor = builder.floats(&attribute.data, attribute.width);
            attributes.insert(name, json!(accessor));
        }
        decorate(builder, &used, &mut attributes);
        let mut primitive = json!({
            "attributes": attributes, "indices": builder.indices(&triangles, used.len())
        });
        if material != NO_MATERIAL {
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

/// The number of sets of texture coordinates that a material reads.
fn coordinate_sets(material: &Material) -> u32 {
    let sets = textures_of(material).map(|t| t.coordinates.saturating_add(1));
    sets.max().unwrap_or(0).min(16)
}
