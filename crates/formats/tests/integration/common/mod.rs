//! Helpers of the tests: sample files and scenes.

pub mod bundle;
#[path = "../../../../../tests/support/data.rs"]
pub mod data;

use glam::{DAffine3, DQuat, DVec3};
use greenstick_formats::{Encoded, Format, FormatError, LengthUnit, read, write};
use greenstick_geometry::{
    Attribute, Image, ImageSource, Material, Mesh, Node, Scene, Texture, TextureReference,
};
use std::io::{Error, ErrorKind};
use std::path::Path;

/// Reads a file with its companions.
pub fn read_file(path: &Path) -> Scene {
    let bytes = std::fs::read(path).unwrap();
    let folder = path.parent().unwrap();
    let resolve = |name: &str| std::fs::read(folder.join(name));
    let format = Format::from_path(path).unwrap();
    let name = path.file_name().unwrap().to_string_lossy();
    read(format, &bytes, &name, None, &resolve).unwrap()
}

/// Reads bytes without companions.
pub fn read_alone(format: Format, bytes: &[u8]) -> Result<Scene, FormatError> {
    let resolve = |_: &str| Err(Error::from(ErrorKind::NotFound));
    read(format, bytes, "sample", None, &resolve)
}

/// Reads files that were written in the given unit.
pub fn read_back(format: Format, files: &[Encoded], unit: LengthUnit) -> Scene {
    let resolve = |name: &str| {
        let file = files.iter().find(|f| f.name == name);
        file.map(|f| f.bytes.clone())
            .ok_or_else(|| Error::from(ErrorKind::NotFound))
    };
    let unit = Some(unit).filter(|_| !format.is_in_metres());
    read(format, &files[0].bytes, &files[0].name, unit, &resolve).unwrap()
}

/// Writes and reads.
pub fn round_trip(format: Format, scene: &Scene, unit: LengthUnit) -> Scene {
    let name = format!("a b.{}", format.extension());
    read_back(format, &write(format, scene, &name, unit).unwrap(), unit)
}

/// All triangles in world coordinates, in order.
pub fn world_triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let of_node = |node: &Node| {
        let mesh = node.mesh.transformed(&node.transform);
        (0..mesh.triangles.len())
            .map(|t| mesh.corners(t))
            .collect::<Vec<_>>()
    };
    scene.nodes.iter().flat_map(of_node).collect()
}

/// Largest distance of corresponding corners.
pub fn distance(a: &Scene, b: &Scene) -> f64 {
    let (a, b) = (world_triangles(a), world_triangles(b));
    assert_eq!(a.len(), b.len());
    let corners = a.as_flattened().iter().zip(b.as_flattened());
    corners.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

/// A unit cube with 24 vertices and every kind of attribute.
pub fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    let (mut normals, mut uvs, mut colors, mut rings, mut tangents) =
        (vec![], vec![], vec![], vec![], vec![]);
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let base = mesh.positions.len() as u32;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut p = [0.0; 3];
                p[axis] = side;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                mesh.positions.push(DVec3::from_array(p));
                let mut n = [0.0_f32; 3];
                n[axis] = if side == 0.0 { -1.0 } else { 1.0 };
                normals.extend(n);
                n.rotate_right(1);
                tangents.extend([n[0], n[1], n[2], 1.0]);
                uvs.extend([u as f32, 0.25 + v as f32 / 2.0]);
                colors.extend([u as f32, v as f32, 0.5, 1.0]);
                rings.push(base as f32 + 0.125);
            }
            let flip = side == 0.0;
            for t in [[0, 1, 2], [0, 2, 3]] {
                let [a, b, c] = t.map(|i| base + i);
                mesh.triangles
                    .push(if flip { [a, c, b] } else { [a, b, c] });
                mesh.materials.push(u32::from(axis == 2));
            }
        }
    }
    for (name, width, data) in [
        ("NORMAL", 3, normals),
        ("TANGENT", 4, tangents),
        ("TEXCOORD_0", 2, uvs),
        ("COLOR_0", 4, colors),
        ("_RING", 1, rings),
    ] {
        mesh.attributes
            .insert(name.to_owned(), Attribute { width, data });
    }
    mesh
}

/// Two cubes, one the child of the other, with two materials and both kinds of images.
pub fn two_cubes() -> Scene {
    let texture = |texture| TextureReference {
        texture,
        coordinates: 0,
        transform: Some(([0.25, 0.5], 0.0, [2.0, 3.0])),
        strength: 1.0,
    };
    let bark = Material {
        name: "bark".to_owned(),
        base_color: [0.5, 0.25, 0.125, 0.75],
        roughness: 0.9,
        alpha_mode: "BLEND".to_owned(),
        double_sided: true,
        base_color_texture: Some(texture(0)),
        normal_texture: Some(TextureReference {
            strength: 0.5,
            ..texture(1)
        }),
        ..Material::default()
    };
    let flesh = Material {
        name: "flesh".to_owned(),
        metallic: 0.25,
        ..Material::default()
    };
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let below = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.5),
        turn,
        DVec3::new(3.0, -1.0, 0.25),
    );
    let node = |name: &str, transform, parent| Node {
        name: name.to_owned(),
        transform,
        mesh: cube().into(),
        parent,
        is_detail: false,
    };
    let png = png_pixel();
    let image = |name: &str, mime_type: &str, source| Image {
        name: name.to_owned(),
        mime_type: mime_type.to_owned(),
        source,
    };
    Scene {
        nodes: vec![
            node("base", DAffine3::from_translation(DVec3::X), None),
            node("twig", below, Some(0)),
        ],
        materials: vec![bark, flesh],
        textures: (0..2)
            .map(|i| Texture {
                image: Some(i),
                alternatives: Vec::new(),
                sampler: [Some(9729), Some(9987), None, None],
            })
            .collect(),
        images: vec![
            image("color", "image/png", ImageSource::Bytes(png)),
            image("", "", ImageSource::Reference("missing.png".to_owned())),
        ],
        ..Scene::default()
    }
}

/// A PNG image of one grey pixel.
pub fn png_pixel() -> Vec<u8> {
    let hex = "89504e470d0a1a0a0000000d49484452000000010000000108000000003a7e9b55\
               0000000a4944415478da6368000000820081da45083b0000000049454e44ae426082";
    unhex(hex)
}

/// Bytes from hexadecimal digits.
pub fn unhex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text
        .chars()
        .filter_map(|c| c.to_digit(16))
        .map(|d| d as u8)
        .collect();
    digits.chunks_exact(2).map(|d| d[0] << 4 | d[1]).collect()
}

/// A stateless hash (SplitMix64), so that modifications are the same on every machine.
pub fn hash(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The bytes with one to four of them changed, at random: replaced, with a flipped bit, by a character that means
/// something in files of text, or removed.
pub fn modified(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    for k in 0..1 + hash(seed) % 4 {
        let h = hash(seed + 1 + k);
        let at = (h >> 16) as usize % changed.len();
        match h % 4 {
            0 => changed[at] = (h >> 8) as u8,
            1 => changed[at] ^= 1 << (h >> 8 & 7),
            2 => changed[at] = b"0123456789-.eE/ \n{}[]\",:"[(h >> 8) as usize % 24],
            _ => drop(changed.remove(at)),
        }
    }
    changed
}
