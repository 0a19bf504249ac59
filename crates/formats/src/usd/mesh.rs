//! Meshes as prims: points, faces, vertex attributes, and bindings to materials.

use super::layer::{Prim, Property, Value};
use super::material::{Materials, coordinate_set};
use crate::error::{FormatError, InFile};
use crate::gltf::prepared_attributes;
use crate::position::to_f32;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Material, Mesh};
use std::collections::BTreeMap;

/// A mesh as a prim.
pub(super) struct MeshPrim {
    /// The prim.
    pub prim: Prim,
    /// Unit normals; empty for a mesh without normals.
    pub normals: Vec<[f32; 3]>,
}

/// For each material, whether a mesh with vertex colours uses it.
pub(super) fn coloured_materials<'a>(
    meshes: impl Iterator<Item = &'a Mesh>,
    materials: usize,
) -> Vec<bool> {
    let mut coloured = vec![false; materials];
    for mesh in meshes.filter(|m| m.attributes.contains_key("COLOR_0")) {
        for &m in &mesh.materials {
            if let Some(flag) = coloured.get_mut(m as usize) {
                *flag = true;
            }
        }
    }
    coloured
}

/// Converts a valid mesh to a prim.
pub(super) fn write(
    mesh: &Mesh,
    name: String,
    materials: &[Material],
    library: &Materials,
    file: InFile,
) -> Result<MeshPrim, FormatError> {
    let mut prim = Prim::new(name, "Mesh");
    let rounded = mesh.positions.iter().map(|&p| to_f32(p, file));
    let points = rounded.collect::<Result<Vec<_>, _>>()?;
    let index = |i: u32| {
        i32::try_from(i).map_err(|_| file.unwritable(format!("vertex {i}"), "at most 2147483647"))
    };
    let corners = mesh.triangles.as_flattened().iter().map(|&i| index(i));
    let corners = corners.collect::<Result<Vec<_>, _>>()?;
    let is_double_sided = |m: u32| materials.get(m as usize).is_some_and(|m| m.double_sided);
    let list = &mut prim.properties;
    if mesh.materials.iter().any(|&m| is_double_sided(m)) {
        list.push(Property::uniform("doubleSided", "bool", Value::Bool(true)));
    }
    let scheme = Value::Token("none".to_owned());
    list.push(Property::uniform("subdivisionScheme", "token", scheme));
    list.push(Property::new(
        "extent",
        "float3[]",
        Value::Float3s(extent(&points)),
    ));
    let counts = Value::Ints(vec![3; mesh.triangles.len()]);
    list.push(Property::new("faceVertexCounts", "int[]", counts));
    list.push(Property::new(
        "faceVertexIndices",
        "int[]",
        Value::Ints(corners),
    ));
    list.push(Property::new("points", "point3f[]", Value::Float3s(points)));
    let normals = write_attributes(mesh, materials, list);
    bind_materials(mesh, &mut prim, library);
    Ok(MeshPrim { prim, normals })
}

/// The smallest and the largest coordinates.
pub(super) fn extent(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let Some(&first) = points.first() else {
        return Vec::new();
    };
    let (mut low, mut high) = (first, first);
    for p in points {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    vec![low, high]
}

/// Writes vertex attributes. Returns the normals.
fn write_attributes(
    mesh: &Mesh,
    materials: &[Material],
    list: &mut Vec<Property>,
) -> Vec<[f32; 3]> {
    let all: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let by_vertex = || Value::Token("vertex".to_owned());
    let mut normals = Vec::new();
    for (name, Attribute { width, data }) in prepared_attributes(mesh, &all, &mesh.triangles, 0) {
        let property = match name.as_str() {
            "NORMAL" => {
                normals = data.as_chunks::<3>().0.to_vec();
                Property::new("normals", "normal3f[]", Value::Float3s(normals.clone()))
            }
            // Readers compute tangents from normals and texture coordinates.
            "TANGENT" => continue,
            "COLOR_0" => {
                let colours = Value::Float3s(colours(mesh, materials, width, &data));
                Property::new("primvars:displayColor", "color3f[]", colours)
            }
            _ => match name.strip_prefix("TEXCOORD_").and_then(|n| n.parse().ok()) {
                Some(set) => {
                    let pairs = data.as_chunks::<2>().0.iter();
                    let pairs = Value::Float2s(pairs.map(|[u, v]| [*u, 1.0 - v]).collect());
                    let name = format!("primvars:{}", coordinate_set(set));
                    Property::new(name, "texCoord2f[]", pairs)
                }
                None => {
                    let replace = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
                    let name: String = name.chars().map(replace).collect();
                    let (kind, value) = match width {
                        1 => ("float[]", Value::Floats(data)),
                        2 => ("float2[]", Value::Float2s(data.as_chunks().0.to_vec())),
                        3 => ("float3[]", Value::Float3s(data.as_chunks().0.to_vec())),
                        4 => ("float4[]", Value::Float4s(data.as_chunks().0.to_vec())),
                        _ => continue,
                    };
                    Property::new(format!("primvars:{name}"), kind, value)
                }
            },
        };
        list.push(property.with("interpolation", by_vertex()));
    }
    normals
}

/// Vertex colours multiplied by the colour of the material of the first triangle at each vertex: a preview surface takes only
/// one of both.
fn colours(mesh: &Mesh, materials: &[Material], width: usize, data: &[f32]) -> Vec<[f32; 3]> {
    let mut tint = vec![[1.0_f32; 3]; mesh.positions.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate().rev() {
        if let Some(material) = materials.get(mesh.material(t) as usize) {
            let [r, g, b, _] = material.base_color;
            for &v in triangle {
                tint[v as usize] = [r, g, b].map(|c| if c.is_nan() { 0.0 } else { c });
            }
        }
    }
    let own = data.chunks_exact(width);
    own.zip(tint)
        .map(|(c, t)| [c[0] * t[0], c[1] * t[1], c[2] * t[2]])
        .collect()
}

/// Binds the prim to its only material, or subsets of its faces to each material.
fn bind_materials(mesh: &Mesh, prim: &mut Prim, library: &Materials) {
    let mut faces: BTreeMap<u32, Vec<i32>> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        faces.entry(mesh.material(t)).or_default().push(t as i32);
    }
    let binding = |m: u32| {
        let path = library.paths.get(m as usize)?;
        Some(Property::relationship("material:binding", path.clone()))
    };
    if let (1, Some((&only, _))) = (faces.len(), faces.first_key_value()) {
        if let Some(binding) = binding(only) {
            prim.properties.push(binding);
            prim.apply("MaterialBindingAPI");
        }
        return;
    }
    let covers_all = !faces.contains_key(&NO_MATERIAL);
    for (m, list) in faces {
        let Some(binding) = binding(m) else {
            continue;
        };
        let word = |w: &str| Value::Token(w.to_owned());
        let mut part = Prim::new(format!("material_{m}"), "GeomSubset");
        part.apply("MaterialBindingAPI");
        part.properties = vec![
            Property::uniform("elementType", "token", word("face")),
            Property::uniform("familyName", "token", word("materialBind")),
            Property::new("indices", "int[]", Value::Ints(list)),
            binding,
        ];
        prim.children.push(part);
    }
    let family = if covers_all {
        "partition"
    } else {
        "nonOverlapping"
    };
    prim.apply("MaterialBindingAPI");
    prim.properties.push(Property::uniform(
        "subsetFamily:materialBind:familyType",
        "token",
        Value::Token(family.to_owned()),
    ));
}
