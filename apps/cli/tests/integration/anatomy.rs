//! `greenstick anatomy`: what it writes and what it refuses.

use crate::support::Folder;
use serde_json::Value;
use std::f64::consts::PI;

/// An OBJ cylinder of radius 1 and length 8, in whatever unit.
fn cylinder() -> String {
    let mut text = String::new();
    let (around, rows) = (24, 12);
    for i in 0..=rows {
        for j in 0..around {
            let (s, c) = (2.0 * PI * f64::from(j) / f64::from(around)).sin_cos();
            text += &format!("v {c:.6} {s:.6} {}\n", 8.0 * f64::from(i) / f64::from(rows));
        }
    }
    let at = |i: i32, j: i32| i * around + j % around + 1;
    for i in 0..rows {
        for j in 0..around {
            let corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            text += &format!(
                "f {} {} {} {}\n",
                corners[0], corners[1], corners[2], corners[3]
            );
        }
    }
    let face = |i: i32, back: bool| {
        let mut corners: Vec<String> = (0..around).map(|j| at(i, j).to_string()).collect();
        if back {
            corners.reverse();
        }
        format!("f {}\n", corners.join(" "))
    };
    text + &face(0, true) + &face(rows, false)
}

fn numbers(folder: &Folder, path: &str) -> Value {
    serde_json::from_slice(&folder.read(path)).unwrap()
}

#[test]
fn a_cylinder_has_its_volume_and_its_rings() {
    let folder = Folder::new();
    folder.write("log.obj", cylinder());
    let arguments =
        "anatomy log.obj --unit cm -o in --resolution 48 --rings 8 --layers 5 --sectors 12";
    let run = folder.run(&arguments.split(' ').collect::<Vec<_>>());
    assert_eq!(run.code, 0, "{}", run.err);
    let report = numbers(&folder, "in/anatomy.json");
    // 24 corners of a circle of 1 cm, 8 cm long.
    let volume = 12.0 * (PI / 12.0).sin() * 1e-4 * 0.08;
    let found = |name: &str| report[name].as_f64().unwrap();
    assert!((found("mesh_volume_m3") / volume - 1.0).abs() < 1e-5);
    assert!((found("voxel_volume_m3") / volume - 1.0).abs() < 0.01);
    assert_eq!(
        (&report["particles"], &report["equation_1"]),
        (&480.into(), &480.into())
    );
    let rings = &report["sections"][2]["rings"];
    for k in 0..8 {
        // Rings of a circle about its middle are circles of equal width.
        let radius = rings["radius_m"][k].as_f64().unwrap();
        assert!(
            (radius / (0.00125 * (k + 1) as f64) - 1.0).abs() < 0.02,
            "{k}: {radius}"
        );
    }
    let csv = String::from_utf8(folder.read("in/particles.csv")).unwrap();
    assert_eq!(csv.lines().count(), 481);
    for name in [
        "volume.vtm",
        "longitudinal.png",
        "surface_rings.glb",
        "particles.parquet",
    ] {
        assert!(!folder.read(&format!("in/{name}")).is_empty());
    }
}

#[test]
fn wood_without_measured_rings_stays_so_when_another_stem_takes_them() {
    let folder = Folder::new();
    folder.write("log.obj", cylinder());
    let base = "anatomy log.obj --unit cm --resolution 48 --layers 3 --only cores";
    let rings = |out: &str, more: &str| {
        let arguments = format!("{base} -o {out} {more}");
        let run = folder.run(&arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, 0, "{}", run.err);
        let report = numbers(&folder, &format!("{out}/anatomy.json"));
        let widths = String::from_utf8(folder.read(&format!("{out}/ring_widths.csv"))).unwrap();
        (report, widths)
    };
    // Two years of 5 mm in a radius of 10 mm, of which the bark takes a part.
    let (first, widths) = rings("in", "--ring-widths 2mm,3mm");
    assert_eq!(first["unmeasured_ring"], 3);
    assert_eq!(widths.lines().count(), 1 + 4 * 2, "{widths}");
    let (second, again) = rings("again", "--rings-from in");
    assert_eq!(second["unmeasured_ring"], 3);
    assert_eq!(second["rings"], first["rings"]);
    assert_eq!(again.lines().count(), 1 + 4 * 2, "{again}");
}

#[test]
fn eroded_rings_are_those_of_the_publication() {
    let folder = Folder::new();
    folder.write("log.obj", cylinder());
    let base = "anatomy log.obj --unit cm -o in --resolution 64 --layers 3 --only particles --rings-by erosion";
    let run = |more: &str| {
        let arguments = format!("{base}{more}");
        folder.run(&arguments.split(' ').collect::<Vec<_>>())
    };
    let done = run("");
    assert_eq!(done.code, 0, "{}", done.err);
    let report = numbers(&folder, "in/anatomy.json");
    // The circle's radius is 64/2/1.04 = 30.8 pixels; its inscribed square is 21.8 to either side, a pixel for each pass,
    // and two passes make a ring.
    assert_eq!(
        (&report["rings"], &report["rings_by"]),
        (&11.into(), &"erosion, alternating".into())
    );
    // The same kernels as a list.
    let done = run(" --kernels 3");
    assert_eq!(done.code, 0, "{}", done.err);
    let listed = numbers(&folder, "in/anatomy.json");
    assert_eq!(listed["rings_by"], "erosion, kernels 3/3");
    assert_eq!(listed["sections"], report["sections"]);
    let done = run(" --schedule figure-6");
    assert_eq!(done.code, 0, "{}", done.err);
    let wide = numbers(&folder, "in/anatomy.json");
    assert!(wide["rings"].as_u64() < report["rings"].as_u64());
    // Two fronts: from a circle of 0.4 radii (12.3 pixels) the inner one runs outwards, a pixel for each pass, and meets
    // the outer one: rings about the pith begin with a circle, whereas one front alone ends in a square.
    let done = run(" --inner-circle 0.4");
    assert_eq!(done.code, 0, "{}", done.err);
    let both = numbers(&folder, "in/anatomy.json");
    assert_eq!(
        both["rings_by"],
        "erosion, alternating, and from a circle of 0.4 radii"
    );
    let row = |n: &Value| {
        let rings = &n["sections"][0]["rings"]["radius_m"];
        rings
            .as_array()
            .unwrap()
            .iter()
            .map(|r| r.as_f64().unwrap())
            .collect::<Vec<_>>()
    };
    let (one_sided, two_sided) = (row(&report), row(&both));
    let outermost = two_sided[two_sided.len() - 1];
    let inner = two_sided.iter().find(|r| **r > 0.0).unwrap() / outermost;
    // The first ring is the circle with a pass of earlywood and one of latewood about it, each the sum of what is there
    // and a square of 3 pixels: πr² + 8rk + 4k² pixels after k passes.
    let (r, k) = (0.4 * 64.0 / 2.08, 2.0);
    let area = std::f64::consts::PI * r * r + 8.0 * r * k + 4.0 * k * k;
    let expected = (area / std::f64::consts::PI).sqrt() / (64.0 / 2.08);
    assert!(
        (inner - expected).abs() < 0.015,
        "{inner} {expected}: {two_sided:?}"
    );
    assert!(one_sided[0] / outermost < 0.1, "{one_sided:?}");
    assert!(two_sided.is_sorted());
    let done = run(" --inner-circle 0.3 --schedule eccentric");
    assert_eq!(done.code, 0, "{}", done.err);
    let done = run(" --inner-circle 1.5");
    assert!(
        done.code == 2 && done.err.contains("must be above 0"),
        "{}",
        done.err
    );
    let done = run(" --rings 9");
    assert!(
        done.code == 2 && done.err.contains("its own number of rings"),
        "{}",
        done.err
    );
}

#[test]
fn wrong_requests_are_refused() {
    let folder = Folder::new();
    folder.write("log.obj", cylinder());
    let run = |arguments: &str| folder.run(&arguments.split(' ').collect::<Vec<_>>());
    for (arguments, message) in [
        ("anatomy log.obj -o in --resolution 31", "32"),
        ("anatomy log.obj -o in --rings 0", "from 1 to 1000"),
        (
            "anatomy log.obj -o in --surface-ring 9 --rings 8",
            "surface",
        ),
        (
            "anatomy log.obj -o in --schedule figure-6",
            "rings_by \"erosion\"",
        ),
        ("anatomy none.obj -o in", "none.obj"),
        ("anatomy log.obj -o log.obj", "log.obj"),
    ] {
        let done = run(arguments);
        assert!(
            done.code == 2 || done.code == 1,
            "{arguments}: {}",
            done.err
        );
        assert!(done.err.contains(message), "{arguments}: {}", done.err);
    }
    assert_eq!(folder.names(), ["log.obj"]);
    // 800 m long, in a format that does not say its unit.
    let text: String = cylinder()
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(rest) => {
                let scaled = rest
                    .split(' ')
                    .map(|n| (n.parse::<f64>().unwrap() * 100.0).to_string());
                format!("v {}\n", scaled.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    folder.write("long.obj", text);
    let done = run("anatomy long.obj -o in --resolution 32 --layers 2 --only particles");
    assert_eq!(done.code, 0, "{}", done.err);
    let report = numbers(&folder, "in/anatomy.json");
    let notes = report["notes"].as_array().unwrap();
    assert!(
        notes
            .iter()
            .any(|n| n.as_str().unwrap().contains("--unit mm")),
        "{notes:?}"
    );
    assert!(done.out.contains("--unit mm"));
}

/// Reads a CSV file: its headings, and its rows of cells.
fn cells(folder: &Folder, path: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = String::from_utf8(folder.read(path)).unwrap();
    let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<String>>();
    let mut lines = text.lines();
    (split(lines.next().unwrap()), lines.map(split).collect())
}

#[test]
fn many_stems_make_a_table_and_a_failure_stops_none() {
    let folder = Folder::new();
    folder.write("one.obj", cylinder());
    folder.write("two.obj", cylinder());
    folder.write("none.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let arguments = "anatomy one.obj none.obj two.obj --unit cm -o all --only measures,cores --layers 2 --rings 8 \
                     --last-year 2020";
    let done = folder.run(&arguments.split_whitespace().collect::<Vec<_>>());
    assert_eq!(done.code, 1, "{}", done.err);
    assert!(done.err.contains("none.obj"), "{}", done.err);
    assert!(done.out.contains("2 of 3 done"), "{}", done.out);
    let (headings, rows) = cells(&folder, "all/stems.csv");
    assert_eq!(&headings[..3], ["file", "folder", "length_m"]);
    let names: Vec<[&str; 2]> = rows.iter().map(|r| [&*r[0], &*r[1]]).collect();
    assert_eq!(
        names,
        [["one.obj", "one"], ["none.obj", ""], ["two.obj", "two"]]
    );
    let length: f64 = rows[0][2].parse().unwrap();
    assert!(
        (length - 0.08).abs() < 1e-3 && rows[1][2].is_empty(),
        "{length}"
    );
    // Stems give the same files alone.
    let alone = "anatomy two.obj --unit cm -o two --only measures,cores --layers 2 --rings 8 --last-year 2020";
    assert_eq!(folder.run(&alone.split(' ').collect::<Vec<_>>()).code, 0);
    for name in [
        "sections.csv",
        "rings.rwl",
        "rings_inwards.rwl",
        "ring_widths.csv",
    ] {
        let path = format!("two/{name}");
        assert_eq!(
            folder.read(&format!("all/{path}")),
            folder.read(&path),
            "{name}"
        );
    }
    let rings = String::from_utf8(folder.read("two/rings.rwl")).unwrap();
    // Seven rings of wood of 1.25 mm each, and one of bark.
    let line = rings.lines().nth(3).unwrap();
    assert!(line.starts_with("R000    2014"), "{rings}");
    let width: i32 = line[12..18].trim().parse().unwrap();
    assert!((width - 1250).abs() < 15, "{rings}");
    assert!(
        rings
            .lines()
            .next()
            .unwrap()
            .contains("two.obj pith to bark")
    );
    let described = numbers(&folder, "two/csv-metadata.json");
    assert_eq!(described["tables"][0]["url"], "sections.csv");
    assert_eq!(described["notes"][0]["input"], "two.obj");
}

#[test]
fn coordinates_of_the_input_come_back() {
    let folder = Folder::new();
    // A stem far from the origin, as points.
    let mut text = String::new();
    for i in 0..60 {
        for j in 0..40 {
            let (s, c) = (2.0 * PI * (f64::from(j) + 0.37 * f64::from(i)) / 40.0).sin_cos();
            let (x, y) = (477_000.0 + 0.1 * c, 5_429_000.0 + 0.1 * s);
            text += &format!("{x:.4} {y:.4} {:.4}\n", 310.0 + 0.05 * f64::from(i));
        }
    }
    folder.write("far.xyz", text);
    let run = |more: &str, out: &str| {
        let arguments = format!(
            "anatomy far.xyz -o {out} --only measures,elements --layers 2 --rings 6 --species spruce,sitka{more}"
        );
        let arguments = arguments.replace("spruce,sitka", "Sitka_spruce");
        let words: Vec<String> = arguments.split(' ').map(|w| w.replace('_', " ")).collect();
        let done = folder.run(&words.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(done.code, 0, "{}", done.err);
        numbers(&folder, &format!("{out}/anatomy.json"))
    };
    let local = run("", "local");
    let input = run(" --coordinates input", "input");
    let origin = &local["provenance"]["origin_m"];
    assert_eq!(origin, &input["provenance"]["origin_m"]);
    assert_eq!(input["provenance"]["coordinates"], "input");
    assert_eq!(input["provenance"]["input"], "far.xyz");
    assert!(input["provenance"]["residual_m"].as_f64().unwrap() < 0.01);
    for k in 0..3 {
        let at = |report: &Value| report["sections"][1]["centre_m"][k].as_f64().unwrap();
        let off = at(&input) - at(&local) - origin[k].as_f64().unwrap();
        assert!(off.abs() < 1e-6, "{off}");
    }
    let (headings, rows) = cells(&folder, "input/sections.csv");
    let column = |name: &str| headings.iter().position(|h| h == name).unwrap();
    let cell = |row: &[String], name: &str| row[column(name)].parse::<f64>().unwrap();
    for row in &rows {
        assert!((cell(row, "x_m") - 477_000.0).abs() < 0.05);
        assert!((cell(row, "pith_y_m") - 5_429_000.0).abs() < 0.05);
        assert!((cell(row, "diameter_by_area_m") - 0.2).abs() < 0.01);
        assert!(cell(row, "diameter_by_area_error_m") < 0.01);
    }
    // The elements carry where they come from, in the input's coordinates, and what CalculiX needs.
    let deck = String::from_utf8(folder.read("input/stem.inp")).unwrap();
    for line in [
        "** input: far.xyz",
        "** coordinates: input",
        "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
    ] {
        assert!(deck.contains(line), "{line}");
    }
    let node = deck
        .lines()
        .skip_while(|l| !l.starts_with("*NODE"))
        .nth(1)
        .unwrap();
    let x: f64 = node.split(',').nth(1).unwrap().parse().unwrap();
    assert!((x - 477_000.0).abs() < 0.2, "{node}");
    let mass = &input["mass"];
    assert!(mass["mass_kg"].as_f64() > mass["dry_mass_kg"].as_f64());
    let elements = &input["elements"];
    let share =
        elements["volume_m3"].as_f64().unwrap() / elements["sections_volume_m3"].as_f64().unwrap();
    assert!((share - 1.0).abs() < 5e-3, "{share}");
}
