//! Forests: instances stay instances, broken trees keep their volume and their place, threads change nothing, one tree that
//! cannot be broken stays whole.

use glam::{DAffine3, DQuat, DVec3};
use greenstick::files;
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Material, Mesh, Node, Scene};
use greenstick_sweep::{Run, Sweep};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Corners of a stem's section.
const SIDES: usize = 14;
/// Height of a stem, m.
const HEIGHT: f64 = 4.0;
/// The tree that is a ball, which has no stem.
const BALL: usize = 5;
const TREES: usize = 12;

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("greenstick-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A closed body of revolution about y, of radii at equal distances.
fn turned(height: f64, radii: &[f64], material: u32) -> Arc<Mesh> {
    let mut mesh = Mesh::default();
    let last = radii.len() - 1;
    for (k, radius) in radii.iter().enumerate() {
        let y = height * k as f64 / last as f64;
        mesh.positions.extend((0..SIDES).map(|side| {
            let angle = TAU * side as f64 / SIDES as f64;
            DVec3::new(radius * angle.cos(), y, -radius * angle.sin())
        }));
    }
    let ends = mesh.positions.len() as u32;
    mesh.positions.extend([DVec3::ZERO, DVec3::Y * height]);
    let at = |k: usize, side: usize| (k * SIDES + side % SIDES) as u32;
    for side in 0..SIDES {
        for k in 0..last {
            let [a, b] = [at(k, side), at(k, side + 1)];
            let [c, d] = [at(k + 1, side), at(k + 1, side + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
        mesh.triangles.push([ends, at(0, side + 1), at(0, side)]);
        mesh.triangles
            .push([ends + 1, at(last, side), at(last, side + 1)]);
    }
    mesh.materials = vec![material; mesh.triangles.len()];
    mesh.into()
}

fn stem(base: f64, top: f64) -> Arc<Mesh> {
    let radii: Vec<f64> = (0..9)
        .map(|k| base + (top - base) * f64::from(k) / 8.0)
        .collect();
    turned(HEIGHT, &radii, 0)
}

fn place(tree: usize) -> DAffine3 {
    let k = tree as f64;
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.8 + 0.04 * k),
        DQuat::from_rotation_y(k),
        DVec3::new(200.0 + 3.0 * k, 0.5 * k, -k * k),
    )
}

fn name(tree: usize) -> String {
    format!("Tree_{tree:03}")
}

/// Twelve trees of two meshes on a plate, one of them a ball, one with a lamp; a stump that is none of them.
fn forest() -> Scene {
    let meshes = [stem(0.16, 0.06), stem(0.12, 0.08)];
    let ball = turned(1.0, &[0.1, 0.4, 0.5, 0.4, 0.1], 0);
    let plate = turned(0.1, &[300.0, 300.0], 1);
    let mut nodes = vec![Node::new("Ground", DAffine3::IDENTITY, plate)];
    for tree in 0..TREES {
        let mesh = if tree == BALL {
            &ball
        } else {
            &meshes[tree % 2]
        };
        let mut node = Node::new(name(tree), place(tree), mesh.clone());
        node.parent = Some(0);
        nodes.push(node);
    }
    let mut lamp = Node::new(
        "Tree_lamp",
        place(7) * DAffine3::from_translation(DVec3::new(0.4, 1.0, 0.0)),
        turned(0.2, &[0.05, 0.05], 1),
    );
    lamp.parent = Some(8);
    nodes.push(lamp);
    nodes.push(Node::new("Stump", DAffine3::IDENTITY, meshes[0].clone()));
    let material = |name: &str, red: f32| Material {
        name: name.to_owned(),
        base_color: [red, 0.3, 0.2, 1.0],
        ..Material::default()
    };
    Scene {
        nodes,
        materials: vec![material("bark", 0.4), material("stone", 0.3)],
        ..Scene::default()
    }
}

fn write_forest(folder: &Path) {
    let outputs = files::encode(&forest(), &folder.join("forest.glb"), LengthUnit::Metre).unwrap();
    files::write_all(&outputs).unwrap();
}

fn sweep(folder: &Path, more: &str) -> Sweep {
    let text = format!(
        "[sweep]\nkind = 'forest'\ninput = 'forest.glb'\ntextures = false\nsheet = 0\n{more}\n[break]\nrings = 6\nsectors = 12\n\
         [vary]\nmoisture = {{ between = [8, 30] }}\nat = [0.3, 0.4, 0.5]\n"
    );
    Sweep::read(&text, folder).unwrap_or_else(|e| panic!("{e}"))
}

/// Makes a sweep; returns the path of its scene.
fn run(sweep: &Sweep, folder: &Path, threads: usize) -> PathBuf {
    let run = Run {
        sweep,
        folder,
        part: None,
        threads,
        alone: &|call| call(),
    };
    let mut journal = run.journal().unwrap();
    run.make(&mut journal, &Context::quiet()).unwrap();
    let overview = run.overview(&journal, &Context::quiet()).unwrap();
    overview.scene.unwrap()
}

/// The JSON of a GLB, read by hand (§4.4).
fn document(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap();
    assert!(bytes.starts_with(b"glTF"));
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// The lines of a journal, by variant.
fn records(folder: &Path) -> BTreeMap<u64, Value> {
    let text = fs::read_to_string(folder.join("journal.jsonl")).unwrap();
    let lines = text.lines().skip(1);
    let records = lines.map(|line| serde_json::from_str::<Value>(line).unwrap());
    records
        .map(|record| (record["variant"].as_u64().unwrap(), record))
        .collect()
}

/// Asserts that the halves of broken trees have their volume, and stand and reach where these did.
fn assert_volumes_and_places(after: &Scene, broken: &[usize]) {
    let before = forest();
    for &tree in broken {
        let original = before.nodes.iter().find(|n| n.name == name(tree)).unwrap();
        let expected = original.mesh.transformed(&original.transform).volume();
        let halves = ["lower", "upper"].map(|half| {
            let wanted = format!("{}_{half}", name(tree));
            let node = after.nodes.iter().find(|n| n.name == wanted).unwrap();
            node.mesh.transformed(&node.transform)
        });
        let sum: f64 = halves.iter().map(Mesh::volume).sum();
        assert!(
            (sum / expected - 1.0).abs() < 1e-4,
            "{}: {sum} {expected}",
            name(tree)
        );
        // The foot stands where the tree stood, the top reaches as high.
        let (low, _) = halves[0].bounds().unwrap();
        let (_, high) = halves[1].bounds().unwrap();
        let foot = original.transform.translation;
        let top = original.transform.transform_point3(DVec3::Y * HEIGHT);
        assert!((low.y - foot.y).abs() < 1e-4 && (high.y - top.y).abs() < 1e-4);
        assert!((low.x - foot.x).abs() < 0.3 && (low.z - foot.z).abs() < 0.3);
    }
}

#[test]
fn whole_trees_stay_instances_and_broken_ones_keep_their_volume_and_their_place() {
    let folder = Folder::new("forest");
    write_forest(&folder.0);
    let sweep = sweep(&folder.0, "share = 0.6");
    let breaking: BTreeSet<usize> = (0..TREES)
        .filter(|&tree| sweep.forest().unwrap().trees()[tree].breaks)
        .collect();
    // The lamp is part of its tree, and 0.6 · 12 is nearest to 7.
    assert_eq!((sweep.count(), breaking.len()), (TREES as u64, 7));
    let mut pictures = sweep.clone();
    pictures.settings.sheet = 24;
    let shown = pictures.shown().into_iter().map(|n| n as usize);
    assert_eq!(shown.collect::<BTreeSet<_>>(), breaking);
    pictures.settings.sheet = 3;
    assert_eq!(pictures.shown().len(), 3);
    let out = folder.0.join("out");
    let path = run(&sweep, &out, 2);

    let json = document(&path);
    let nodes = json["nodes"].as_array().unwrap();
    let named =
        |wanted: &str| -> Vec<&Value> { nodes.iter().filter(|n| n["name"] == wanted).collect() };
    let whole: Vec<usize> = (0..TREES)
        .filter(|tree| !breaking.contains(tree) || *tree == BALL)
        .collect();
    let mut meshes: [BTreeSet<u64>; 2] = Default::default();
    for tree in 0..TREES {
        let found = named(&name(tree));
        assert_eq!(
            found.len(),
            usize::from(whole.contains(&tree)),
            "{}",
            name(tree)
        );
        if let ([node], false) = (&found[..], tree == BALL) {
            meshes[tree % 2].insert(node["mesh"].as_u64().unwrap());
        }
    }
    // All of one mesh, which the stump shares.
    assert!(
        meshes.iter().all(|of_kind| of_kind.len() == 1),
        "{meshes:?}"
    );
    assert_eq!(
        named("Stump")[0]["mesh"].as_u64(),
        meshes[0].first().copied()
    );
    assert_eq!(named("Tree_lamp").len(), 1);
    let broken: Vec<usize> = breaking.iter().copied().filter(|t| *t != BALL).collect();
    // Two stems, plate, lamp, and the ball; of each broken tree its two pieces and their strands.
    let pieces = nodes.iter().filter(|n| {
        let name = n["name"].as_str().unwrap();
        broken
            .iter()
            .any(|&tree| name.starts_with(&format!("{}_", self::name(tree))))
    });
    let of_pieces: BTreeSet<u64> = pieces.map(|n| n["mesh"].as_u64().unwrap()).collect();
    assert!(of_pieces.len() >= 2 * broken.len());
    assert_eq!(
        json["meshes"].as_array().unwrap().len(),
        5 + of_pieces.len()
    );
    // One bark for all, and what is inside each.
    let barks = json["materials"].as_array().unwrap().iter();
    assert_eq!(barks.filter(|m| m["name"] == "bark").count(), 1);

    assert_volumes_and_places(&files::read(&path, None).unwrap(), &broken);
    // Trees of one mesh break differently.
    let faces: BTreeSet<String> = records(&out)
        .values()
        .filter(|r| r.get("figures").is_some())
        .map(|r| r["figures"]["range_m"].to_string())
        .collect();
    assert_eq!(faces.len(), broken.len());
}

#[test]
fn a_tree_that_cannot_be_broken_is_a_row_and_stays() {
    let folder = Folder::new("forest-ball");
    write_forest(&folder.0);
    let sweep = sweep(&folder.0, "only = 'Tree_005, Tree_0?8'");
    let out = folder.0.join("out");
    let path = run(&sweep, &out, 1);
    let records = records(&out);
    assert_eq!(records.len(), TREES);
    let error = records[&(BALL as u64)]["error"].as_str().unwrap();
    assert!(error.contains("stem"), "{error}");
    let broken = records.values().filter(|r| r.get("figures").is_some());
    assert_eq!(
        broken
            .map(|r| r["variant"].as_u64().unwrap())
            .collect::<Vec<_>>(),
        [8]
    );
    let json = document(&path);
    let names = json["nodes"].as_array().unwrap().iter();
    assert_eq!(
        names.filter(|n| n["name"] == name(BALL).as_str()).count(),
        1
    );
}

#[test]
fn any_number_of_threads_and_a_second_start_make_the_same_bytes() {
    let folder = Folder::new("forest-threads");
    write_forest(&folder.0);
    let sweep = sweep(&folder.0, "share = 0.3\nseed = 4");
    let one = fs::read(run(&sweep, &folder.0.join("one"), 1)).unwrap();
    let two = folder.0.join("two");
    assert!(one == fs::read(run(&sweep, &two, 2)).unwrap());
    // Half of the journal is lost; what it had is made again.
    let journal = two.join("journal.jsonl");
    let text = fs::read_to_string(&journal).unwrap();
    let half: Vec<&str> = text.lines().take(TREES / 2).collect();
    fs::write(&journal, half.join("\n") + "\n").unwrap();
    assert!(one == fs::read(run(&sweep, &two, 2)).unwrap());
}

#[test]
fn what_is_wrong_with_a_forest_is_said() {
    let folder = Folder::new("forest-wrong");
    write_forest(&folder.0);
    for (text, message) in [
        (
            "kind = 'forest'",
            "expected input = \"forest.glb\" in [sweep]",
        ),
        (
            "kind = 'forest'\ninput = 'forest.glb'\nnodes = 'Oak_*'",
            "has a name like \"Oak_*\", the first are \"Ground\", \"Tree_000\"",
        ),
        (
            "kind = 'forest'\ninput = 'forest.glb'\nonly = 'Oak_1'",
            "none of its 12 trees has a name like \"Oak_1\"",
        ),
        (
            "nodes = 'Tree_*'",
            "nodes belongs to forests, but kind is \"break\"",
        ),
        (
            "kind = 'forest'\ninput = 'forest.glb'\nfile = 'stl'",
            "keeps no instances",
        ),
        (
            "kind = 'forest'\ninput = 'forest.glb'\nsamples = 4",
            "every tree of a forest is a sample",
        ),
        (
            "kind = 'forest'\ninput = 'forest.glb'\nshare = 2",
            "share is 2",
        ),
    ] {
        let text = format!("[sweep]\n{text}\n");
        let error = Sweep::read(&text, &folder.0).unwrap_err().to_string();
        assert!(error.contains(message), "{message}: {error}");
    }
    let text = "input = 'a.glb'\n[sweep]\nkind = 'forest'\ninput = 'forest.glb'\n";
    let error = Sweep::read(text, &folder.0).unwrap_err().to_string();
    assert!(error.contains("stands outside [sweep]"), "{error}");
}
