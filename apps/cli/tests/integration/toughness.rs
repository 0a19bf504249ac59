//! `greenstick fracture-test`: its files agree with each other, and what is wrong is refused.

use crate::support::Folder;
use serde_json::Value;

/// Options that make a test take a blink.
const COARSE: [&str; 10] = [
    "--crack",
    "6cm",
    "--length",
    "13cm",
    "--growth",
    "2cm",
    "--spacing",
    "5mm",
    "--edge",
    "5mm",
];

#[test]
fn the_report_is_what_the_curve_says() {
    let folder = Folder::new();
    let start = [
        "fracture-test",
        "--species",
        "Norway spruce",
        "-o",
        "spruce",
    ];
    let run = folder.run(&[&start[..], &COARSE[..]].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    let part = Folder(folder.0.join("spruce"));
    let files = [
        "csv-metadata.json",
        "fracture-test.json",
        "load-deflection.csv",
        "load-deflection.png",
    ];
    assert_eq!(part.names(), files);
    assert!(part.read("load-deflection.png").starts_with(b"\x89PNG"));
    let report: Value = serde_json::from_slice(&part.read("fracture-test.json")).unwrap();
    let curve = String::from_utf8(part.read("load-deflection.csv")).unwrap();
    let column = |name: &str| -> Vec<f64> {
        let at = curve.lines().next().unwrap().split(',');
        let at = at.clone().position(|n| n == name).unwrap();
        let cell = |line: &str| line.split(',').nth(at).unwrap().parse().unwrap();
        curve.lines().skip(1).map(cell).collect()
    };
    let (load, opening, crack) = (column("load_N"), column("deflection_m"), column("crack_m"));
    let greatest = load.iter().copied().fold(0.0, f64::max);
    assert_eq!(report["maximum_load_n"]["test"].as_f64(), Some(greatest));
    assert_eq!(report["final_crack_m"].as_f64(), crack.last().copied());
    // The work is the area below the curve.
    let area = |k: usize| 0.5 * (load[k] + load[k - 1]) * (opening[k] - opening[k - 1]);
    let work: f64 = (1..load.len()).map(area).sum();
    assert!((column("work_J").last().unwrap() / work - 1.0).abs() < 1e-9);
    // Between two cracks that the process zone has left behind, the dissipated work is the energy over the area.
    let dissipated = column("dissipated_J");
    let from = crack.iter().position(|&a| a > crack[0] + 0.004).unwrap();
    let last = crack.len() - 1;
    let energy = (dissipated[last] - dissipated[from]) / (0.02 * (crack[last] - crack[from]));
    let reported = report["by_work"]["test"].as_f64().unwrap();
    assert!(
        (energy / reported - 1.0).abs() < 0.05,
        "{energy} {reported}"
    );
}

#[test]
fn what_shows_nothing_is_refused_and_leaves_nothing() {
    let folder = Folder::new();
    for (options, word) in [
        (["--crack", "1cm"], "at least the specimen's height"),
        (["--spacing", "2cm"], "half the height"),
        (["--edge", "3cm"], "a quarter of the crack's growth"),
        (["--test", "bending"], "possible values"),
    ] {
        let start = ["fracture-test", "--species", "white oak", "-o", "oak"];
        let run = folder.run(&[&start[..], &options[..]].concat());
        assert_eq!(run.code, 2, "{options:?}");
        assert!(run.err.contains(word), "{}", run.err);
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
