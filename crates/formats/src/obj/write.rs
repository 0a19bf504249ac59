//! Writing OBJ: an object for each node, in world coordinates.

use super::material;
use super::material::NO_MATERIAL_NAME;
use crate::companions::Encoded;
use crate::companions::{CompanionNames, image_paths};
use crate::error::{FormatError, InFile};
use crate::position::{in_world, to_f32};
use crate::text::{push_integer, push_number};
use crate::unit::LengthUnit;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Mesh, Node, Scene};

/// Numbers of positions, texture coordinates and normals written so far.
#[derive(Default, Clone, Copy)]
struct Written {
    positions: u64,
    coordinates: u64,
    normals: u64,
    /// The current material, which persists from object to object.
    material: Option<u32>,
}

/// Writes the OBJ file, its MTL file and embedded textures.
pub(crate) fn write(
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let mut companions = CompanionNames::new(name);
    let library = companions.with_extension("mtl");
    let names = material::names(scene);
    let triangles: usize = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
    let comments: String = (scene.metadata.lines())
        .map(|line| format!("# {line}\n"))
        .collect();
    let mut out = Vec::with_capacity(64 * triangles);
    out.extend_from_slice(format!("# by Greenstick, in {unit}\n{comments}").as_bytes());
    if !names.is_empty() {
        let safe = library.replace(char::is_control, "_");
        out.extend_from_slice(format!("mtllib {safe}\n").as_bytes());
    }
    let mut written = Written::default();
    for (number, node) in scene.nodes.iter().enumerate() {
        if node.mesh.triangles.is_empty() {
            continue;
        }
        let title = object_name(scene, node, number);
        out.extend_from_slice(format!("o {title}\n").as_bytes());
        write_mesh(&in_world(node, unit), &names, &mut written, &mut out, file)?;
    }
    let mut files = vec![Encoded {
        name: name.to_owned(),
        bytes: out,
    }];
    if !names.is_empty() {
        let mut textures = Vec::new();
        let paths = image_paths(&scene.images, &mut companions, &mut textures);
        let mut bytes = comments.into_bytes();
        bytes.append(&mut material::write(scene, &names, &paths));
        files.push(Encoded {
            name: library,
            bytes,
        });
        files.append(&mut textures);
    }
    Ok(files)
}

/// A distinct name for each object: objects with equal names would be read as one.
fn object_name(scene: &Scene, node: &Node, number: usize) -> String {
    let clean = |name: &str| {
        name.replace(|c: char| c.is_control() || c == '#', "_")
            .trim()
            .to_owned()
    };
    let name = clean(&node.name);
    if name.is_empty() {
        return format!("node_{number}");
    }
    let is_taken = scene.nodes[..number].iter().any(|n| clean(&n.name) == name);
    if is_taken {
        format!("{name}_{number}")
    } else {
        name
    }
}

/// Writes a mesh.
fn write_mesh(
    mesh: &Mesh,
    names: &[String],
    written: &mut Written,
    out: &mut Vec<u8>,
    file: InFile,
) -> Result<(), FormatError> {
    let mut buffer = zmij::Buffer::new();
    let mut line = |out: &mut Vec<u8>, keyword: &[u8], values: &[f32]| {
        out.extend_from_slice(keyword);
        for &v in values {
            out.push(b' ');
            push_number(out, &mut buffer, if v.is_finite() { v } else { 0.0 });
        }
        out.push(b'\n');
    };
    let attribute = |name: &str, widths: std::ops::RangeInclusive<usize>| -> Option<&Attribute> {
        mesh.attributes
            .get(name)
            .filter(|a| widths.contains(&a.width))
    };
    let colors = attribute("COLOR_0", 3..=4);
    for (i, &p) in mesh.positions.iter().enumerate() {
        let [x, y, z] = to_f32(p, file)?;
        match colors.map(|a| a.at(i)) {
            Some(c) => line(out, b"v", &[x, y, z, c[0], c[1], c[2]]),
            None => line(out, b"v", &[x, y, z]),
        }
    }
    let coordinates = attribute("TEXCOORD_0", 2..=2);
    for uv in coordinates.iter().flat_map(|a| a.data.as_chunks::<2>().0) {
        line(out, b"vt", &[uv[0], 1.0 - uv[1]]);
    }
    let normals = attribute("NORMAL", 3..=3);
    for n in normals.iter().flat_map(|a| a.data.as_chunks::<3>().0) {
        line(out, b"vn", n);
    }
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let next = mesh.material(t);
        if next != written.material.unwrap_or(NO_MATERIAL) {
            written.material = Some(next);
            let name = names
                .get(next as usize)
                .map_or(NO_MATERIAL_NAME, String::as_str);
            out.extend_from_slice(format!("usemtl {name}\n").as_bytes());
        }
        out.push(b'f');
        for &i in triangle {
            let i = u64::from(i) + 1;
            out.push(b' ');
            push_integer(out, written.positions + i);
            if coordinates.is_some() || normals.is_some() {
                out.push(b'/');
            }
            if coordinates.is_some() {
                push_integer(out, written.coordinates + i);
            }
            if normals.is_some() {
                out.push(b'/');
                push_integer(out, written.normals + i);
            }
        }
        out.push(b'\n');
    }
    let count = mesh.positions.len() as u64;
    written.positions += count;
    written.coordinates += if coordinates.is_some() { count } else { 0 };
    written.normals += if normals.is_some() { count } else { 0 };
    Ok(())
}
