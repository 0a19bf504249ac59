//! Writing OBJ: an object for each node, positions in the world.

use super::material;
use super::material::NO_NAME;
use crate::assemble::{CompanionNames, externalise, in_world, narrow};
use crate::error::{FormatError, InFile};
use crate::text::{push_integer, push_number};
use crate::{Encoded, LengthUnit};
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Mesh, Node, Scene};

/// How many vertices, texture coordinates and normals are written so far.
#[derive(Default, Clone, Copy)]
struct Base {
    positions: u64,
    coordinates: u64,
    normals: u64,
    /// Material that is in force, which goes on from object to object.
    material: Option<u32>,
}

/// Writes the OBJ, its MTL and the textures that carry their bytes.
pub(crate) fn write(
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let mut companions = CompanionNames::new(name);
    let library = companions.beside("mtl");
    let names = material::names(scene);
    let triangles: usize = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
    let mut out = Vec::with_capacity(64 * triangles);
    out.extend_from_slice(format!("# by Greenstick, in {unit}\n").as_bytes());
    if !names.is_empty() {
        let safe = library.replace(char::is_control, "_");
        out.extend_from_slice(format!("mtllib {safe}\n").as_bytes());
    }
    let mut base = Base::default();
    for (number, node) in scene.nodes.iter().enumerate() {
        if node.mesh.triangles.is_empty() {
            continue;
        }
        let title = node_title(scene, node, number);
        out.extend_from_slice(format!("o {title}\n").as_bytes());
        write_mesh(&in_world(node, unit), &names, &mut base, &mut out, file)?;
    }
    let mut files = vec![Encoded {
        name: name.to_owned(),
        bytes: out,
    }];
    if !names.is_empty() {
        let mut textures = Vec::new();
        let paths = externalise(&scene.images, &mut companions, &mut textures);
        let bytes = material::write(scene, &names, &paths);
        files.push(Encoded {
            name: library,
            bytes,
        });
        files.append(&mut textures);
    }
    Ok(files)
}

/// A name of its own for each object: objects of one name would be read as one.
fn node_title(scene: &Scene, node: &Node, number: usize) -> String {
    let clean = |name: &str| {
        name.replace(|c: char| c.is_control() || c == '#', "_")
            .trim()
            .to_owned()
    };
    let name = clean(&node.name);
    if name.is_empty() {
        return format!("node_{number}");
    }
    let twice = scene.nodes[..number].iter().any(|n| clean(&n.name) == name);
    if twice {
        format!("{name}_{number}")
    } else {
        name
    }
}

fn write_mesh(
    mesh: &Mesh,
    names: &[String],
    base: &mut Base,
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
    let of_width = |name: &str, widths: std::ops::RangeInclusive<usize>| -> Option<&Attribute> {
        mesh.attributes
            .get(name)
            .filter(|a| widths.contains(&a.width))
    };
    let colors = of_width("COLOR_0", 3..=4);
    for (i, &p) in mesh.positions.iter().enumerate() {
        let [x, y, z] = narrow(p, file)?;
        match colors.map(|a| a.at(i)) {
            Some(c) => line(out, b"v", &[x, y, z, c[0], c[1], c[2]]),
            None => line(out, b"v", &[x, y, z]),
        }
    }
    let coordinates = of_width("TEXCOORD_0", 2..=2);
    for uv in coordinates.iter().flat_map(|a| a.data.as_chunks::<2>().0) {
        line(out, b"vt", &[uv[0], 1.0 - uv[1]]);
    }
    let normals = of_width("NORMAL", 3..=3);
    for n in normals.iter().flat_map(|a| a.data.as_chunks::<3>().0) {
        line(out, b"vn", n);
    }
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let next = mesh.material(t);
        if next != base.material.unwrap_or(NO_MATERIAL) {
            base.material = Some(next);
            let name = names.get(next as usize).map_or(NO_NAME, String::as_str);
            out.extend_from_slice(format!("usemtl {name}\n").as_bytes());
        }
        out.push(b'f');
        for &i in triangle {
            let i = u64::from(i) + 1;
            out.push(b' ');
            push_integer(out, base.positions + i);
            if coordinates.is_some() || normals.is_some() {
                out.push(b'/');
            }
            if coordinates.is_some() {
                push_integer(out, base.coordinates + i);
            }
            if normals.is_some() {
                out.push(b'/');
                push_integer(out, base.normals + i);
            }
        }
        out.push(b'\n');
    }
    let count = mesh.positions.len() as u64;
    base.positions += count;
    base.coordinates += if coordinates.is_some() { count } else { 0 };
    base.normals += if normals.is_some() { count } else { 0 };
    Ok(())
}
