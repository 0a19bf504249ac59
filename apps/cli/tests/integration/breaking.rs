//! `greenstick break` does what it says: files, report, the same bytes for the same seed.

use crate::support;
use crate::support::Folder;
use crate::support::data::data;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Asserts that the pieces are closed and have the input's volume together.
fn assert_volumes_add_up(report: &Value) {
    let pieces = report["pieces"].as_array().unwrap();
    assert!(pieces.len() >= 2, "{report}");
    let sum: f64 = pieces
        .iter()
        .map(|p| p["volume_m3"].as_f64().unwrap_or_else(|| panic!("{p}")))
        .sum();
    let whole = report["input"]["volume_m3"].as_f64().unwrap();
    assert!(((sum - whole) / whole).abs() < 1e-6, "{sum} {whole}");
    assert!(pieces.iter().all(|p| p["closed"] == true), "{report}");
}

#[test]
fn without_arguments_a_branch_breaks_into_two_files_and_a_report() {
    let folder = Folder::new();
    let run = folder.quick(&[]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{}", run.out);
    assert_eq!(folder.names(), ["broken.glb", "broken.png"]);
    assert!(folder.read("broken.glb").starts_with(b"glTF\x02"));
    assert!(folder.read("broken.png").starts_with(b"\x89PNG"));
    for part in ["cm³", "closed", "lower", "upper", "broken.glb", "time"] {
        assert!(run.out.contains(part), "{part}: {}", run.out);
    }
    let check = folder.run(&["check", "--strict", "--json", "broken.glb"]);
    assert_eq!(check.code, 0, "{}{}", check.out, check.err);
    let meshes = json(&check.out)[0]["meshes"].clone();
    assert_eq!(meshes[0]["name"], "lower");
    assert_eq!(meshes[0]["closed"], true);
    let volume = |m: &Value| m["volume_m3"].as_f64().unwrap();
    assert!(volume(&meshes[0]) > 0.0 && volume(&meshes[1]) > 0.0);
}

#[test]
fn the_json_report_has_all_numbers_and_nothing_else_is_printed() {
    let folder = Folder::new();
    let run = folder.quick(&[
        "--json",
        "-o",
        "a.glb",
        "--picture",
        "a.png",
        "--species",
        "white oak",
    ]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let report = json(&run.out);
    assert_volumes_add_up(&report);
    assert_eq!(report["species"]["name"], "Oak, white");
    for (output, name) in report["outputs"]
        .as_array()
        .unwrap()
        .iter()
        .zip(["a.glb", "a.png"])
    {
        assert_eq!(output["path"], name);
        assert_eq!(output["bytes"], folder.read(name).len());
    }
    let stages = report["stages"].as_array().unwrap();
    for name in [
        "read", "stem", "layout", "heights", "cut", "finish", "textures", "encode", "picture",
        "write",
    ] {
        let stage = stages.iter().find(|s| s["name"] == name);
        let seconds = stage.and_then(|s| s["seconds"].as_f64());
        assert!(seconds.is_some_and(|s| s >= 0.0), "{name}: {stages:?}");
    }
    assert_eq!(
        folder
            .run(&["break", "--texture-size", "64", "-o", "q.ply", "--quiet"])
            .out,
        ""
    );
    assert_eq!(folder.names(), ["a.glb", "a.png", "q.ply"]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let folder = Folder::new();
    let bytes = |seed: &str, threads: &str| {
        let run = folder.quick(&["--seed", seed, "--threads", threads]);
        assert_eq!(run.code, 0, "{}", run.err);
        (folder.read("broken.glb"), folder.read("broken.png"))
    };
    let first = bytes("5", "1");
    // assert_eq! would print megabytes.
    assert!(bytes("5", "1") == first, "a second run differs");
    assert!(bytes("5", "2") == first, "two threads differ from one");
    assert!(bytes("6", "2").0 != first.0, "another seed is the same");
}

#[test]
fn pieces_break_again_and_go_through_every_format() {
    let folder = Folder::new();
    // Formats without nodes join the pieces in one mesh, so each break keeps clear of the faces that are there. Of the first two pieces
    // one is clearly the larger, whatever their faces are.
    let steps = [
        ("a.obj", "0.45"),
        ("b.ply", "0.2"),
        ("c.stl", "0.75"),
        ("d.gltf", "0.3"),
        ("e.off", "0.1"),
    ];
    let names = steps.map(|(name, _)| name);
    let mut input: Option<&str> = None;
    for (name, at) in steps {
        let mut arguments = vec!["-o", name, "--json", "--preset", "brash", "--at", at];
        arguments.extend(input);
        let run = folder.quick(&arguments);
        assert_eq!(run.code, 0, "{name}: {}", run.err);
        let report = json(&run.out);
        assert!(report["pieces"].as_array().unwrap().len() >= 2);
        let outputs = report["outputs"].as_array().unwrap();
        for output in outputs {
            folder.read(output["path"].as_str().unwrap());
        }
        input = Some(name);
    }
    let check = folder.run(&[&["check", "--fast"], &names[..]].concat());
    assert_eq!(check.code, 0, "{}", check.err);
    assert!(!folder.names().iter().any(|n| n.ends_with(".part")));
}

#[test]
fn a_saved_recipe_gives_the_same_break_again() {
    let folder = Folder::new();
    let made = folder.quick(&[
        "--preset",
        "fig17",
        "--set",
        "seed=9",
        "--set",
        "rings=20",
        "-o",
        "a.ply",
        "--save-recipe",
        "r.toml",
    ]);
    assert_eq!(made.code, 0, "{}", made.err);
    let again = folder.quick(&["--recipe", "r.toml", "-o", "b.ply"]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(folder.read("a.ply") == folder.read("b.ply"));
}

/// All that decides the outcome stands in the recipe, the input's name too, which starts from the recipe's folder.
#[test]
fn a_recipe_alone_gives_the_same_bytes() {
    let folder = Folder::new();
    std::fs::create_dir(folder.0.join("kept")).unwrap();
    folder.write("kept/pole.ply", std::fs::read(data("pole.ply")).unwrap());
    let report = |run: &support::Run| {
        assert_eq!(run.code, 0, "{}", run.err);
        json(&run.out)["request_hash"].as_str().unwrap().to_owned()
    };
    let made = folder.quick(&[
        "kept/pole.ply",
        "--unit",
        "mm",
        "--at",
        "0.37",
        "--pith",
        "3,-2",
        "--preset",
        "splintering-tension",
        "--set",
        "rings=12",
        "--species",
        "white oak",
        "--moisture",
        "19",
        "--seed",
        "9",
        "--part",
        "3cm",
        "--fray",
        "0.2",
        "--view",
        "30,10",
        "-o",
        "a.glb",
        "--picture",
        "a.png",
        "--save-recipe",
        "kept/r.toml",
        "--json",
    ]);
    let hash = report(&made);
    let again = folder.run(&[
        "break",
        "--recipe",
        "kept/r.toml",
        "-o",
        "b.glb",
        "--picture",
        "b.png",
        "--save-recipe",
        "kept/again.toml",
        "--json",
    ]);
    assert_eq!(report(&again), hash);
    for (a, b) in [
        ("a.glb", "b.glb"),
        ("a.png", "b.png"),
        ("kept/r.toml", "kept/again.toml"),
    ] {
        assert!(folder.read(a) == folder.read(b), "{a} and {b} differ");
    }
    let other = folder.run(&[
        "break",
        "--recipe",
        "kept/r.toml",
        "--seed",
        "8",
        "-o",
        "c.ply",
        "--json",
    ]);
    assert_ne!(report(&other), hash);
}

/// A recipe of several breaks gives one piece more than there are breaks.
#[test]
fn a_recipe_may_hold_several_breaks_of_one_stem() {
    let folder = Folder::new();
    folder.write(
        "two.toml",
        "break.rings = 10\nbreak.splinter_lean = 0\nbreak.splinter_snap = 0\n[[breaks]]\nat = 0.3\n[[breaks]]\nat = '40 cm'\npart = '2 cm'\n",
    );
    let run = folder.quick(&["--recipe", "two.toml", "-o", "two.glb", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_volumes_add_up(&json(&run.out));
    assert_eq!(json(&run.out)["pieces"].as_array().unwrap().len(), 3);
    let run = folder.quick(&["--recipe", "two.toml", "--at", "0.5", "-o", "no.glb"]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("[[breaks]]"), "{}", run.err);
}

#[test]
fn several_breaks_of_a_bent_stem_leave_no_triangles_that_cross() {
    let folder = Folder::new();
    let text = "preset = \"brash\"\npart = \"2 cm\"\npart_clear = false\n\
        [[breaks]]\nat = 0.25\nbreak.inclination = 4\n\
        [[breaks]]\nat = 0.5\nbreak.inclination = 4\n\
        [[breaks]]\nat = 0.75\nbreak.inclination = 15\n";
    folder.write("three.toml", text);
    let mut run = vec!["break", "--recipe", "three.toml", "-o", "three.glb"];
    for setting in ["break.seed=2", "break.fuzz=0", "break.splinter_lean=0"] {
        run.extend(["--set", setting]);
    }
    run.extend(["--texture-size", "64"]);
    let run = folder.run(&run);
    assert_eq!(run.code, 0, "{}", run.err);
    let check = folder.run(&["check", "--json", "three.glb"]);
    assert_eq!(check.code, 0, "{}{}", check.out, check.err);
    for mesh in json(&check.out)[0]["meshes"].as_array().unwrap() {
        assert_eq!(mesh["self_intersections"]["crossing"], 0, "{mesh}");
    }
}

/// Textures are baked only for files that hold them.
#[test]
fn pictures_and_shapes_are_the_same_without_textures() {
    let folder = Folder::new();
    let with_textures = ["-o", "with.glb", "--picture", "with.png"];
    for arguments in [&with_textures[..], &["--picture", "alone.png"]] {
        let run = folder.quick(arguments);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    assert!(folder.read("with.png") == folder.read("alone.png"));
    for (name, size) in [("default.off", "256"), ("least.off", "8")] {
        let run = folder.run(&[
            "break",
            "--set",
            "rings=8",
            "-o",
            name,
            "--texture-size",
            size,
        ]);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    assert!(folder.read("default.off") == folder.read("least.off"));
}

#[test]
fn units_scale_and_parts_move() {
    let folder = Folder::new();
    assert_eq!(folder.quick(&["-o", "m.stl"]).code, 0);
    let volume = |unit: &str, part: &str| {
        let run = folder.quick(&[
            "m.stl", "--unit", unit, "--part", part, "--at", "0.15", "-o", "out.ply", "--json",
        ]);
        assert_eq!(run.code, 0, "{}", run.err);
        json(&run.out)["input"]["area_m2"].as_f64().unwrap()
    };
    let (metres, millimetres) = (volume("m", "0"), volume("mm", "3cm"));
    assert!(
        (millimetres / metres - 1e-6).abs() < 1e-9,
        "{metres} {millimetres}"
    );
}

#[test]
fn a_unit_leaves_no_scale_on_nodes() {
    let folder = Folder::new();
    assert_eq!(folder.quick(&["-o", "m.obj"]).code, 0);
    let run = folder.quick(&["m.obj", "--unit", "cm", "--at", "0.3", "-o", "out.gltf"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let document = json(&String::from_utf8(folder.read("out.gltf")).unwrap());
    for node in document["nodes"].as_array().unwrap() {
        assert!(
            node["scale"].is_null() && node["matrix"].is_null(),
            "{node}"
        );
    }
}

#[test]
fn scanned_and_modelled_wood_breaks() {
    for (name, at) in [("pole.ply", "0.4"), ("homecart_cutting_board.gltf", "0.5")] {
        let path = data(name);
        let folder = Folder::new();
        let run = folder.quick(&[
            path.to_str().unwrap(),
            "--at",
            at,
            "--json",
            "-o",
            "out.glb",
        ]);
        assert_eq!(run.code, 0, "{name}: {}", run.err);
        let report = json(&run.out);
        // The pole is in millimetres, which its format cannot say.
        assert_eq!(run.out.contains("--unit mm"), name.contains("pole"));
        if report["input"]["closed"] == true {
            assert_volumes_add_up(&report);
        }
        assert_eq!(folder.names(), ["out.glb"]);
    }
}

#[test]
fn the_recipe_in_the_guide_is_read_and_its_keys_exist() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/artists.md");
    let guide = fs::read_to_string(guide).unwrap();
    let (_, rest) = guide.split_once("```toml\n").unwrap();
    let (recipe, _) = rest.split_once("```").unwrap();
    let folder = Folder::new();
    folder.write("r.toml", recipe);
    let run = folder.quick(&["--recipe", "r.toml", "-o", "a.glb"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("Oak, white"), "{}", run.out);
    let (_, table) = guide.split_once("| to have | change |").unwrap();
    let (table, _) = table.split_once("\n\n").unwrap();
    let mut keys = 0;
    for key in table
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|k| !k.starts_with("--"))
    {
        let key = key.split('=').next().unwrap();
        assert_eq!(folder.run(&["parameters", key]).code, 0, "{key}");
        keys += 1;
    }
    assert!(keys > 8);
}

#[test]
fn variants_take_one_seed_after_the_other() {
    let folder = Folder::new();
    let run = folder.quick(&["--variants", "2", "--seed", "7", "-o", "v.ply"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{}", run.out);
    assert_eq!(folder.names(), ["v_1.ply", "v_2.ply"]);
    assert!(run.out.contains("the seed is 7") && run.out.contains("the seed is 8"));
    assert_ne!(folder.read("v_1.ply"), folder.read("v_2.ply"));
    assert_eq!(folder.quick(&["--seed", "8", "-o", "w.ply"]).code, 0);
    assert_eq!(folder.read("w.ply"), folder.read("v_2.ply"));
}

#[test]
fn a_seed_at_random_is_said_and_can_be_given_again() {
    let folder = Folder::new();
    let run = folder.quick(&["--seed", "random", "-o", "a.ply"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{}", run.out);
    let (_, said) = run.out.split_once("the seed is ").unwrap();
    let (seed, _) = said.split_once(", chosen at random").unwrap();
    assert_eq!(folder.quick(&["--seed", seed, "-o", "b.ply"]).code, 0);
    assert_eq!(folder.read("a.ply"), folder.read("b.ply"));
}

#[test]
fn colours_of_wood_are_given_as_hexadecimal_digits() {
    let folder = Folder::new();
    let run = folder.quick(&["--sapwood-color", "beige", "-o", "a.glb"]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("#d8ba90"), "{}", run.err);
    let plain = folder.quick(&["-o", "a.glb"]);
    let red = folder.quick(&["--set", "sapwood_color=#c04030", "-o", "b.glb"]);
    assert_eq!((plain.code, red.code), (0, 0), "{}", red.err);
    assert_ne!(folder.read("a.glb"), folder.read("b.glb"));
}
