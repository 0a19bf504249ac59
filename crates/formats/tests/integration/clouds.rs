//! Point clouds: what readers return, and invalid files by symptom.

use crate::common::data::outside_data;
use crate::common::modified;
use glam::DVec3;
use greenstick_formats::{
    CloudFile, CloudFormat, Content, Format, FormatError, InputFormat, LengthUnit, read_content,
};
use laz::{LasZipCompressor, LazItemRecordBuilder, LazVlr};
use std::io::{Cursor, Error, ErrorKind};

const XYZ: InputFormat = InputFormat::Cloud(CloudFormat::Xyz);
const LAS: InputFormat = InputFormat::Cloud(CloudFormat::Las);
const LAZ: InputFormat = InputFormat::Cloud(CloudFormat::Laz);
const PLY: InputFormat = InputFormat::Mesh(Format::Ply);

fn read(format: InputFormat, bytes: &[u8]) -> Result<Content, FormatError> {
    let resolve = |_: &str| Err(Error::from(ErrorKind::NotFound));
    read_content(format, bytes, "sample", None, &resolve)
}

fn cloud(format: InputFormat, bytes: impl AsRef<[u8]>) -> CloudFile {
    match read(format, bytes.as_ref()) {
        Ok(Content::Cloud(file)) => file,
        other => panic!("no cloud: {other:?}"),
    }
}

fn refused(format: InputFormat, bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let error = read(format, bytes.as_ref()).expect_err("read what is broken");
    let text = error.to_string();
    assert!(text.starts_with("sample: "), "{text}");
    for part in parts {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
}

/// The points of the LAS samples: integer millimetres around the offset of a survey.
fn surveyed(i: u32) -> DVec3 {
    let stored = DVec3::new(
        f64::from(i * 7 % 1000),
        f64::from(i * 13 % 900),
        f64::from(i),
    );
    stored * 0.001 + DVec3::new(512_000.0, 5_400_000.0, 300.0)
}

/// LAS 1.2 with `count` points of format 2, every eleventh withheld; optionally compressed.
fn las(count: u32, compressed: bool) -> Vec<u8> {
    let mut body = Vec::new();
    for i in 0..count {
        for v in [i * 7 % 1000, i * 13 % 900, i] {
            body.extend((v as i32).to_le_bytes());
        }
        body.extend([0, 0, 0, if i % 11 == 5 { 0x80 } else { 1 }, 0, 0, 0, 0]);
        for v in [256 * (i % 200), 512, 65535] {
            body.extend((v as u16).to_le_bytes());
        }
    }
    let items = LazItemRecordBuilder::default_for_point_format_id(2, 0).unwrap();
    let vlr = LazVlr::from_laz_items(items);
    let mut record = Vec::new();
    vlr.write_to(&mut record).unwrap();
    let records = if compressed { 54 + record.len() } else { 0 };
    let mut bytes = vec![0; 227];
    bytes[..4].copy_from_slice(b"LASF");
    (bytes[24], bytes[25]) = (1, 2);
    bytes[94..96].copy_from_slice(&227u16.to_le_bytes());
    bytes[96..100].copy_from_slice(&(227 + records as u32).to_le_bytes());
    bytes[100..104].copy_from_slice(&u32::from(compressed).to_le_bytes());
    bytes[104] = 2 | if compressed { 0x80 } else { 0 };
    bytes[105..107].copy_from_slice(&26u16.to_le_bytes());
    bytes[107..111].copy_from_slice(&count.to_le_bytes());
    let mut put = |at: usize, v: f64| bytes[at..at + 8].copy_from_slice(&v.to_le_bytes());
    for (k, offset) in [512_000.0, 5_400_000.0, 300.0].into_iter().enumerate() {
        put(131 + 8 * k, 0.001);
        put(155 + 8 * k, offset);
    }
    if !compressed {
        bytes.extend(body);
        return bytes;
    }
    let mut head = [0; 54];
    head[2..16].copy_from_slice(b"laszip encoded");
    head[18..20].copy_from_slice(&22204u16.to_le_bytes());
    head[20..22].copy_from_slice(&(record.len() as u16).to_le_bytes());
    bytes.extend(head);
    bytes.extend(record);
    let start = bytes.len() as u64;
    let mut out = Cursor::new(bytes);
    out.set_position(start);
    let mut compressor = LasZipCompressor::new(&mut out, vlr).unwrap();
    compressor.compress_many(&body).unwrap();
    compressor.done().unwrap();
    drop(compressor);
    out.into_inner()
}

#[test]
fn surveys_are_scaled_and_recentred_with_notes() {
    for compressed in [false, true] {
        let file = cloud(LAS, las(600, compressed));
        let expected: Vec<u32> = (0..600).filter(|i| i % 11 != 5).collect();
        assert_eq!(file.cloud.points.len(), expected.len());
        assert!(file.origin.y > 5_399_999.0);
        for (p, &i) in file.cloud.points.iter().zip(&expected) {
            assert!((*p + file.origin).distance(surveyed(i)) < 1e-8, "{i}");
        }
        for (c, &i) in file.cloud.colours.iter().zip(&expected) {
            assert_eq!(*c, [(i % 200) as u8, 2, 255]);
        }
        let notes = file.notes.join(" ");
        assert!(
            notes.contains("withheld") && notes.contains("subtracted"),
            "{notes}"
        );
        assert_eq!(notes.contains("extension of LAS but holds LAZ"), compressed);
    }
}

#[test]
fn columns_of_xyz_are_identified_by_values_or_names() {
    let read_with_note = |text: &str| {
        let file = cloud(XYZ, text);
        (file.cloud, file.notes[0].clone())
    };
    let (cloud, note) = read_with_note(
        "# by hand\n1 2 3 0 0 1 255 0 7\n4,5,6, 0,1,0, 1,2,3\n\n7;8;9;1;0;0;9;9;9\n",
    );
    assert_eq!(cloud.points[2], DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(cloud.normals, [DVec3::Z, DVec3::Y, DVec3::X]);
    assert_eq!(cloud.colours, [[255, 0, 7], [1, 2, 3], [9, 9, 9]]);
    assert!(
        note.contains("4, 5, 6 normals, 7, 8, 9 colours, by"),
        "{note}"
    );
    let (cloud, note) =
        read_with_note("//X Y Z R G B Intensity\n1 2 3 0.5 1 0 17\n1 2 4 0.5 1 0 9\n");
    assert_eq!(cloud.colours[0], [128, 255, 0]);
    assert!(
        note.contains("7 were dropped, as the header says"),
        "{note}"
    );
    let (cloud, _) = read_with_note("2\n1,5; 2,5; 3\n0;0;1e-3\n");
    assert_eq!(cloud.points[0], DVec3::new(1.5, 2.5, 3.0));
    let (cloud, note) = read_with_note("1 2 3 400.5\n1 nan 3 2\n");
    assert!(cloud.points[1].y.is_nan() && note.contains("4 were dropped"));
}

#[test]
fn ply_of_points_keeps_doubles_normals_and_colours() {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty double x\nproperty double y\n\
        property double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
        property uchar green\nproperty uchar blue\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for i in 0..2 {
        for v in [f64::from(i) + 1.0 / 3.0, 2.0, 3.0] {
            bytes.extend(v.to_be_bytes());
        }
        for v in [0.0f32, 2.0, 0.0] {
            bytes.extend(v.to_be_bytes());
        }
        bytes.extend([1, 2, 3]);
    }
    let file = cloud(PLY, &bytes);
    assert_eq!(file.cloud.points[1].x, 1.0 + 1.0 / 3.0);
    assert_eq!(
        (file.cloud.normals[0], file.cloud.colours[1]),
        (DVec3::Y, [1, 2, 3])
    );
    // With another extension, and in millimetres.
    let resolve = |_: &str| Err(Error::from(ErrorKind::NotFound));
    let unit = Some(LengthUnit::Millimetre);
    let read = read_content(XYZ, &bytes, "sample", unit, &resolve).unwrap();
    let Content::Cloud(file) = read else {
        panic!("no cloud");
    };
    assert!((file.cloud.points[0].y - 0.002).abs() < 1e-15);
    assert!(file.notes[0].contains("holds PLY"), "{:?}", file.notes);
    refused(
        PLY,
        &bytes[..bytes.len() - 1],
        &["vertex", "row 1", "too early"],
    );
    let text = String::from_utf8_lossy(&bytes[..300]).into_owned();
    let claims = text.replace("vertex 2", "vertex 4000000000");
    refused(PLY, claims, &["vertex claims 4000000000"]);
}

#[test]
fn invalid_xyz() {
    refused(XYZ, "", &["empty"]);
    refused(XYZ, "# nothing\n", &["no line with a point"]);
    refused(XYZ, "Dear Sir,\n", &["not a XYZ file", "`Dear`"]);
    refused(XYZ, "1 2\n", &["line 1", "at least x, y and z"]);
    refused(
        XYZ,
        "1 2 3\n1 2 3 4\n1 2 3\n",
        &["line 2", "4 numbers", "3 as in line 1"],
    );
    refused(XYZ, "1 2 3\n1 2 3\n1 2\n", &["line 3", "too early"]);
    refused(XYZ, "1 2 3\n1 x 3\n", &["line 2", "`x`", "a number"]);
    refused(
        XYZ,
        "5\n1 2 3\n",
        &["line 1", "count of 5", "1, the number"],
    );
}

#[test]
fn invalid_surveys() {
    let good = las(100, false);
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        bytes
    };
    refused(LAS, "LASX", &["not a LAS file"]);
    refused(LAS, &good[..100], &["header", "too early"]);
    refused(LAS, &good[..good.len() - 1], &["points claims 100"]);
    let many = |b: &mut Vec<u8>| b[107..111].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    refused(LAS, changed(&many), &["points claims 4000000000"]);
    refused(LAS, changed(&|b| b[131..139].fill(0xff)), &["scale"]);
    refused(LAS, changed(&|b| b[104] = 11), &["point format 11"]);
    refused(
        LAS,
        changed(&|b| b[105] = 20),
        &["records of 20 bytes", "26"],
    );
    refused(LAS, changed(&|b| b[25] = 9), &["version 1.9"]);
    refused(LAS, changed(&|b| b[107..111].fill(0)), &["empty"]);
    let packed = las(100, true);
    refused(LAZ, &packed[..400], &["compressed points"]);
    let mut more = packed.clone();
    more[107..111].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    refused(LAZ, more, &["compressed points"]);
    let mut none = packed;
    none[100] = 0;
    refused(LAZ, none, &["laszip encoded"]);
}

fn samples() -> Vec<(InputFormat, Vec<u8>)> {
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n";
    vec![
        (PLY, ply.as_bytes().to_vec()),
        (
            XYZ,
            b"x y z nx ny nz\n1 2 3 0 0 1\n4,5,6,0,1,0\n7;8;9;0;0;1\n".to_vec(),
        ),
        (LAS, las(12, false)),
        (LAZ, las(12, true)),
    ]
}

#[test]
fn samples_truncated_anywhere() {
    for (format, bytes) in samples() {
        read(format, &bytes).unwrap();
        for length in 0..bytes.len() {
            let _ = read(format, &bytes[..length]);
        }
    }
}

#[test]
fn samples_with_random_modifications() {
    for (number, (format, bytes)) in samples().into_iter().enumerate() {
        for round in 0..1500 {
            let changed = modified(&bytes, (number as u64) << 32 | round << 8);
            let _ = read(format, &changed);
        }
    }
}

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn real_scans() {
    // Numbers of points according to the sources.
    for (name, points) in [
        ("pine.laz", 73_851),
        ("tree_tls.las", 30_826),
        ("tree_forks.las", 20_198),
        ("tree33.xyz", 10_005),
        ("timber_beam_cloud.ply", 6832),
    ] {
        let path = outside_data(&format!("scans/{name}"));
        let format = InputFormat::from_path(&path).unwrap();
        let file = cloud(format, std::fs::read(&path).unwrap());
        assert_eq!(file.cloud.points.len(), points, "{name}");
        assert!(file.cloud.points.iter().all(|p| p.is_finite()));
        println!("{name}: origin {}, {:?}", file.origin, file.notes);
    }
}
