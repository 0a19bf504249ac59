//! `greenstick skin`: films and frames of a run that breaks, and what is refused.

use crate::support::Folder;
use serde_json::Value;
use std::fs;

/// A stick whose end is pressed down until it breaks; a blink.
const SCENE: &str = "duration = 0.012\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nname = \"press\"\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n";

const SMALL: [&str; 3] = ["--texture-size", "64", "--json"];

fn simulated() -> Folder {
    let folder = Folder::new();
    fs::write(folder.0.join("small.toml"), SCENE).unwrap();
    let run = folder.run(&["simulate", "small.toml", "-o", "run", "--no-pictures"]);
    assert_eq!(run.code, 0, "{}", run.err);
    folder
}

fn report(folder: &Folder, arguments: &[&str]) -> Value {
    let run = folder.run(&[&["skin", "run"], &SMALL[..], arguments].concat());
    assert_eq!(run.code, 0, "{}", run.err);
    serde_json::from_str(&run.out).unwrap()
}

/// The JSON of a GLB.
fn glb(bytes: &[u8]) -> Value {
    assert!(bytes.starts_with(b"glTF"));
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn a_run_becomes_a_film_in_every_format_and_the_same_bytes_with_one_thread() {
    let folder = simulated();
    for (faces, first, second) in [
        ("drawn", "lower", "upper"),
        ("rods", "piece_000", "piece_001"),
    ] {
        film_in_every_format(&folder, faces, [first, second]);
    }
}

/// Makes films with faces of a kind, whose first two pieces have these names.
fn film_in_every_format(folder: &Folder, faces: &str, names: [&str; 2]) {
    let report = |arguments: &[&str]| report(folder, &[&["--faces", faces], arguments].concat());
    let told = report(&["-o", "film.glb"]);
    assert_eq!(told["frames"], 4);
    let pieces = told["pieces"].as_array().unwrap();
    assert!(pieces.len() > 1, "nothing parted: {told}");
    let first = folder.read("film.glb");
    let json = glb(&first);
    assert_eq!(json["animations"].as_array().unwrap().len(), 1);
    assert_eq!(
        json["skins"].as_array().map(Vec::len),
        told["film"]["skinned"].as_u64().map(|n| n as usize)
    );
    let named = |name: &str| {
        json["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .any(|n| n["name"] == name)
    };
    assert!(names.iter().all(|name| named(name)) && named("press"));
    // What is parted was one before, and its extras say when it went.
    let parted = pieces[1]["parted"].as_array().unwrap();
    assert!(
        parted[0].as_f64().unwrap() <= 0.012 && parted[1] == names[0],
        "{told}"
    );
    report(&["-o", "film.glb", "--threads", "1"]);
    assert_eq!(first, folder.read("film.glb"));
    report(&["-o", "film.usdc"]);
    assert!(folder.read("film.usdc").starts_with(b"PXR-USDC"));
    report(&["-o", "film.pvd", "--frames", "1..3"]);
    let list = String::from_utf8(folder.read("film.pvd")).unwrap();
    assert_eq!(list.matches("<DataSet").count(), 4);
    assert!(folder.read("film_00002_bonds.vtp").starts_with(b"<?xml"));
}

#[test]
fn a_frame_is_closed_pieces_and_simulating_into_a_film_does_both() {
    let folder = simulated();
    for faces in ["drawn", "rods"] {
        let arguments = ["-o", "last.glb", "--frame", "-1", "--faces", faces];
        let told = report(&folder, &arguments);
        let checked = folder.run(&["check", "last.glb", "--json", "--fast"]);
        let checked: Value = serde_json::from_str(&checked.out).unwrap();
        let mut meshes = 0;
        for mesh in checked[0]["meshes"].as_array().unwrap() {
            assert!(mesh["closed"] == true && mesh["oriented"] == true, "{mesh}");
            // Strands of torn fibre are no pieces.
            let is_detail = mesh["name"].as_str().unwrap().ends_with("_fuzz");
            meshes += usize::from(!is_detail);
        }
        assert_eq!(meshes, told["pieces"].as_array().unwrap().len() + 1);
    }
    let run = folder.run(&[
        "simulate",
        "small.toml",
        "-o",
        "both.glb",
        "--no-pictures",
        "-q",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(folder.0.join("both.run/frames.gsf").is_file());
    assert_eq!(
        glb(&folder.read("both.glb"))["animations"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    // The rods of frames in which nothing breaks are one piece; so they are shown by an option of their skin alone.
    for rods in [&["--faces", "rods"][..], &["--fibres", "2"][..]] {
        let arguments = [&["-o", "first.glb", "--frames", "0..1"], rods].concat();
        let told = report(&folder, &arguments);
        assert_eq!(told["pieces"].as_array().unwrap().len(), 1);
    }
    let refused = folder.run(&[
        "skin", "run", "-o", "a.glb", "--faces", "drawn", "--slabs", "1",
    ]);
    assert!(
        refused.code == 2 && refused.err.contains("--slabs"),
        "{}",
        refused.err
    );
}

#[test]
fn stills_hold_the_fields_that_they_show_and_pictures_come_near() {
    let folder = simulated();
    let meshes = |file: &str| glb(&folder.read(file))["meshes"].clone();
    for faces in ["drawn", "rods"] {
        for (field, attribute) in [("strain", "_STRAIN"), ("damage", "_DAMAGE")] {
            let arguments = ["--faces", faces, "--frame", "-1", "--show", field];
            report(&folder, &[&arguments[..], &["-o", "still.glb"]].concat());
            let made = meshes("still.glb").to_string();
            assert!(made.contains(attribute), "{faces}: no {attribute}");
        }
    }
    let picture = |name: &str, arguments: &[&str]| {
        let small = [
            "--picture-size",
            "48x36",
            "--samples",
            "1",
            "--picture",
            name,
        ];
        report(
            &folder,
            &[&["--frame", "-1"], arguments, &small[..]].concat(),
        );
        folder.read(name)
    };
    let whole = picture("whole.png", &[]);
    assert_ne!(picture("near.png", &["--close-up", "3"]), whole);
    assert_ne!(picture("strain.png", &["--show", "strain"]), whole);
}

#[test]
fn engines_get_shapes_levels_and_vertex_textures() {
    let folder = simulated();
    let told = report(
        &folder,
        &[
            "-o",
            "film.glb",
            "--collision",
            "shapes.glb",
            "--lod",
            "0.5",
            "--vat",
            "moves.png",
        ],
    );
    let checked = folder.run(&["check", "shapes.glb", "--json"]);
    let checked: Value = serde_json::from_str(&checked.out).unwrap();
    let shapes = checked[0]["meshes"].as_array().unwrap();
    for shape in shapes {
        assert!(shape["solid"] == true, "{shape}");
        assert!(
            ["UCX_lower_", "UCX_upper_"]
                .iter()
                .any(|start| shape["name"].as_str().unwrap().starts_with(start)),
            "{shape}"
        );
    }
    let pieces = told["pieces"].as_array().unwrap().len();
    assert!(
        shapes.len() >= pieces,
        "{} shapes of {pieces} pieces",
        shapes.len()
    );
    let levels = told["levels"].as_array().unwrap();
    let [before, after] = [0, 1].map(|k| levels[0]["triangles"][k].as_u64().unwrap());
    // A collapse takes two triangles, so that a piece may end one below half of its own.
    let least = before / 2 - pieces as u64;
    assert!(after < before && after >= least, "{told}");
    assert_eq!(
        glb(&folder.read("film_lod1.glb"))["animations"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    for file in ["moves.png", "moves.normals.png", "moves.json", "moves.glb"] {
        assert!(!folder.read(file).is_empty(), "{file}");
    }
    let refused = folder.run(&["skin", "run", "-o", "film.usdc", "--lod", "0.5"]);
    assert!(
        refused.code == 2 && refused.err.contains("levels of detail"),
        "{}",
        refused.err
    );
}

#[test]
fn what_is_cut_short_is_told_and_what_is_wrong_is_refused() {
    let folder = simulated();
    let path = folder.0.join("run/frames.gsf");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    let told = report(&folder, &["-o", "film.glb"]);
    assert_eq!(told["frames"], 3);
    assert!(told["bytes_left"].as_u64().unwrap() > 1000, "{told}");
    let whole = folder.run(&["skin", "run", "-o", "film.glb", "--texture-size", "64"]);
    assert!(whole.out.contains("cut short"), "{}", whole.out);
    let wrong: [(&[&str], &str); 7] = [
        (&["skin", "run"], "no file is named"),
        (&["skin", "nowhere", "-o", "a.glb"], "holds no simulation"),
        (
            &["skin", "run", "-o", "a.glb", "--frame", "99"],
            "no frame 99",
        ),
        (
            &["skin", "run", "-o", "a.glb", "--frames", "2..9"],
            "no frame 8",
        ),
        (&["skin", "run", "-o", "a.obj"], "a film is written as"),
        (&["skin", "run", "-o", "a.glb", "--fibres", "0"], "--fibres"),
        (&["skin", "run", "-o", "there/a.glb"], "no folder there"),
    ];
    for (arguments, says) in wrong {
        let run = folder.run(arguments);
        assert!(
            run.code == 2 || run.code == 1,
            "{arguments:?}: {}",
            run.code
        );
        assert!(run.err.contains(says), "{arguments:?}: {}", run.err);
        assert!(!folder.0.join("a.glb").exists());
    }
    // Frames of another scene's wood.
    let scene = fs::read_to_string(folder.0.join("run/scene.toml")).unwrap();
    fs::write(
        folder.0.join("run/scene.toml"),
        scene.replace("number = 12", "number = 9"),
    )
    .unwrap();
    let run = folder.run(&["skin", "run", "-o", "a.glb"]);
    assert!(
        run.code == 2 && run.err.contains("not of this scene's wood"),
        "{}",
        run.err
    );
    fs::write(&path, b"GSFRAMES").unwrap();
    let run = folder.run(&["skin", "run", "-o", "a.glb"]);
    assert!(
        run.code == 2 && run.err.contains("frames.gsf"),
        "{}",
        run.err
    );
}

#[test]
fn a_film_whose_companions_cannot_be_written_is_not_written() {
    let folder = simulated();
    let shapes = ["-o", "film.glb", "--collision", "none/shapes.glb"];
    let run = folder.run(&[&["skin", "run"], &SMALL[..], &shapes].concat());
    assert_eq!(run.code, 1, "{}{}", run.out, run.err);
    assert!(run.err.contains("none"), "{}", run.err);
    let left = fs::read_dir(&folder.0)
        .unwrap()
        .map(|e| e.unwrap().file_name());
    let mut left: Vec<_> = left.map(|n| n.to_string_lossy().into_owned()).collect();
    left.sort();
    assert_eq!(left, ["run", "small.toml"]);
}
