//! Lines for VTK; VTK itself reads them in `.ci`.

use flate2::read::ZlibDecoder;
use glam::DVec3;
use greenstick_formats::vtk::{Field, Polylines, TimedFile, collection, write_lines};
use greenstick_geometry::Values;
use std::io::Read;

/// The decompressed values of an array.
fn array(file: &[u8], name: &str) -> Vec<u8> {
    let text = String::from_utf8_lossy(file);
    let entry = text
        .lines()
        .find(|l| l.contains(&format!("Name=\"{name}\"")));
    let offset = entry.unwrap().split("offset=\"").nth(1).unwrap();
    let offset: usize = offset.split('"').next().unwrap().parse().unwrap();
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    let bytes = &file[start + offset..];
    let word = |k: usize| u64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().unwrap()) as usize;
    assert_eq!(word(0), 1, "one block");
    let mut out = Vec::new();
    let packed = &bytes[32..32 + word(3)];
    ZlibDecoder::new(packed).read_to_end(&mut out).unwrap();
    assert_eq!(out.len(), word(2));
    out
}

#[test]
fn lines_keep_their_points_and_fields() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, -2.0, 1e-9), DVec3::Z];
    let field = [Field::scalar("load_N", Values::F64(vec![1.5, -2.0]))];
    let frames = [Field::vectors("d_1 <\"&", &points)];
    let rods = Polylines {
        points: &points,
        corners: &[0, 1, 2, 3, 0],
        ends: &[3, 5],
        point_data: &frames,
        line_data: &field,
        metadata: None,
    };
    let file = write_lines(&rods, "rods.vtp").unwrap();
    let numbers = |name: &str| -> Vec<f64> {
        let bytes = array(&file.bytes, name);
        bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| f64::from_le_bytes(*b))
            .collect()
    };
    let counts = |name: &str| -> Vec<i64> {
        let bytes = array(&file.bytes, name);
        bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| i64::from_le_bytes(*b))
            .collect()
    };
    let flat: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
    assert_eq!(numbers("Points"), flat);
    assert_eq!(numbers("d_1 &lt;&quot;&amp;"), flat);
    assert_eq!(numbers("load_N"), [1.5, -2.0]);
    assert_eq!(counts("connectivity"), [0, 1, 2, 3, 0]);
    assert_eq!(counts("offsets"), [3, 5]);
}

#[test]
fn invalid_lines_are_refused() {
    let points = [DVec3::ZERO, DVec3::X];
    let far = [DVec3::ZERO, DVec3::splat(f64::NAN)];
    let short = [Field::scalar("a", Values::U8(vec![1]))];
    let endless = [Field::scalar("a", Values::F64(vec![f64::INFINITY, 0.0]))];
    let good = Polylines {
        points: &points,
        corners: &[0, 1],
        ends: &[2],
        point_data: &[],
        line_data: &[],
        metadata: None,
    };
    assert!(write_lines(&good, "x").is_ok());
    let cases = [
        (
            "has the points 2 to 2",
            Polylines {
                ends: &[2, 2],
                ..good
            },
        ),
        ("has the points 0 to 3", Polylines { ends: &[3], ..good }),
        ("end at 1", Polylines { ends: &[1], ..good }),
        (
            "passes through point 2",
            Polylines {
                corners: &[0, 2],
                ..good
            },
        ),
        (
            "point 1 lies at",
            Polylines {
                points: &far,
                ..good
            },
        ),
        (
            "field a has 1",
            Polylines {
                point_data: &short,
                ..good
            },
        ),
        (
            "inf in field a",
            Polylines {
                point_data: &endless,
                ..good
            },
        ),
    ];
    for (message, case) in cases {
        let error = write_lines(&case, "x").unwrap_err().to_string();
        assert!(error.contains(message), "{message}: {error}");
    }
    // A frame in which all bonds are broken has no lines.
    let none = Polylines {
        corners: &[],
        ends: &[],
        ..good
    };
    assert!(write_lines(&none, "x").is_ok());
}

#[test]
fn files_with_the_same_time_are_parts() {
    let files = [(0.0, "r0.vtp"), (0.0, "b&0.vtp"), (0.5, "r1.vtp")];
    let text = collection(&files.map(|(time, file)| TimedFile {
        time,
        file: file.to_owned(),
    }));
    let entries: Vec<&str> = text
        .lines()
        .filter(|l| l.contains("<DataSet "))
        .map(str::trim)
        .collect();
    assert_eq!(
        entries,
        [
            "<DataSet timestep=\"0\" group=\"\" part=\"0\" file=\"r0.vtp\"/>",
            "<DataSet timestep=\"0\" group=\"\" part=\"1\" file=\"b&amp;0.vtp\"/>",
            "<DataSet timestep=\"0.5\" group=\"\" part=\"0\" file=\"r1.vtp\"/>",
        ]
    );
}
