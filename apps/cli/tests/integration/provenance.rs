//! What the program writes says where it comes from: program, version, command, input, parameters and seed.

use crate::support::{Folder, QUICK};
use serde_json::{Value, json};

/// A short stick that is pressed down for a blink.
const SCENE: &str = "duration = 0.004\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nname = \"press\"\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n";

/// The JSON of a GLB file.
fn document(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn pieces_carry_it_in_all_formats_that_have_a_place() {
    let folder = Folder::new();
    for name in ["b.glb", "b.obj", "b.ply"] {
        let run = folder.quick(&["--set", "rings=8", "--seed", "3", "-o", name, "--json"]);
        assert_eq!(run.code, 0, "{}", run.err);
        let report: Value = serde_json::from_str(&run.out).unwrap();
        let made = &report["provenance"];
        assert_eq!(
            (&made["command"], &made["seed"]),
            (&json!("break"), &json!(3))
        );
        assert_eq!(made["version"], env!("CARGO_PKG_VERSION"));
        let parameters = made["parameters"].as_array().unwrap();
        assert!(
            parameters.contains(&json!("break.rings=8")),
            "{parameters:?}"
        );
    }
    let extras = &document(&folder.read("b.glb"))["asset"]["extras"];
    assert_eq!(
        (&extras["command"], &extras["seed"]),
        (&json!("break"), &json!("3"))
    );
    let says = [
        ("b.obj", "# seed: 3\n"),
        ("b.mtl", "# seed: 3\n"),
        ("b.ply", "comment seed: 3\n"),
    ];
    for (name, says) in says {
        let text = String::from_utf8_lossy(&folder.read(name)).into_owned();
        assert!(text.contains(says), "{name}");
    }
}

/// The commands that the metadata of a folder's tables and a picture beside them name, and the tables' columns with their
/// units; those of each table are the ones of its heading.
fn told(folder: &Folder, name: &str, chart: &str) -> [String; 3] {
    let metadata: Value =
        serde_json::from_slice(&folder.read(&format!("{name}/csv-metadata.json"))).unwrap();
    let mut units = Vec::new();
    for table in metadata["tables"].as_array().unwrap() {
        let file = table["url"].as_str().unwrap();
        let csv = String::from_utf8(folder.read(&format!("{name}/{file}"))).unwrap();
        let columns = table["tableSchema"]["columns"].as_array().unwrap();
        let names: Vec<&str> = columns.iter().filter_map(|c| c["name"].as_str()).collect();
        assert_eq!(names.join(","), csv.lines().next().unwrap(), "{file}");
        for c in columns {
            units.push(format!("{} {}", c["name"], c["schema:unitText"]));
        }
    }
    // An international text chunk: keyword, five bytes that say that it is plain, text.
    let png = folder.read(&format!("{name}/{chart}"));
    let at = png.windows(8).position(|w| w == b"command\0").unwrap();
    let length = u32::from_be_bytes(png[at - 8..at - 4].try_into().unwrap()) as usize;
    let text = String::from_utf8_lossy(&png[at + 12..at + length]).into_owned();
    [
        metadata["notes"][0]["command"].as_str().unwrap().to_owned(),
        text,
        units.join("; "),
    ]
}

#[test]
fn tables_charts_and_pictures_of_runs_and_tests_carry_it() {
    let folder = Folder::new();
    folder.write("small.toml", SCENE);
    let size = ["--picture-size", "40x40", "--samples", "1"];
    let run = folder.run(&[&["simulate", "small.toml", "-o", "run"][..], &size].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    for picture in ["energy.png", "load-deflection.png", "frame-00000.png"] {
        let [tables, shown, units] = told(&folder, "run", picture);
        assert_eq!(
            [&tables, &shown],
            [&"simulate small.toml", &"simulate small.toml"]
        );
        for column in [
            "\"kinetic_J\" \"J\"",
            "\"cause\" null",
            "\"moment_x_Nm\" \"N m\"",
        ] {
            assert!(units.contains(column), "{units}");
        }
    }
    let scene = String::from_utf8(folder.read("run/scene.toml")).unwrap();
    assert!(
        scene.contains("# command: simulate small.toml\n"),
        "{scene}"
    );
    let test = [
        "fracture-test",
        "--species",
        "Norway spruce",
        "--spacing",
        "5mm",
        "--edge",
        "5mm",
    ];
    let run = folder.run(&[&test[..], &["-o", "opening"]].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    let [tables, shown, units] = told(&folder, "opening", "load-deflection.png");
    assert_eq!([&tables, &shown], [&"fracture-test", &"fracture-test"]);
    assert!(units.contains("\"compliance_m_per_N\" \"m/N\""), "{units}");
}

#[test]
fn reports_and_films_carry_it() {
    let folder = Folder::new();
    let outline: Vec<[f64; 2]> = (0..90u32)
        .map(|i| (4.0 * f64::from(i)).to_radians().sin_cos())
        .map(|(s, c)| [100.0 * c, 100.0 * s])
        .collect();
    folder.write("s.json", json!({ "outer_contour": outline }).to_string());
    let run = folder.run(&["rings", "s.json", "--rings", "7", "-o", "r.json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rings: Value = serde_json::from_slice(&folder.read("r.json")).unwrap();
    let made = &rings["provenance"];
    assert_eq!(
        (&made["command"], &made["input"]),
        (&json!("rings"), &json!("s.json"))
    );
    assert_eq!(made["parameters"], json!(["rings=7"]));

    let bend = [
        "bend-test",
        "--species",
        "white oak",
        "--rods",
        "9",
        "--edge",
        "60mm",
    ];
    let run = folder.run(&[&bend[..], &["--end", "0.97", "--seed", "4", "-o", "oak"]].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    let test: Value = serde_json::from_slice(&folder.read("oak/bend-test.json")).unwrap();
    let made = &test["provenance"];
    assert_eq!(
        (&made["command"], &made["seed"]),
        (&json!("bend-test"), &json!(4))
    );

    folder.write("small.toml", SCENE);
    let simulate = [
        "simulate",
        "small.toml",
        "-o",
        "run",
        "--no-pictures",
        "--json",
    ];
    let run = folder.run(&simulate);
    assert_eq!(run.code, 0, "{}", run.err);
    let report: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["provenance"]["command"], "simulate small.toml");
    let run = folder.run(&["skin", "run", "-o", "f.glb", "--texture-size", QUICK[1]]);
    assert_eq!(run.code, 0, "{}", run.err);
    let extras = &document(&folder.read("f.glb"))["asset"]["extras"];
    assert_eq!(extras["command"], "skin");
    let parameters = extras["parameters"].as_str().unwrap();
    assert!(parameters.contains("duration=0.004"), "{extras}");
    let run = folder.run(&["skin", "run", "--frame", "-1", "-o", "s.usda"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let usd = String::from_utf8(folder.read("s.usda")).unwrap();
    assert!(usd.contains("doc = \"program: greenstick; version: "));
    let run = folder.run(&["skin", "run", "-o", "f.pvd"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rods = String::from_utf8_lossy(&folder.read("f_00000_rods.vtp")).into_owned();
    assert!(rods.contains("Name=\"command\""));
}
