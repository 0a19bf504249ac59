//! Real meshes for tests, read by the few lines that these files need.

use glam::DVec3;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::stem::{FoundStem, StemError, StemOptions, find_stem};
use std::path::Path;

#[path = "../../../../../tests/support/data.rs"]
pub mod data;

/// The stem at a place of meshes, found as it is without being told anything of it.
pub fn stem_at(meshes: &[Mesh], place: &str) -> Result<FoundStem, StemError> {
    let options = StemOptions::default();
    find_stem(meshes, &place.parse().unwrap(), &options, &Context::quiet())
}

fn fan(mesh: &mut Mesh, corners: &[u32]) {
    for k in 1..corners.len() - 1 {
        mesh.triangles
            .push([corners[0], corners[k], corners[k + 1]]);
    }
}

/// An OBJ file of positions and faces.
pub fn obj(path: &Path) -> Mesh {
    let text = std::fs::read_to_string(path).unwrap();
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                mesh.positions.push(DVec3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1)
                    .collect();
                fan(&mut mesh, &corners);
            }
            _ => {}
        }
    }
    mesh
}

/// An ASCII PLY file of positions and faces, its numbers times `unit`.
pub fn ply(path: &Path, unit: f64) -> Mesh {
    let text = std::fs::read_to_string(path).unwrap();
    let (head, body) = text.split_once("end_header").unwrap();
    let count: usize = head
        .lines()
        .find_map(|l| l.strip_prefix("element vertex "))
        .unwrap()
        .trim()
        .parse()
        .unwrap();
    let mut mesh = Mesh::default();
    for (i, line) in body.lines().skip(1).enumerate() {
        let c: Vec<f64> = line
            .split_whitespace()
            .map(|w| w.parse().unwrap())
            .collect();
        if i < count {
            mesh.positions.push(DVec3::new(c[0], c[1], c[2]) * unit);
        } else if c.len() > 3 {
            let corners: Vec<u32> = c[1..].iter().map(|&x| x as u32).collect();
            fan(&mut mesh, &corners);
        }
    }
    mesh
}

/// The first primitive of a glTF file with one buffer and no node transforms.
pub fn gltf(path: &Path) -> Mesh {
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let buffer = path.with_file_name(json["buffers"][0]["uri"].as_str().unwrap());
    let bytes = std::fs::read(buffer).unwrap();
    let part = &json["meshes"][0]["primitives"][0];
    let view = |accessor: &serde_json::Value| {
        let a = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let v = &json["bufferViews"][a["bufferView"].as_u64().unwrap() as usize];
        let start = v["byteOffset"].as_u64().unwrap_or(0) + a["byteOffset"].as_u64().unwrap_or(0);
        (start as usize, a["count"].as_u64().unwrap() as usize)
    };
    let mut mesh = Mesh::default();
    let (start, count) = view(&part["attributes"]["POSITION"]);
    for v in bytes[start..start + 12 * count].chunks_exact(12) {
        let c = |k: usize| f64::from(f32::from_le_bytes(v[4 * k..4 * k + 4].try_into().unwrap()));
        mesh.positions.push(DVec3::new(c(0), c(1), c(2)));
    }
    let (start, count) = view(&part["indices"]);
    let indices: Vec<u32> = bytes[start..start + 2 * count]
        .chunks_exact(2)
        .map(|b| u32::from(u16::from_le_bytes([b[0], b[1]])))
        .collect();
    mesh.triangles = indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    mesh
}
