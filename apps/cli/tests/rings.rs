//! `greenstick rings`: rings of a section, compared and pictured, and what it refuses.

mod support;

use serde_json::{Value, json};
use std::f64::consts::TAU;
use support::Folder;

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
    for (arguments, told) in [
        ("text.json", "no JSON"),
        ("list.json", "object"),
        ("none.json", "`outer_contour` is missing"),
        ("pair.json", "outer_contour[1]"),
        ("two.json", "2 points"),
        ("line.json", "no area"),
        ("axis.json", "y_axis"),
        ("bare.json --compare", "no annotated"),
        ("absent.json", "absent.json"),
        ("good.json --rings 0", "0 rings"),
        ("good.json --radii 30,20", "radius 2"),
        ("good.json --widths 90,90", "ring 2"),
        ("good.json --widths 1,-1", "width 2"),
        ("good.json --pith 900,900", "pith"),
        ("good.json --pith 1,2,3", "two numbers"),
        ("good.json --pith NaN,2", "pith"),
        ("good.json --rings 3 --radii 4", "--radii"),
        ("good.json --picture p.jpg", "png"),
        ("good.json -o good.json", "good.json"),
    ] {
        let mut words = vec!["rings"];
        words.extend(arguments.split(' '));
        let run = folder.run(&words);
        assert_eq!(run.code, 2, "{arguments}: {} {}", run.out, run.err);
        assert!(run.err.contains(told), "{arguments}: {}", run.err);
    }
    assert_eq!(folder.names().len(), 9);
}
