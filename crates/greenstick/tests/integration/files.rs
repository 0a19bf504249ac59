//! Files: all of an output or none of it, and meshes with their companions.

use greenstick::ErrorKind;
use greenstick::files::{
    Batch, Output, carry_images, check_distinct, encode, load, read, write_all,
};
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Image, ImageSource, Scene};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// An empty folder that is removed with its content in the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path =
            std::env::temp_dir().join(format!("greenstick-files-{}-{n}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn output(&self, name: &str, text: &str) -> Output {
        Output {
            path: self.0.join(name),
            bytes: text.into(),
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

#[test]
fn all_files_are_written_or_none() {
    let folder = Folder::new();
    fs::write(folder.0.join("b"), "old").unwrap();
    fs::create_dir(folder.0.join("folder")).unwrap();
    let outputs = ["a", "b", "folder"].map(|name| folder.output(name, "new"));
    let error = write_all(&outputs).unwrap_err();
    assert!(error.to_string().contains("folder"), "{error}");
    assert_eq!(folder.names(), ["b", "folder"]);
    assert_eq!(fs::read(folder.0.join("b")).unwrap(), b"old");
    write_all(&outputs[..2]).unwrap();
    assert_eq!(folder.names(), ["a", "b", "folder"]);
    assert_eq!(fs::read(folder.0.join("b")).unwrap(), b"new");
}

#[test]
fn a_name_that_cannot_be_taken_puts_the_others_back() {
    let folder = Folder::new();
    fs::write(folder.0.join("b"), "old").unwrap();
    let mut batch = Batch::default();
    for name in ["a", "b", "c"] {
        batch.add(&folder.output(name, "new")).unwrap();
    }
    // While the others were written, somebody took the name of the one that is renamed last.
    fs::create_dir_all(folder.0.join("a").join("taken")).unwrap();
    assert!(batch.finish().is_err());
    assert_eq!(folder.names(), ["a", "b"]);
    assert_eq!(fs::read(folder.0.join("b")).unwrap(), b"old");
}

#[test]
fn no_output_replaces_an_input_or_another_output() {
    let folder = Folder::new();
    fs::write(folder.0.join("in.obj"), "x").unwrap();
    let inputs = [folder.0.join("in.obj")];
    let other_way = folder.0.join(".").join("in.obj");
    let error = check_distinct(&[&other_way], &inputs).unwrap_err();
    assert!(error.to_string().contains("an input file"), "{error}");
    let new = folder.0.join("out.glb");
    assert!(check_distinct(&[&new, &new], &inputs).is_err());
    assert!(check_distinct(&[&new], &inputs).is_ok());
}

#[test]
fn companions_are_followed_by_relative_reference_only() {
    let folder = Folder::new();
    for name in ["meshes", "out"] {
        fs::create_dir(folder.0.join(name)).unwrap();
    }
    let png = b"\x89PNG\r\n\x1a\n";
    fs::write(folder.0.join("bark.png"), png).unwrap();
    let source = folder.0.join("meshes").join("tree.obj");
    let target = folder.0.join("out").join("tree.obj");
    let is_read = |reference: &str| {
        let image = Image {
            name: String::new(),
            mime_type: String::new(),
            source: ImageSource::Reference(reference.to_owned()),
        };
        let mut scene = Scene {
            images: vec![image],
            ..Scene::default()
        };
        carry_images(&mut scene, &source, &target);
        let is_read = matches!(&scene.images[0].source, ImageSource::Bytes(bytes) if bytes == png);
        assert_eq!(is_read, scene.notes.is_empty());
        is_read
    };
    assert!(is_read("../bark.png"));
    assert!(is_read("..\\bark.png"));
    let absolute = folder.0.join("bark.png").to_string_lossy().into_owned();
    for refused in [&absolute, "file:///bark.png", "C:/bark.png", "..", "."] {
        assert!(!is_read(refused), "{refused}");
    }
}

#[test]
fn a_mesh_and_its_companions_are_read_and_written() {
    let folder = Folder::new();
    let text = "mtllib t.mtl\nusemtl bark\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.0.join("t.obj"), text).unwrap();
    fs::write(folder.0.join("t.mtl"), "newmtl bark\nKd 0.5 0.25 0.125\n").unwrap();
    let source = load(&folder.0.join("t.obj"), Some(LengthUnit::Centimetre)).unwrap();
    assert_eq!(source.files.len(), 2);
    let out = folder.0.join("out.gltf");
    let files = encode(&source.scene, &out, LengthUnit::Metre).unwrap();
    write_all(&files).unwrap();
    let again = read(&out, None).unwrap();
    let far = again.nodes[0]
        .transform
        .transform_point3(again.nodes[0].mesh.positions[1]);
    assert!((far.length() - 0.01).abs() < 1e-9, "{far}");
    assert_eq!(again.materials[0].name, "bark");
    let unknown = encode(&source.scene, &folder.0.join("out.xyz"), LengthUnit::Metre);
    assert!(
        unknown
            .unwrap_err()
            .to_string()
            .contains(".glb, .gltf, .obj")
    );
    let missing = read(&folder.0.join("none.ply"), None).unwrap_err();
    assert!(missing.to_string().contains("none.ply") && missing.kind() == ErrorKind::Request);
}

#[cfg(unix)]
#[test]
fn a_link_to_nothing_is_written_through() {
    let folder = Folder::new();
    fs::create_dir_all(folder.0.join("far")).unwrap();
    let [link, second, file] = ["link", "second", "far/file"].map(|name| folder.0.join(name));
    std::os::unix::fs::symlink("second", &link).unwrap();
    std::os::unix::fs::symlink("far/file", &second).unwrap();
    let output = Output {
        path: link.clone(),
        bytes: b"new".to_vec(),
    };
    write_all(&[output]).unwrap();
    assert!(link.is_symlink() && second.is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
}
