//! Small samples, truncated at every length and with modified bytes: readers may refuse them, but never panic.

use crate::common::{data, hash, modified, two_cubes};
use greenstick_formats::{Encoded, Format, FormatError, LengthUnit, read, write};
use greenstick_geometry::Scene;
use std::io::{Error, ErrorKind};

/// Reads a sample; the buffer of the glTF file is all zeros.
fn read_alone(format: Format, bytes: &[u8]) -> Result<Scene, FormatError> {
    let resolve = |name: &str| match name {
        "x.bin" => Ok(vec![0; 10_000]),
        _ => Err(Error::from(ErrorKind::NotFound)),
    };
    read(format, bytes, "sample", None, &resolve)
}

fn samples() -> Vec<(Format, Vec<u8>)> {
    let mut samples = Vec::new();
    for format in Format::ALL {
        let files: Vec<Encoded> = write(format, &two_cubes(), "x", LengthUnit::Metre).unwrap();
        samples.push((format, files[0].bytes.clone()));
    }
    let text = |format, text: &str| (format, text.as_bytes().to_vec());
    samples.push(text(
        Format::Ply,
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
         property list uchar int vertex_index\nproperty int node\nend_header\n\
         0 0 0 1 2 3\n1 0 0 1 2 3\n1 1 0 1 2 3\n0 1 0 1 2 3\n4 0 1 2 3 7\n",
    ));
    let big = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short y\n\
        property short z\nelement face 1\nproperty list uchar ushort vertex_index\nend_header\n\
        \0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\x01\0\0\x03\0\0\0\x01\0\x02";
    samples.push((Format::Ply, big.to_vec()));
    samples.push(text(
        Format::Stl,
        "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
         endfacet\nendsolid a b\n",
    ));
    samples.push(text(Format::Off, "STCNOFF # x\n3 1 0\n0 0 0 0 0 1 1 2 3 0 0\n1 0 0 0 0 1 1 2 3 1 0\n0 1 0 0 0 1 1 2 3 1 1\n3 0 1 2 255 0 0\n"));
    samples.push(text(
        Format::Obj,
        "mtllib m\no a\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n0\nv .5 .5 0\nvt 0 1\nvn 0 0 1\ng b\n\
         f 1/1/1 2//1 3 -3/-1 5\ns 1\nl 1 2\n",
    ));
    samples
}

#[test]
fn samples_truncated_anywhere() {
    for (format, bytes) in samples() {
        read_alone(format, &bytes).unwrap();
        for length in 0..bytes.len() {
            let _ = read_alone(format, &bytes[..length]);
        }
    }
}

#[test]
fn samples_with_random_modifications() {
    for (number, (format, bytes)) in samples().into_iter().enumerate() {
        for round in 0..3000 {
            let changed = modified(&bytes, (number as u64) << 32 | round << 8);
            for other in [format, Format::ALL[round as usize % 6]] {
                let _ = read_alone(other, &changed);
            }
        }
    }
}

#[test]
fn the_damaged_compressed_stump() {
    let bytes = std::fs::read(data::data("stump.glb")).unwrap();
    for round in 0..60 {
        let mut changed = bytes.clone();
        for k in 0..20 {
            // The meshopt streams start at byte 658,048 of the buffer.
            let at = 660_000 + hash(round * 64 + k) as usize % (bytes.len() - 660_000);
            changed[at] = hash(round * 64 + k + 40) as u8;
        }
        let _ = read_alone(Format::Glb, &changed);
    }
}
