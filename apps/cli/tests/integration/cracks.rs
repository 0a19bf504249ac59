//! `greenstick cracks`: a photograph becomes a recipe, which a break then draws; what is refused.

use crate::support::Folder;
use greenstick::wood::colour::RgbImage;
use serde_json::Value;

const SIDE: u32 = 360;
const RADIUS: f64 = 150.0;
/// Directions of the painted cracks, degrees counter-clockwise from the right.
const DIRECTIONS: [f64; 3] = [20.0, 140.0, 260.0];

/// A section on a light background, with wedges from a fifth of the radius to the bark, 3° wide there.
fn photograph() -> Vec<u8> {
    let pixel = |i: u32| {
        let middle = 0.5 * f64::from(SIDE);
        let (x, y) = (f64::from(i % SIDE) - middle, middle - f64::from(i / SIDE));
        let (rho, angle) = (x.hypot(y) / RADIUS, y.atan2(x).to_degrees());
        let apart = |d: &f64| ((angle - d + 180.0).rem_euclid(360.0) - 180.0).abs();
        let opening = 1.5 * (rho - 0.2) / 0.8;
        if rho > 1.0 {
            [205, 205, 210]
        } else if DIRECTIONS.iter().any(|d| apart(d) < opening) {
            [12, 10, 8]
        } else {
            [150, 110, 70]
        }
    };
    let rgb = (0..SIDE * SIDE).flat_map(pixel).collect();
    let image = RgbImage {
        width: SIDE,
        height: SIDE,
        rgb,
    };
    image.png()
}

#[test]
fn cracks_of_a_photograph_become_a_recipe_that_draws_them() {
    let folder = Folder::new();
    folder.write("end.png", photograph());
    let run = folder.run(&["cracks", "--from", "end.png", "-o", "cracks.toml", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: Value = serde_json::from_str(&run.out).unwrap();
    let cracks = report["cracks"].as_array().unwrap();
    assert_eq!(cracks.len(), DIRECTIONS.len(), "{cracks:?}");
    for direction in DIRECTIONS {
        let apart = |c: &&Value| {
            let angle = c["angle"].as_f64().unwrap();
            ((angle - direction + 180.0).rem_euclid(360.0) - 180.0).abs() < 1.5
        };
        let crack = cracks.iter().find(apart).unwrap();
        assert!(
            (crack["begin"].as_f64().unwrap() - 0.2).abs() < 0.1,
            "{crack}"
        );
        assert!(crack["end"].as_f64().unwrap() > 0.95, "{crack}");
        assert_eq!(crack["open_at_bark"], true);
    }
    let recipe = String::from_utf8(folder.read("cracks.toml")).unwrap();
    assert!(
        recipe.starts_with("# cracks measured in end.png\n"),
        "{recipe}"
    );
    assert!(
        recipe.contains("# command: cracks\n# input: end.png\n"),
        "{recipe}"
    );
    assert_eq!(recipe.matches("[[crack]]").count(), 3, "{recipe}");

    let drawn = folder.quick(&["--recipe", "cracks.toml", "-o", "cracked.glb", "--json"]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let drawn: Value = serde_json::from_str(&drawn.out).unwrap();
    assert!(drawn["crack_volume_m3"].as_f64().unwrap() > 0.0, "{drawn}");
}

#[test]
fn what_is_no_photograph_of_a_section_is_refused() {
    let folder = Folder::new();
    folder.write("end.png", photograph());
    folder.write("text.png", "no picture");
    let grey = RgbImage {
        width: 64,
        height: 64,
        rgb: vec![128; 3 * 64 * 64],
    };
    folder.write("grey.png", grey.png());
    let cases: [(&[&str], &str); 4] = [
        (&["cracks", "--from", "absent.png"], "absent.png"),
        (&["cracks", "--from", "text.png"], "text.png"),
        (&["cracks", "--from", "grey.png"], "--outline"),
        (&["cracks", "--from", "end.png", "-o", "c.json"], ".toml"),
    ];
    for (arguments, says) in cases {
        let run = folder.run(arguments);
        assert_ne!(run.code, 0, "{arguments:?}");
        assert!(run.err.contains(says), "{arguments:?}: {}", run.err);
    }
    assert_eq!(folder.names(), ["end.png", "grey.png", "text.png"]);
}
