//! What is wrong is refused with one clear message, the right exit code, and no output left behind.

use crate::support::Folder;

/// Runs a break that must fail; returns its message after asserting that nothing was left behind.
fn refused(folder: &Folder, code: i32, arguments: &[&str]) -> String {
    let before = folder.names();
    let run = folder.quick(arguments);
    assert_eq!(run.code, code, "{arguments:?}: {}{}", run.out, run.err);
    assert_eq!(run.out, "", "{arguments:?}");
    assert_eq!(
        run.err.matches("error:").count(),
        1,
        "{arguments:?}: {}",
        run.err
    );
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert_eq!(
        folder.names(),
        before,
        "{arguments:?} left something behind"
    );
    run.err
}

fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in: {message}");
    }
}

#[test]
fn broken_files_are_refused_with_their_name_and_fault() {
    let ply = |vertices: &str, faces: &str, body: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n{body}"
        )
    };
    let cases: [(&str, Vec<u8>, &[&str]); 10] = [
        ("empty.glb", vec![], &["empty"]),
        (
            "cut.ply",
            ply("3", "1", "0 0 0\n1 0").into(),
            &["claims 3", "10 bytes"],
        ),
        (
            "nan.ply",
            ply("3", "1", "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n").into(),
            &["finite"],
        ),
        (
            "index.ply",
            ply("3", "1", "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").into(),
            &["7", "3"],
        ),
        (
            "claims.ply",
            ply("1000000000", "1", "0 0 0\n").into(),
            &["1000000000"],
        ),
        (
            "flat.ply",
            ply("3", "1", "0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n").into(),
            &["stem"],
        ),
        (
            "points.ply",
            ply("3", "0", "0 0 0\n1 0 0\n2 0 0\n").into(),
            &["3 of 3 points", "at least 50"],
        ),
        ("no.stl", b"this is a letter to my aunt".to_vec(), &["STL"]),
        ("no.obj", b"hello\nworld\n".to_vec(), &[]),
        ("no.gltf", b"{ \"asset\": ".to_vec(), &[]),
    ];
    let folder = Folder::new();
    for (name, bytes, parts) in cases {
        folder.write(name, bytes);
        // Faces without area are a sound file in which no stem is found: there the work fails.
        let code = if name == "flat.ply" { 1 } else { 2 };
        let message = refused(&folder, code, &[name]);
        assert_says(&message, parts);
        if code == 2 {
            assert_says(&message, &[name]);
        }
    }
    let names = folder.names();
    let missing = refused(&folder, 2, &["emty.glb"]);
    assert_says(&missing, &["emty.glb", "there is a file empty.glb"]);
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"gone.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}]}"#;
    folder.write("alone.gltf", gltf);
    assert_says(
        &refused(&folder, 2, &["alone.gltf"]),
        &["alone.gltf", "gone.bin"],
    );
    assert_eq!(folder.names().len(), names.len() + 1);
    std::fs::create_dir(folder.0.join("folder.glb")).unwrap();
    assert_says(
        &refused(&folder, 2, &["folder.glb"]),
        &["folder.glb", "folder"],
    );
}

#[test]
fn wrong_options_are_refused_with_what_would_be_right() {
    let folder = Folder::new();
    let cases: [(&[&str], &[&str]); 18] = [
        (&["--preset", "fig2"], &["fig2b", "greenstick presets"]),
        (
            &["--preset", "splintring-tension"],
            &["splintering-tension"],
        ),
        (&["--species", "whit oak"], &["--species", "Oak, white"]),
        (&["--moisture", "500"], &["--moisture", "200"]),
        (&["--seed", "-1"], &["--seed", "whole number"]),
        (&["--set", "hihg.height=1"], &["--set", "high.height"]),
        (
            &["--set", "high.height=1000"],
            &["high.height", "1000", "0 to 20"],
        ),
        (&["--set", "rings"], &["key=value"]),
        (&["--at", "1.5"], &["--at", "1.5", "0 to 1"]),
        (&["--at", "9m"], &["off the stem", "--at"]),
        (&["--at", "5,5,5"], &["nearest", "--at"]),
        (&["--at", "there"], &["there", "12cm"]),
        (&["--pith", "1"], &["--pith", "x,y"]),
        (&["--part", "3"], &["--part", "3cm"]),
        (&["--fray", "2"], &["--fray", "0 to 1"]),
        (&["--kind", "bord"], &["board"]),
        (&["--threads", "0"], &["--threads", "1"]),
        (&["--texture-size", "7"], &["--texture-size", "even"]),
    ];
    for (arguments, parts) in cases {
        // Without QUICK, because an option may be given once only.
        let run = folder.run(&[&["break"], arguments].concat());
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.err);
        assert_says(&run.err, parts);
        assert!(
            folder.names().is_empty(),
            "{arguments:?}: {:?}",
            folder.names()
        );
    }
    folder.write("r.toml", "[break]\nrings = 20\nsectors = 1\n");
    let message = refused(&folder, 2, &["--recipe", "r.toml"]);
    assert_says(&message, &["r.toml", "line 3", "sectors"]);
    assert_says(
        &refused(&folder, 2, &["--recipe", "none.toml"]),
        &["none.toml"],
    );
}

#[test]
fn a_place_that_cannot_be_written_is_reported_before_the_work_and_leaves_nothing() {
    let folder = Folder::new();
    folder.write("file", "x");
    let message = refused(&folder, 1, &["-o", "file/broken.glb"]);
    assert_says(&message, &["file/broken.glb", "hint"]);
    let message = refused(&folder, 1, &["-o", "good.glb", "--picture", "none/bad.png"]);
    assert_says(&message, &["none/bad.png"]);
    std::fs::create_dir(folder.0.join("taken.glb")).unwrap();
    assert_says(&refused(&folder, 1, &["-o", "taken.glb"]), &["taken.glb"]);
    assert_says(&refused(&folder, 2, &["-o", "broken.xyz"]), &[".glb"]);
    assert_says(
        &refused(&folder, 2, &["--picture", "broken.jpg"]),
        &[".png"],
    );
}

#[test]
fn no_input_is_overwritten() {
    let folder = Folder::new();
    assert_eq!(folder.quick(&["-o", "a.gltf"]).code, 0);
    let names = folder.names();
    let before: Vec<Vec<u8>> = names.iter().map(|n| folder.read(n)).collect();
    for other in ["a.gltf", "./a.gltf"] {
        let message = refused(&folder, 2, &["a.gltf", "-o", other, "--at", "0.3"]);
        assert_says(&message, &["an input file"]);
    }
    assert!(names.iter().map(|n| folder.read(n)).eq(before));
}

#[test]
fn checks_and_lists_answer_and_refuse() {
    let folder = Folder::new();
    folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let run = folder.run(&["check", "open.obj"]);
    assert_eq!(run.code, 0);
    assert_says(&run.out, &["not a sound solid", "3 boundary edges"]);
    assert_eq!(folder.run(&["check", "--strict", "open.obj"]).code, 1);
    assert_eq!(folder.run(&["check", "none.obj"]).code, 2);
    let run = folder.run(&["picture", "open.obj", "--size", "32x24", "-o", "p.png"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(folder.read("p.png").starts_with(b"\x89PNG"));
    let run = folder.run(&["picture", "open.obj", "--close-up", "3"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["does not say where it is broken"]);
    for (arguments, part) in [
        (&["parameters", "high"][..], "high.height"),
        (&["parameters", "--schema"], "json-schema.org"),
        (&["presets"], "splintering-tension"),
        (&["presets", "twist"], "[break]"),
        (&["species"], "Quercus alba"),
        (&["species", "white oak"], "modulus of rupture"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.err);
        assert_says(&run.out, &[part]);
    }
    for arguments in [
        &["parameters", "--json"][..],
        &["presets", "--json"],
        &["species", "--json"],
    ] {
        let text = folder.run(arguments).out;
        let list: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
        assert!(list.len() > 3, "{arguments:?}");
    }
    for (arguments, part) in [
        (&["parameters", "sapwod"][..], "sapwood"),
        (&["presets", "brsh"], "brash"),
        (&["species", "sitka spurce"], "Spruce, Sitka"),
        (&["brake"], "break"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, 2, "{arguments:?}");
        assert_says(&run.err, &[part]);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_the_work_and_leaves_nothing() {
    let folder = Folder::new();
    // The picture alone takes minutes.
    let run = folder.interrupted(&["break", "--samples", "400", "--picture-size", "600x900"]);
    assert_eq!(run.code, 130);
    assert_eq!(run.err, "stopped; nothing was written\n");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}
