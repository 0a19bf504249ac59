//! `greenstick break` of point clouds.

use crate::support::Folder;
use crate::support::data::data;
use std::fmt::Write;

/// XYZ of a cylinder of 5 cm radius, 0.6 m long, at the coordinates of a survey, its turns from 0 to `seen`.
fn cylinder(seen: f64) -> String {
    let mut text = String::from("# a cylinder\n");
    // Steps of the golden ratio and of another number far from fractions cover the surface evenly.
    for i in 0..6000 {
        let turn = (f64::from(i) * 0.618_033_988_749_895).fract() * seen;
        let along = (f64::from(i) * 0.754_877_666_246_693).fract();
        let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
        let z = 100.0 + 0.6 * along;
        let _ = writeln!(text, "{:.5} {:.5} {z:.5}", 5000.0 + 0.05 * c, 0.05 * s);
    }
    text + "5000.3 0.2 100.1\n5000.0 -0.4 100.9\n"
}

#[test]
fn a_cloud_is_broken_and_reported() {
    let folder = Folder::new();
    folder.write("a.xyz", cylinder(1.0));
    let run = folder.quick(&["a.xyz", "--at", "0.5", "-o", "b.glb", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let scan = &report["scan"];
    assert_eq!(scan["clean"]["read"], 6002);
    assert_eq!(scan["origin_m"][0], 5000.0);
    let radius = scan["bark"]["radius_m"].as_f64().unwrap();
    assert!((radius - 0.05).abs() < 0.001, "{radius}");
    assert!(scan["bark"]["mean_cover"].as_f64().unwrap() > 0.95);
    // Both pieces are closed, and together a cylinder.
    let volume: f64 = (0..2)
        .map(|i| report["pieces"][i]["volume_m3"].as_f64().unwrap())
        .sum();
    let length = scan["bark"]["span_m"][1].as_f64().unwrap();
    let whole = std::f64::consts::PI * 0.05 * 0.05 * length;
    assert!((volume / whole - 1.0).abs() < 0.1, "{volume} of {whole}");
    assert_eq!(folder.names(), ["a.xyz", "b.glb"]);
    // The same in words, at a point in the file's coordinates, without the cleaning of outliers.
    let run = folder.quick(&[
        "a.xyz",
        "--at",
        "5000.05,0,100.3",
        "--no-outliers",
        "-o",
        "c.ply",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    for part in [
        "columns 1, 2, 3 are coordinates",
        "cover ",
        "were subtracted",
    ] {
        assert!(run.out.contains(part), "{}", run.out);
    }
    assert!(!run.out.contains("outliers:"), "{}", run.out);
}

#[test]
fn half_a_cloud_is_refused_where_more_is_asked_for() {
    let folder = Folder::new();
    folder.write("a.xyz", cylinder(0.5));
    let run = folder.quick(&["a.xyz", "--least-cover", "0.7"]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(
        run.err.contains("at least 70 %") && run.err.contains("--least-cover"),
        "{}",
        run.err
    );
    let run = folder.quick(&["a.xyz", "--outliers", "-1"]);
    assert_eq!(run.code, 2);
    let run = folder.quick(&["a.xyz", "--no-outliers", "--outliers", "2"]);
    assert_eq!(run.code, 2);
    folder.write("b.xyz", "1 2 3\n4 5 6\n");
    let run = folder.quick(&["b.xyz"]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("of 2 points are left"), "{}", run.err);
    assert_eq!(folder.names(), ["a.xyz", "b.xyz"]);
}

#[test]
fn a_board_as_a_scan_is_squared_timber() {
    let folder = Folder::new();
    let board = data("homecart_cutting_board.gltf");
    let run = folder.quick(&[
        board.to_str().unwrap(),
        "--as-scan",
        "-o",
        "b.glb",
        "--json",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    // 681.6 mm wide and 25.4 mm thick between the file's own bounds.
    let notes = report["scan"]["notes"].to_string();
    assert!(
        notes.contains("squared timber of 68") && notes.contains(" × 25 mm"),
        "{notes}"
    );
    assert_eq!(report["place"]["kind"], "board");
}

#[test]
fn a_cloud_is_simulated_and_its_run_needs_no_other_file() {
    let folder = Folder::new();
    folder.write("a.xyz", cylinder(1.0));
    let scene = "duration = 0.02\n[rods]\nnumber = 12\nedge = [\"25 mm\", \"30 mm\"]\n[[clamp]]\nto = 0.2\n";
    folder.write("s.toml", scene);
    let run = folder.run(&[
        "simulate",
        "s.toml",
        "a.xyz",
        "-o",
        "run",
        "--no-pictures",
        "--json",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let length = report["length_m"].as_f64().unwrap();
    assert!((length - 0.6).abs() < 0.03, "{length}");
    assert_eq!(report["provenance"]["input"], "a.xyz");
    assert_eq!(report["provenance"]["origin_m"][0], 5000.0);
    assert!(report["provenance"]["coverage"].as_f64().unwrap() > 0.95);
    assert!(report["files"].to_string().contains("scan.glb"));
    let notes = report["notes"].to_string();
    assert!(notes.contains("subtracted"), "{notes}");
    // Moved, and without the cloud.
    std::fs::rename(folder.0.join("run"), folder.0.join("moved")).unwrap();
    std::fs::remove_file(folder.0.join("a.xyz")).unwrap();
    let skin = folder.run(&[
        "skin",
        "moved",
        "--frame",
        "-1",
        "-o",
        "s.ply",
        "--texture-size",
        "64",
    ]);
    assert_eq!(skin.code, 0, "{}", skin.err);
    let refused = folder.run(&["simulate", "s.toml", "s.toml", "-o", "other"]);
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(!folder.0.join("other").exists());
}
