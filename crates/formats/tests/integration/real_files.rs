//! Files written by other software.

use crate::common;
use crate::common::data::{data, outside_data};
use crate::common::{distance, read_file, round_trip};
use greenstick_formats::{Format, LengthUnit};
use greenstick_geometry::{ImageSource, Scene};
use std::path::PathBuf;

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn the_compressed_stump_equals_its_decoded_copy() {
    let glb = read_file(&data("stump.glb"));
    let obj = read_file(&outside_data("scans/stump.obj"));
    assert_eq!(glb.nodes.len(), 1);
    assert_eq!(glb.nodes[0].mesh.triangles.len(), 38918);
    // The OBJ file has six decimals.
    assert!(distance(&glb, &obj) < 1e-6, "{}", distance(&glb, &obj));
    let (a, b) = (&glb.nodes[0].mesh, &obj.nodes[0].mesh);
    let corners = |m: &greenstick_geometry::Mesh| {
        let uv = &m.attributes["TEXCOORD_0"];
        m.triangles
            .as_flattened()
            .iter()
            .flat_map(|&i| uv.at(i as usize).to_vec())
            .collect::<Vec<_>>()
    };
    let (u, v) = (corners(a), corners(b));
    // That OBJ file has the v coordinate of glTF, which is not flipped, with five decimals.
    for (p, q) in u.chunks_exact(2).zip(v.chunks_exact(2)) {
        assert!(
            (p[0] - q[0]).abs() < 6e-6 && (p[1] - (1.0 - q[1])).abs() < 6e-6,
            "{p:?} {q:?}"
        );
    }
    let normals = &a.attributes["NORMAL"];
    for n in normals.data.chunks_exact(3) {
        let length = n.iter().map(|v| v * v).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 0.02, "{n:?}");
    }
    assert_eq!(glb.images.len(), 3);
    assert_eq!(glb.textures[0].image, None);
    assert_eq!(
        glb.textures[0].alternatives,
        [("EXT_texture_webp".to_owned(), 1)]
    );
    assert!(matches!(&glb.images[0].source, ImageSource::Bytes(b) if b.len() == 323_102));
}

/// A file, and its vertices and triangles according to its source, where that states them.
type RealFile = (PathBuf, Option<(usize, usize)>);

#[test]
fn files_of_the_repository_survive_every_format() {
    assert_round_trips(&[
        (data("pole.ply"), Some((2399, 4794))),
        (data("stump.glb"), Some((21356, 38918))),
        (data("homecart_cutting_board.gltf"), Some((3496, 4600))),
        (data("quaternius_DeadTree_1.gltf"), Some((8036, 6169))),
        (data("kaykit_Tree_Bare_1_C_Color1.obj"), None),
    ]);
}

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn other_files_survive_every_format() {
    assert_round_trips(&[
        (
            outside_data("scans/trunk_section.ply"),
            Some((14438, 28438)),
        ),
        (outside_data("trees/kaykit_Tree_Bare_2_C_Color1.obj"), None),
    ]);
}

fn assert_round_trips(files: &[RealFile]) {
    for (path, counts) in files {
        let scene = read_file(path);
        assert_round_trip(&path.display().to_string(), &scene, *counts);
    }
}

fn assert_round_trip(path: &str, scene: &Scene, counts: Option<(usize, usize)>) {
    let mesh = &scene.nodes[0].mesh;
    if let Some(counts) = counts {
        let found = (mesh.positions.len(), mesh.triangles.len());
        assert_eq!(found, counts, "{path}");
    }
    let (low, high) = mesh
        .transformed(&scene.nodes[0].transform)
        .bounds()
        .unwrap();
    // Positions are written in single precision, in OFF and OBJ as decimal numbers.
    let tolerance = 1e-6 * low.abs().max(high.abs()).max_element();
    for format in Format::ALL {
        let back = round_trip(format, scene, LengthUnit::Millimetre);
        let d = distance(scene, &back);
        assert!(d <= tolerance, "{path} as {format:?}: {d}");
    }
    println!(
        "{path}: {} triangles, notes {:?}",
        mesh.triangles.len(),
        scene.notes
    );
}

#[test]
fn missing_textures_and_materials_are_kept_by_name() {
    let board = read_file(&data("homecart_cutting_board.gltf"));
    let back = round_trip(Format::Gltf, &board, LengthUnit::Metre);
    assert_eq!(back.images, board.images);
    assert_eq!(back.textures, board.textures);
    assert_eq!(back.materials, board.materials);
    let tree = read_file(&data("kaykit_Tree_Bare_1_C_Color1.obj"));
    assert_eq!(tree.materials[0].name, "forest");
    assert!(
        tree.notes
            .iter()
            .any(|n| n.contains("Tree_Bare_1_C_Color1.mtl")),
        "{:?}",
        tree.notes
    );
}

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn a_point_cloud_is_refused_with_the_number_of_points() {
    let path = outside_data("scans/timber_beam_cloud.ply");
    let error = common::read_alone(Format::Ply, &std::fs::read(path).unwrap()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("contains 6832 points and no faces"),
        "{error}"
    );
}
