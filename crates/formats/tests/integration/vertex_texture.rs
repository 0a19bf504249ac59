//! Vertex animation textures, read as by a shader and compared with the skinning of the film.

use crate::common::bundle::{Bend, film};
use glam::DVec3;
use greenstick_formats::film::{FilmError, MAX_TEXTURE_SIZE, write_vertex_texture};
use greenstick_formats::{Encoded, Format, LengthUnit};
use greenstick_geometry::{Context, Motion, Pose};
use serde_json::Value;
use std::io::Cursor;

/// The width and height of an image and its pixels as fractions, row by row.
fn decoded(file: &Encoded) -> (usize, usize, Vec<DVec3>) {
    let decoder = png::Decoder::new(Cursor::new(&file.bytes));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(
        (info.color_type, info.bit_depth),
        (png::ColorType::Rgb, png::BitDepth::Sixteen)
    );
    let share = |b: &[u8]| f64::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0;
    let pixels = bytes.as_chunks::<6>().0.iter();
    let pixels = pixels.map(|b| DVec3::new(share(&b[..2]), share(&b[2..4]), share(&b[4..])));
    (info.width as usize, info.height as usize, pixels.collect())
}

#[test]
fn a_shader_reproduces_the_skinned_vertices() {
    let mut film = film(9, 40, 4);
    film.metadata.push("program", "greenstick");
    let mut motion = Bend::new(&film, 7);
    // Narrower than a frame, so that frames have several rows.
    let (about, files) =
        write_vertex_texture(&film, &mut motion, "stick.png", 100, &Context::quiet()).unwrap();
    let names: Vec<&str> = files.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names[0], "stick.png");
    let json = files.iter().find(|f| f.name == "stick.json").unwrap();
    let json: Value = serde_json::from_slice(&json.bytes).unwrap();
    assert_eq!(json["metadata"]["program"], "greenstick");
    let corner = |key: &str| {
        let three = json[key].as_array().unwrap();
        DVec3::from_array([0, 1, 2].map(|k| three[k].as_f64().unwrap()))
    };
    let (low, high) = (corner("low"), corner("high"));
    let (width, height, texels) = decoded(&files[0]);
    let rows = json["rows_per_frame"].as_u64().unwrap() as usize;
    assert_eq!((width, height), (100, rows * motion.frames()));
    assert!(rows > 1);

    // The mesh, as an engine imports it.
    let mesh = files.iter().find(|f| f.name == "stick.glb").unwrap();
    let none = |_: &str| Err(std::io::Error::other("no companion"));
    let unit = Some(LengthUnit::Metre);
    let scene = greenstick_formats::read(Format::Glb, &mesh.bytes, "stick.glb", unit, &none);
    let scene = scene.unwrap();
    let text = String::from_utf8_lossy(&mesh.bytes);
    assert!(text.contains("\"program\":\"greenstick\""));
    let names: Vec<&str> = scene.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["stick", "half", "hammer", "anvil"]);
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut expected = Vec::new();
    let quantum = (high - low) / 65535.0;
    let mut moved = 0.0f64;
    for frame in 0..motion.frames() {
        motion.poses(frame, &mut poses).unwrap();
        for (piece, node) in scene.nodes[..2].iter().enumerate() {
            film.pose_piece(piece, &poses, &mut expected);
            let rest = &film.pieces[piece].mesh.positions;
            let coordinates = &node.mesh.attributes["TEXCOORD_1"];
            for (v, &at_rest) in node.mesh.positions.iter().enumerate() {
                let [u, w] = [coordinates.at(v)[0], coordinates.at(v)[1]].map(f64::from);
                let step = (rows * frame) as f64 / height as f64;
                let column = (u * width as f64).floor() as usize;
                let row = ((w + step) * height as f64).floor() as usize;
                let found = low + (high - low) * texels[row * width + column];
                // The vertex of the film is that with the nearest position at rest.
                let fits = rest.iter().zip(&expected).any(|(r, e)| {
                    r.distance(at_rest) < 1e-6
                        && (found - *e).abs().cmple(0.5 * quantum + 1e-12).all()
                });
                assert!(fits, "frame {frame}, vertex {v} of {}", node.name);
                moved = moved.max(found.distance(at_rest));
            }
        }
    }
    assert!(moved > 0.05);
    assert!((about.error() - 0.5 * quantum.max_element()).abs() < 1e-15);
}

#[test]
fn textures_that_are_too_large_are_refused() {
    let film = film(3, 40, 1);
    let mut motion = Bend::new(&film, 50);
    let made = write_vertex_texture(&film, &mut motion, "x.png", 1, &Context::quiet());
    let Err(FilmError::Format(error)) = made else {
        panic!("{} rows were made", MAX_TEXTURE_SIZE + 1);
    };
    assert!(error.to_string().contains("16384"), "{error}");
}
