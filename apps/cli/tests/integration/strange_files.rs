//! Files that were made to mislead: names that terminals obey, devices in place of files.

use crate::support::Folder;

/// A triangle as OBJ, in an object of this name with a material of that one.
fn named_triangle(name: &str, library: &str) -> String {
    format!("mtllib {library}\no {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
}

/// Whether a terminal would do something about it.
fn is_obeyed(text: &str) -> bool {
    text.chars().any(|c| c.is_control() && c != '\n')
}

#[test]
fn names_from_files_are_printed_escaped() {
    let folder = Folder::new();
    let title = "\u{1b}]0;owned\u{7}\u{1b}[31mbark\u{9b}2J";
    folder.write("named.obj", named_triangle(title, title));
    let run = folder.run(&["check", "named.obj"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(!is_obeyed(&run.out), "{:?}", run.out);
    assert!(run.out.contains("\\u{1b}[31mbark"), "{:?}", run.out);
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0, "name": "a\nerror: forged"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "a\n\u{1b}[31merror: forged.bin"}],
    });
    folder.write("companion.gltf", gltf.to_string());
    let run = folder.run(&["check", "companion.gltf"]);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(!is_obeyed(&run.err), "{:?}", run.err);
    let forged = |text: &str| text.lines().filter(|l| l.starts_with("error:")).count();
    assert_eq!(forged(&run.err), 1, "{}", run.err);
    let mut inside = gltf;
    inside["buffers"][0]["uri"] =
        format!("data:application/octet-stream,{}", "%00".repeat(36)).into();
    folder.write("inside.gltf", inside.to_string());
    let run = folder.run(&["check", "inside.gltf"]);
    assert_eq!(forged(&run.out), 0, "{}", run.out);
    assert!(run.out.contains("a\\nerror: forged"), "{}", run.out);
}

#[cfg(unix)]
#[test]
fn devices_and_unknown_endings_are_refused_at_once() {
    let folder = Folder::new();
    let started = std::time::Instant::now();
    let run = folder.run(&["check", "/dev/zero"]);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(run.err.contains("not a plain file"), "{}", run.err);
    let link = folder.0.join("zero.ply");
    std::os::unix::fs::symlink("/dev/zero", link).unwrap();
    for arguments in [
        &["check", "zero.ply"][..],
        &["break", "--recipe", "/dev/zero"],
        &["rings", "/dev/zero", "-o", "rings.json"],
        &["simulate", "/dev/zero.toml", "-o", "run"],
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.err);
        assert!(run.err.contains("cannot be read"), "{}", run.err);
    }
    // 3 GB that take no place.
    let large = std::fs::File::create(folder.0.join("large.xyzw")).unwrap();
    large.set_len(3 << 30).unwrap();
    let run = folder.run(&["check", "large.xyzw"]);
    assert!(run.err.contains("unknown ending"), "{}", run.err);
    std::fs::rename(folder.0.join("large.xyzw"), folder.0.join("large.toml")).unwrap();
    let run = folder.run(&["simulate", "large.toml", "-o", "run"]);
    assert!(
        run.err.contains("expected 134217728 at most"),
        "{}",
        run.err
    );
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

/// A scene whose body is this file.
fn scene_with_body(file: &str) -> String {
    format!("duration = 0.001\n[[body]]\nname = \"block\"\nshape = \"hull\"\nfile = \"{file}\"\n")
}

#[test]
fn scenes_name_plain_files_of_their_own_folder() {
    let folder = Folder::new();
    std::fs::create_dir(folder.0.join("scenes")).unwrap();
    folder.write("block.obj", named_triangle("block", "none.mtl"));
    let simulate = |file: &str, more: &[&str]| {
        folder.write("scenes/scene.toml", scene_with_body(file));
        let arguments = ["simulate", "scenes/scene.toml", "-o", "run"];
        let run = folder.run(&[&arguments[..], more].concat());
        assert_ne!(run.code, 0, "{file}");
        run.err
    };
    let error = simulate("/dev/zero", &[]);
    assert!(error.contains("relative"), "{error}");
    let error = simulate("../block.obj", &[]);
    assert!(
        error.contains("leaves the folder") && error.contains("--allow-outside"),
        "{error}"
    );
    // A triangle is no block, but it was read.
    let error = simulate("../block.obj", &["--allow-outside"]);
    assert!(!error.contains("leaves the folder"), "{error}");
}

#[cfg(unix)]
#[test]
fn outputs_go_through_links_and_into_no_pipe() {
    let folder = Folder::new();
    folder.write("real.ply", "old");
    std::os::unix::fs::symlink("real.ply", folder.0.join("link.ply")).unwrap();
    let run = folder.quick(&["-o", "link.ply"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(folder.0.join("link.ply").is_symlink());
    assert!(folder.read("real.ply").starts_with(b"ply"));
    let made = std::process::Command::new("mkfifo")
        .arg(folder.0.join("pipe.ply"))
        .status();
    assert!(made.unwrap().success());
    let run = folder.quick(&["-o", "pipe.ply"]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.err.contains("a device or a pipe"), "{}", run.err);
}

#[test]
fn no_output_replaces_a_texture_of_the_input() {
    let folder = Folder::new();
    assert_eq!(folder.quick(&["-o", "log.obj"]).code, 0);
    folder.write("bark.mtl", "newmtl bark\nmap_Kd bark.png\n");
    let log = String::from_utf8(folder.read("log.obj")).unwrap();
    let is_shape = |l: &&str| l.starts_with('v') || l.starts_with("f ");
    let plain: Vec<&str> = log.lines().filter(is_shape).collect();
    let text = format!("mtllib bark.mtl\nusemtl bark\n{}\n", plain.join("\n"));
    folder.write("plain.obj", text);
    folder.write("bark.png", "a picture");
    let run = folder.quick(&["plain.obj", "--picture", "bark.png", "-o", "out.glb"]);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(
        run.err.contains("bark.png") && run.err.contains("an input file"),
        "{}",
        run.err
    );
    assert_eq!(folder.read("bark.png"), b"a picture");
}

#[test]
fn a_run_that_never_began_begins_with_resume() {
    let folder = Folder::new();
    let begin = [
        "simulate",
        "oscillation",
        "--duration",
        "0.0001",
        "--no-pictures",
        "-o",
        "run",
        "--resume",
    ];
    let run = folder.run(&begin);
    assert_eq!(run.code, 0, "{}", run.err);
    // Another program holds it.
    let lock = std::fs::File::create(folder.0.join("run/run.lock")).unwrap();
    lock.lock().unwrap();
    let run = folder.run(&begin);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(
        run.err.contains("another program writes into it"),
        "{}",
        run.err
    );
    drop(lock);
    assert_eq!(folder.run(&begin).code, 0);
}

#[test]
fn a_polygon_that_passes_its_corners_twice_is_a_place_where_the_face_does_not_close() {
    let folder = Folder::new();
    let sound = include_str!("../../../../tests/data/kaykit_Tree_Bare_1_C_Color1.obj");
    let face = "152/177/104 374/178/105 354/167/101";
    assert!(sound.contains(face));
    let twice = sound.replacen(face, &format!("152/177/104 374/16 {face}"), 1);
    folder.write("twice.obj", twice);
    let run = folder.run(&["break", "twice.obj", "-o", "out.glb"]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.err.contains("not a manifold there"), "{}", run.err);
}

#[cfg(unix)]
#[test]
fn a_file_beyond_the_greatest_size_leaves_nothing_behind() {
    let folder = Folder::new();
    // In blocks of 512 or 1024 bytes, as the shell counts.
    let limited = "ulimit -f 16 && exec \"$@\"";
    let program = env!("CARGO_BIN_EXE_greenstick");
    let run = |arguments: &[&str]| {
        let run = std::process::Command::new("sh")
            .args(["-c", limited, "sh", program])
            .args(arguments)
            .current_dir(&folder.0)
            .output()
            .unwrap();
        (run.status.code(), String::from_utf8(run.stderr).unwrap())
    };
    folder.write("old.glb", "old");
    let (code, error) = run(&["break", "-o", "old.glb", "--texture-size", "64"]);
    assert_eq!(code, Some(1), "{error}");
    assert!(error.contains("ulimit -f"), "{error}");
    assert_eq!(folder.names(), ["old.glb"], "{error}");
    assert_eq!(folder.read("old.glb"), b"old");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_behind_stdout_is_a_failure() {
    let folder = Folder::new();
    folder.write("one.obj", named_triangle("one", "none.mtl"));
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_greenstick"))
        .args(["check", "one.obj"])
        .current_dir(&folder.0)
        .stdout(full.unwrap())
        .output()
        .unwrap();
    let error = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{error}");
    assert!(error.contains("cannot print to stdout"), "{error}");
}
