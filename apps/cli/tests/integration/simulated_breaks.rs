//! Breaks that are simulated: the pieces that they leave, and the recipe that is fitted to them.

use crate::support::{Folder, QUICK};

/// Held at one end and torn off at the other: of a few coarse, soft rods, so that it takes seconds.
const PULL: &str = "duration = 0.02\nframes_per_second = 250.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[clamp]]\nfrom = 0.8\nto = 1.0\n\
[[clamp.key]]\ntime = 0.0\n[[clamp.key]]\ntime = 0.02\nmove_by = \"20, 0, 0 mm\"\n";

/// The number behind a key in JSON.
fn number(json: &str, key: &str) -> f64 {
    let value: serde_json::Value = serde_json::from_str(json).unwrap();
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key}: {json}"))
}

/// The binary chunk of a GLB file: meshes and pictures without what describes them.
fn binary(glb: &[u8]) -> &[u8] {
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    &glb[20 + json..]
}

#[test]
fn a_simulated_break_gives_halves_that_fill_the_wood_and_a_recipe_that_breaks_it() {
    let folder = Folder::new();
    folder.write("pull.toml", PULL);
    let made = folder.quick(&["--simulate", "pull.toml", "-o", "halves.glb", "--json"]);
    assert_eq!(made.code, 0, "{}{}", made.out, made.err);
    let told: serde_json::Value = serde_json::from_str(&made.out).unwrap();
    assert_eq!(told["hangs_together"], false, "{}", made.out);
    let pieces = told["pieces"].as_array().unwrap();
    let name = |n: usize| pieces[n]["name"].as_str().unwrap();
    assert_eq!((name(0), name(1)), ("lower", "upper"), "{}", made.out);
    assert!(pieces.len() < 3 || name(2) == "splinter_000");
    // At rest the pieces fill the cylinder of 48 sides that the rods did.
    let volume: f64 = pieces
        .iter()
        .map(|p| p["volume_m3"].as_f64().unwrap())
        .sum();
    let turn = std::f64::consts::TAU / 48.0;
    let whole = 24.0 * turn.sin() * 0.003f64.powi(2) * 0.06;
    assert!(
        (0.9..1.001).contains(&(volume / whole)),
        "{volume} of {whole}"
    );
    let check = folder.run(&["check", "halves.glb", "--json", "--fast"]);
    let check: serde_json::Value = serde_json::from_str(&check.out).unwrap();
    let is_piece = |mesh: &&serde_json::Value| !mesh["name"].as_str().unwrap().ends_with("_fuzz");
    let meshes: Vec<_> = check[0]["meshes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(is_piece)
        .collect();
    assert_eq!(meshes.len(), pieces.len());
    for mesh in meshes {
        assert!(mesh["closed"] == true && mesh["oriented"] == true, "{mesh}");
    }

    // A run from its folder is cut into the same bytes as one in memory.
    let run = folder.run(&["simulate", "pull.toml", "-o", "run", "--no-pictures"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let again = folder.quick(&["--from-run", "run", "-o", "again.glb", "--json"]);
    assert_eq!(again.code, 0, "{}{}", again.out, again.err);
    assert!(binary(&folder.read("again.glb")) == binary(&folder.read("halves.glb")));
    let told: serde_json::Value = serde_json::from_str(&again.out).unwrap();
    let face = &told["simulated"][0];
    assert!(face["parted"] == true && face["mode"] == "torn", "{told}");
    let none = folder.quick(&["--from-run", "run", "--save-recipe", "faces.toml"]);
    assert!(
        none.code == 2 && none.err.contains("a recipe breaks the mesh of a file"),
        "{}",
        none.err
    );
    let none = folder.quick(&["--from-run", "run", "--frame", "0", "-o", "none.glb"]);
    assert!(
        none.code == 2 && none.err.contains("no rod is broken"),
        "{}",
        none.err
    );
    let fit = folder.run(&["fit", "run", "-o", "recipe.toml", "--json"]);
    assert_eq!(fit.code, 0, "{}", fit.err);
    assert!(number(&fit.out, "broken") >= 10.0, "{}", fit.out);
    let report: serde_json::Value = serde_json::from_str(&fit.out).unwrap();
    let at = report["at"].as_str().unwrap();
    let arguments = ["--at", at, "--recipe", "recipe.toml", "-o", "drawn.glb"];
    let drawn = folder.quick(&arguments);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    // Nothing is broken in the first frame.
    let none = folder.run(&["fit", "run", "--frame", "0"]);
    assert_eq!(none.code, 2);
    assert!(
        none.err.contains("no rod is broken at 0.0000 s"),
        "{}",
        none.err
    );
}

#[test]
fn wood_that_does_not_part_is_one_piece_and_said_to_be() {
    let folder = Folder::new();
    let weak = PULL
        .replace("duration = 0.02", "duration = 0.004")
        .replace("20, 0, 0 mm", "0.1, 0, 0 mm");
    folder.write("weak.toml", weak);
    let made = folder.quick(&["--simulate", "weak.toml", "-o", "one.glb"]);
    assert_eq!(made.code, 0, "{}{}", made.out, made.err);
    assert!(made.out.contains("still hangs together"), "{}", made.out);
    assert!(made.out.contains("piece    whole: 12 rods"), "{}", made.out);
    let rods = folder.quick(&["--simulate", "weak.toml", "--faces", "rods", "--hang", "30"]);
    assert!(
        rods.code == 2 && rods.err.contains("--faces drawn"),
        "{}",
        rods.err
    );
    // What only a drawn break has is refused beside it.
    let both = folder.run(
        &[
            &["break"],
            &QUICK[..],
            &["--simulate", "bend", "--at", "0.3"],
        ]
        .concat(),
    );
    assert_eq!(both.code, 2);
    assert!(both.err.contains("makes a stem of its own"), "{}", both.err);
}

/// A stick whose ends are turned until one side of it tears.
const BEND: &str = "duration = 0.02\nframes_per_second = 500.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 24\nedge = [\"2 mm\", \"3 mm\"]\ntwist = \"off\"\n\
[[clamp]]\nto = 0.1\narc = true\n\
[[clamp.key]]\ntime = 0.0\n[[clamp.key]]\ntime = 0.02\nturn = [0.0, 10.0, 0.0]\n\
[[clamp]]\nfrom = 0.9\nto = 1.0\narc = true\n\
[[clamp.key]]\ntime = 0.0\n[[clamp.key]]\ntime = 0.02\nturn = [0.0, -10.0, 0.0]\n";

/// The lowest and the highest corner of a mesh in a GLB file.
fn bounds(glb: &[u8], name: &str) -> [Vec<f64>; 2] {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let meshes = json["meshes"].as_array().unwrap();
    let mesh = meshes.iter().find(|m| m["name"] == name).unwrap();
    let primitives = mesh["primitives"].as_array().unwrap();
    let corner = |key: &str, pick: fn(f64, f64) -> f64| {
        let of = |p: &serde_json::Value| -> Vec<f64> {
            let at = p["attributes"]["POSITION"].as_u64().unwrap() as usize;
            serde_json::from_value(json["accessors"][at][key].clone()).unwrap()
        };
        let all = primitives.iter().map(of);
        all.reduce(|a, b| a.iter().zip(b).map(|(&a, b)| pick(a, b)).collect())
            .unwrap()
    };
    [corner("min", f64::min), corner("max", f64::max)]
}

#[test]
fn wood_that_tears_on_one_side_stays_bent_about_the_other() {
    let folder = Folder::new();
    folder.write("bend.toml", BEND);
    let run = folder.run(&["simulate", "bend.toml", "-o", "run", "--no-pictures"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let held = folder.quick(&["--from-run", "run", "-o", "held.glb", "--json"]);
    assert_eq!(held.code, 0, "{}{}", held.out, held.err);
    let told: serde_json::Value = serde_json::from_str(&held.out).unwrap();
    let face = &told["simulated"][0];
    assert!(face["parted"] == false, "{told}");
    let whole = face["unbroken_share"].as_f64().unwrap();
    assert!((0.1..0.9).contains(&whole), "{told}");
    // In memory the same.
    let again = folder.quick(&["--simulate", "bend.toml", "-o", "again.glb", "--json"]);
    assert_eq!(again.code, 0, "{}{}", again.out, again.err);
    assert!(binary(&folder.read("held.glb")) == binary(&folder.read("again.glb")));
    assert!(again.out.contains("\"hangs_together\": true"));
    // The base stays where it was at rest.
    let (held, rest) = (folder.read("held.glb"), "rest.glb");
    let apart = folder.quick(&["--from-run", "run", "--part", "1mm", "-o", rest, "--json"]);
    assert!(!apart.out.contains("the wood holds"), "{}", apart.out);
    let rest = folder.read(rest);
    let [low, high] = bounds(&rest, "lower");
    let [held_low, held_high] = bounds(&held, "lower");
    let along = (0..3)
        .max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b])))
        .unwrap();
    let off = f64::min(
        (held_low[along] - low[along]).abs(),
        (held_high[along] - high[along]).abs(),
    );
    assert!(off < 2e-4, "{off}");
    // Its middle lies aside by as much as an arc of 48 mm leaves its tangent.
    let middle = |[low, high]: [Vec<f64>; 2]| {
        let across = (0..3).filter(|&k| k != along);
        across
            .map(|k| (0.5 * (low[k] + high[k])).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    assert!(middle(bounds(&rest, "upper")) < 1e-3);
    let aside = middle(bounds(&held, "upper"));
    assert!((7e-3..10e-3).contains(&aside), "{aside}");
}

#[test]
fn a_mesh_breaks_where_at_says_and_keeps_its_other_parts() {
    let folder = Folder::new();
    let scene = PULL.replace("kind = \"cylinder\"", "kind = \"input\"\nat = \"0.9\"");
    folder.write("pull.toml", scene);
    folder.write("own.toml", PULL);
    // A stick of eight sides, and a chip that touches nothing.
    let mut obj = String::new();
    let mut first = 1;
    for (x, radius, length) in [(0.0, 0.003, 0.06), (0.5, 0.001, 0.002)] {
        obj += if first == 1 { "o stick\n" } else { "o chip\n" };
        let rows = 12;
        for row in 0..=rows {
            for side in 0..8 {
                let turn = f64::from(side) * std::f64::consts::TAU / 8.0;
                let (z, c) = (radius * turn.sin(), x + radius * turn.cos());
                obj += &format!("v {c} {} {z}\n", length * f64::from(row) / f64::from(rows));
            }
        }
        let at = |row: i32, side: i32| first + 8 * row + side % 8;
        for row in 0..rows {
            for side in 0..8 {
                let (a, b) = (at(row, side), at(row, side + 1));
                obj += &format!("f {a} {} {} {b}\n", a + 8, b + 8);
            }
        }
        let ends = [(0, 1), (rows, -1)].map(|(row, step)| {
            let ring = (0..8).map(|k| at(row, (8 + step * k) % 8).to_string());
            format!("f {}\n", ring.collect::<Vec<_>>().join(" "))
        });
        obj += &ends.concat();
        first += 8 * (rows + 1);
    }
    folder.write("stick.obj", obj);
    let arguments = [
        "stick.obj",
        "--simulate",
        "pull.toml",
        "--at",
        "0.5",
        "--faces",
        "rods",
        "-o",
        "out.glb",
        "--json",
    ];
    let made = folder.quick(&arguments);
    assert_eq!(made.code, 0, "{}{}", made.out, made.err);
    let told: serde_json::Value = serde_json::from_str(&made.out).unwrap();
    let rest = told["rest"]["pieces"].as_array().unwrap();
    assert_eq!(rest.len(), 1, "{told}");
    assert!(
        rest[0]["input"] == "chip" && rest[0]["carried_by"].is_null(),
        "{told}"
    );
    // A place is of a mesh.
    let none = folder.quick(&["--simulate", "own.toml", "--at", "0.5", "-o", "x.glb"]);
    assert!(
        none.code == 2 && none.err.contains("makes a stem of its own"),
        "{}",
        none.err
    );
}
