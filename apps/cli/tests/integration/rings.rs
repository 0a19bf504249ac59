//! `greenstick rings`: rings of a section, compared and pictured, and what it refuses.

use crate::support::Folder;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// A circle of radius 100 about (500, 400).
fn circle(radius: f64) -> Vec<[f64; 2]> {
    (0..360)
        .map(|i| (TAU * f64::from(i) / 360.0).sin_cos())
        .map(|(s, c)| [500.0 + radius * c, 400.0 + radius * s])
        .collect()
}

fn section() -> Value {
    json!({
        "name": "a circle",
        "outer_contour": circle(100.0),
        "pith": [500.0, 400.0],
        "rings": [{"label": 1990, "points": circle(40.0)}, {"label": "b", "points": circle(80.0)}],
    })
}

#[test]
fn rings_of_a_circle_are_circles() {
    let folder = Folder::new();
    folder.write("s.json", section().to_string());
    let run = folder.run(&[
        "rings",
        "s.json",
        "--widths",
        "10,25,30",
        "-o",
        "r.json",
        "--compare",
        "--picture",
        "p.png",
        "--picture-size",
        "64",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    let made: Value = serde_json::from_slice(&folder.read("r.json")).unwrap();
    assert_eq!(made["name"], "a circle");
    let rings = made["rings"].as_array().unwrap();
    assert_eq!(rings.len(), 3);
    for (ring, radius) in rings.iter().zip([10.0, 35.0, 65.0]) {
        for p in ring["points"].as_array().unwrap() {
            let d = (p[0].as_f64().unwrap() - 500.0).hypot(p[1].as_f64().unwrap() - 400.0);
            assert!((d - radius).abs() < 0.01, "{d} {radius}");
        }
    }
    // Rings that are circles are met.
    let mean = run
        .out
        .lines()
        .find(|l| l.trim_start().starts_with("mean"))
        .unwrap();
    let error: f64 = mean.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!(error < 0.05, "{}", run.out);
    assert!(folder.read("p.png").starts_with(b"\x89PNG"));
    // What it wrote it reads.
    let run = folder.run(&["rings", "r.json", "--rings", "2", "--pith", "510,400"]);
    assert_eq!(run.code, 0, "{}", run.err);
}

#[test]
fn eroded_rings_are_as_wide_as_their_kernels() {
    let folder = Folder::new();
    let corners = [[-100, -100], [100, -100], [100, 100], [-100, 100]];
    let square: Value =
        json!({"outer_contour": corners, "pith": [0, 0], "rings": [{"points": corners}]});
    folder.write("square.json", square.to_string());
    let base =
        "rings square.json --rings-by erosion --resolution 104 -o r.json --compare --picture p.png";
    let run = |more: &str| {
        let arguments = format!("{base}{more}");
        let run = folder.run(&arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, 0, "{}", run.err);
        let made: Value = serde_json::from_slice(&folder.read("r.json")).unwrap();
        made["rings"].as_array().unwrap().clone()
    };
    // Half the width of a ring's square: the greatest coordinate of its contour.
    let half = |ring: &Value, axis: usize| {
        let points = ring["points"].as_array().unwrap().iter();
        points
            .map(|p| p[axis].as_f64().unwrap())
            .fold(0.0, f64::max)
    };
    // The square is 100 pixels of 2 wide: a kernel K takes (K - 1) / 2 pixels off each side.
    let rings = run(" --kernels 3/5,2*5/9,3/21");
    let halves: Vec<f64> = rings.iter().map(|r| half(r, 0)).collect();
    assert_eq!(halves, [4.0, 26.0, 48.0, 70.0, 82.0, 94.0, 100.0]);
    // Twice as wide along x.
    let wide = run(" --kernels 5x3/5x3");
    let [x, y] = [0, 1].map(|axis| 100.0 - half(&wide[wide.len() - 2], axis));
    assert_eq!((x, y), (8.0, 4.0));
    // Two fronts: the innermost ring is the inner circle, of 0.4 mean radii, with two passes of a pixel about it.
    let both = run(" --inner-circle 0.4");
    let grown =
        both[0]["mean_radius"].as_f64().unwrap() - 0.4 * 200.0 / std::f64::consts::PI.sqrt();
    assert!((3.0..6.0).contains(&grown), "{grown}");
    assert!(folder.read("p.png").starts_with(b"\x89PNG"));
}

#[test]
fn bad_sections_are_refused_with_the_field() {
    let folder = Folder::new();
    let with = |field: &str, value: Value| {
        let mut section = section();
        section[field] = value;
        section.to_string()
    };
    folder.write("good.json", section().to_string());
    folder.write("text.json", "no json");
    folder.write("list.json", "[1]");
    folder.write("none.json", json!({"pith": [0, 0]}).to_string());
    folder.write(
        "pair.json",
        with("outer_contour", json!([[0, 0], [1, "x"], [2, 3]])),
    );
    folder.write("two.json", with("outer_contour", json!([[0, 0], [1, 1]])));
    folder.write(
        "line.json",
        with("outer_contour", json!([[0, 0], [1, 1], [2, 2]])),
    );
    folder.write("axis.json", with("y_axis", json!("left")));
    folder.write("bare.json", with("rings", Value::Null));
    for (arguments, expected) in [
        ("text.json", "no JSON"),
        ("list.json", "object"),
        ("none.json", "`outer_contour` is missing"),
        ("pair.json", "outer_contour[1]"),
        ("two.json", "2 points"),
        ("line.json", "no area"),
        ("axis.json", "y_axis"),
        ("bare.json --compare", "no annotated"),
        ("absent.json", "absent.json"),
        ("good.json --rings 0", "--rings"),
        ("good.json --radii 30,20", "radius 2"),
        (
            "good.json --photo good.json --picture p.png",
            "expected a photograph",
        ),
        ("good.json --widths 90,90", "ring 2"),
        ("good.json --widths 1,-1", "--widths"),
        ("good.json --pith 900,900", "pith"),
        ("good.json --pith 1,2,3", "--pith"),
        ("good.json --pith NaN,2", "pith"),
        ("good.json --rings 3 --radii 4", "--radii"),
        ("good.json --picture p.jpg", "png"),
        ("good.json -o good.json", "good.json"),
        ("good.json --kernels 3", "rings_by \"erosion\""),
        ("good.json --resolution 64", "rings_by \"erosion\""),
        ("good.json --rings-by erosion --rings 9", "its own number"),
        (
            "good.json --rings-by erosion --kernels 3/1",
            "only the pixel itself",
        ),
        (
            "good.json --rings-by erosion --inner-circle 1",
            "less than 1",
        ),
    ] {
        let mut words = vec!["rings"];
        words.extend(arguments.split(' '));
        let run = folder.run(&words);
        assert_eq!(run.code, 2, "{arguments}: {} {}", run.out, run.err);
        assert!(run.err.contains(expected), "{arguments}: {}", run.err);
    }
    assert_eq!(folder.names().len(), 9);
}
