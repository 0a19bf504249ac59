//! Scenes written and read back in every format.

use crate::common::{distance, read_back, round_trip, two_cubes};
use glam::{DAffine3, DMat3, DVec3};
use greenstick_formats::{Format, LengthUnit, write};
use greenstick_geometry::{Attribute, Node, Scene};
use std::sync::Arc;

fn volume(scene: &Scene) -> f64 {
    scene
        .nodes
        .iter()
        .map(|n| n.mesh.transformed(&n.transform).volume())
        .sum()
}

#[test]
fn geometry_survives_every_format_and_unit() {
    let scene = two_cubes();
    for format in Format::ALL {
        for unit in [
            LengthUnit::Millimetre,
            LengthUnit::Centimetre,
            LengthUnit::Metre,
        ] {
            let back = round_trip(format, &scene, unit);
            let d = distance(&scene, &back);
            assert!(d < 1e-6, "{format:?} {unit}: {d}");
            assert!((volume(&back) - 1.125).abs() < 1e-6, "{format:?} {unit}");
        }
    }
}

#[test]
fn gltf_keeps_everything() {
    let scene = two_cubes();
    for format in [Format::Gltf, Format::Glb] {
        let back = round_trip(format, &scene, LengthUnit::Metre);
        assert_eq!(back.materials, scene.materials);
        assert_eq!(back.textures, scene.textures);
        for (a, b) in back.nodes.iter().zip(&scene.nodes) {
            assert_eq!((&a.name, a.parent), (&b.name, b.parent));
            assert!(a.transform.abs_diff_eq(b.transform, 1e-15));
            // With one primitive for each material, vertices keep their order because materials do.
            assert_eq!(a.mesh, b.mesh);
        }
        let external = |scene: &Scene| scene.images[1].source.clone();
        assert_eq!(external(&back), external(&scene));
        if format == Format::Glb {
            assert_eq!(back.images[0], scene.images[0]);
        }
    }
}

#[test]
fn obj_keeps_materials_names_and_attributes() {
    let scene = two_cubes();
    let back = round_trip(Format::Obj, &scene, LengthUnit::Metre);
    for (a, b) in back.materials.iter().zip(&scene.materials) {
        assert_eq!(a.name, b.name);
        assert_eq!(
            (a.base_color, a.roughness, a.metallic),
            (b.base_color, b.roughness, b.metallic)
        );
        assert_eq!(a.base_color_texture, b.base_color_texture);
        assert_eq!(a.alpha_mode, b.alpha_mode);
    }
    assert_eq!(
        back.materials[0].normal_texture,
        scene.materials[0].normal_texture
    );
    for (a, b) in back.nodes.iter().zip(&scene.nodes) {
        assert_eq!((&a.name, &a.mesh.triangles), (&b.name, &b.mesh.triangles));
        assert_eq!(a.mesh.materials, b.mesh.materials);
        assert_eq!(
            a.mesh.attributes["TEXCOORD_0"],
            b.mesh.attributes["TEXCOORD_0"]
        );
    }
    assert_eq!(
        back.nodes[0].mesh.attributes["NORMAL"],
        scene.nodes[0].mesh.attributes["NORMAL"]
    );
}

#[test]
fn ply_keeps_nodes_materials_and_custom_attributes() {
    let scene = two_cubes();
    let back = round_trip(Format::Ply, &scene, LengthUnit::Metre);
    assert_eq!(back.nodes.len(), 2);
    for (a, b) in back.nodes.iter().zip(&scene.nodes) {
        assert_eq!((&a.name, &a.mesh.triangles), (&b.name, &b.mesh.triangles));
        assert_eq!(a.mesh.materials, b.mesh.materials);
        for name in ["TEXCOORD_0", "COLOR_0", "_RING"] {
            assert_eq!(a.mesh.attributes[name], b.mesh.attributes[name]);
        }
    }
    let names: Vec<&str> = back.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["bark", "flesh"]);
}

#[test]
fn off_keeps_colors() {
    let scene = two_cubes();
    let back = round_trip(Format::Off, &scene, LengthUnit::Metre);
    let colors: Vec<f32> = scene
        .nodes
        .iter()
        .flat_map(|n| n.mesh.attributes["COLOR_0"].data.clone())
        .collect();
    assert_eq!(back.nodes[0].mesh.attributes["COLOR_0"].data, colors);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    for format in Format::ALL {
        let name = format!("x.{}", format.extension());
        let once = write(format, &two_cubes(), &name, LengthUnit::Metre).unwrap();
        assert_eq!(
            once,
            write(format, &two_cubes(), &name, LengthUnit::Metre).unwrap()
        );
        assert_eq!(once[0].name, name);
    }
}

#[test]
fn sheared_and_mirrored_nodes_keep_their_positions() {
    let mut scene = two_cubes();
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
    scene.nodes[0].transform = DAffine3::from_mat3_translation(shear, DVec3::Y);
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0));
    scene.nodes[1].transform = mirror;
    for format in Format::ALL {
        let back = round_trip(format, &scene, LengthUnit::Metre);
        assert!((volume(&back) - volume(&scene)).abs() < 1e-6, "{format:?}");
    }
}

#[test]
fn cyclic_parents_are_written_as_roots() {
    let mut scene = two_cubes();
    scene.nodes[0].parent = Some(1);
    let files = write(Format::Glb, &scene, "x.glb", LengthUnit::Metre).unwrap();
    let back = read_back(Format::Glb, &files, LengthUnit::Metre);
    assert_eq!(back.nodes.len(), 2);
}

#[test]
fn custom_attributes_of_several_widths_are_split_and_joined() {
    let mut scene = two_cubes();
    for node in &mut scene.nodes {
        let vertices = node.mesh.positions.len();
        let attribute = |width: usize| Attribute {
            width,
            data: (0..width * vertices).map(|i| i as f32).collect(),
        };
        node.mesh_mut()
            .attributes
            .retain(|name, _| !name.starts_with('_'));
        node.mesh_mut()
            .attributes
            .insert("_GRAIN".into(), attribute(3));
        node.mesh_mut()
            .attributes
            .insert("_RING".into(), attribute(1));
    }
    let files = write(Format::Gltf, &scene, "cubes.gltf", LengthUnit::Metre).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&files[0].bytes).unwrap();
    let mut own = 0;
    for mesh in json["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            for (name, accessor) in primitive["attributes"].as_object().unwrap() {
                if name.starts_with('_') {
                    let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
                    assert_eq!(accessor["type"], "SCALAR", "{name}");
                    own += 1;
                }
            }
        }
    }
    assert!(own >= 8, "{own}");
    let back = round_trip(Format::Gltf, &scene, LengthUnit::Metre);
    for (a, b) in back.nodes.iter().zip(&scene.nodes) {
        assert_eq!(a.mesh.attributes, b.mesh.attributes);
    }
}

#[test]
fn gltf_keeps_instances() {
    let two = two_cubes();
    let shared = two.nodes[0].mesh.clone();
    let place = |x: f64| DAffine3::from_translation(DVec3::X * x);
    let sheared = DAffine3::from_mat3(DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.5, 1.0, 0.0),
        DVec3::Z,
    ));
    let scene = Scene {
        nodes: vec![
            Node::new("a", place(0.0), shared.clone()),
            Node::new("b", place(2.0), shared.clone()),
            // Its transform goes into the vertices, so that it cannot share them.
            Node::new("sheared", sheared, shared),
            Node::new("other", place(4.0), two.nodes[1].mesh.clone()),
        ],
        ..two
    };
    let name = "instances.glb";
    let file = &write(Format::Glb, &scene, name, LengthUnit::Metre).unwrap()[0];
    let json_length = u32::from_le_bytes(file.bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value =
        serde_json::from_slice(&file.bytes[20..20 + json_length]).unwrap();
    assert_eq!(json["meshes"].as_array().unwrap().len(), 3);
    let back = round_trip(Format::Glb, &scene, LengthUnit::Metre);
    let same = |i: usize, j: usize| Arc::ptr_eq(&back.nodes[i].mesh, &back.nodes[j].mesh);
    assert!(same(0, 1) && !same(0, 2) && !same(0, 3));
    assert!(distance(&scene, &back) < 1e-6);
}
