//! Cracked breaks and ends of a straight cylinder and of a bent branch: closed, oriented, volumes as calculated.

use greenstick::fracture::cracks::plan;
use greenstick::fracture::parameters::{BreakParameters, CrackParameters, Parameters};
use greenstick::fracture::presets::Preset;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::wood::{noise, primitive, stem};
use greenstick::{Prepared, prepare};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

fn prepared(mesh: Mesh, at: f64) -> Prepared {
    let node = Node {
        name: "stem".into(),
        transform: glam::DAffine3::IDENTITY,
        mesh: mesh.into(),
        parent: None,
    };
    let scene = Scene {
        nodes: vec![node],
        ..Scene::default()
    };
    let place = stem::StemLocation::Fraction(at);
    prepare(scene, &place, &Default::default(), &Context::quiet()).unwrap()
}

/// Three groups of random size.
fn random(seed: u64) -> CrackParameters {
    let mut cracks = CrackParameters::default();
    cracks.settings.distortion = 0.08 * noise::unit(seed, 1, 2, 3);
    let s = &mut cracks.settings;
    for (g, group) in [&mut s.large, &mut s.medium, &mut s.small]
        .into_iter()
        .enumerate()
    {
        let r = |k: i64| noise::unit(seed, g as i64, k, 9);
        group.count = (1.0 + 5.0 * r(0)) as u32;
        group.direction = 360.0 * r(1);
        group.spacing = 20.0 + 90.0 * r(2);
        group.begin_min = 0.3 * r(3);
        group.begin_max = group.begin_min + 0.5 * r(4);
        group.length_min = 0.1 + 0.3 * r(5);
        group.length_max = group.length_min + 0.6 * r(6);
        group.depth_min = 0.1 + r(7);
        group.depth_max = group.depth_min + 1.5 * r(8);
        group.range_min = 5.0 + 20.0 * r(9);
        group.range_max = group.range_min + 100.0 * r(10);
    }
    cracks
}

fn assert_closed(mesh: &Mesh, what: &str) {
    let report = mesh.check();
    assert!(report.closed && report.oriented, "{what}: {report}");
    assert_eq!(report.non_manifold_edges, 0, "{what}: {report}");
    assert_eq!(report.non_manifold_vertices, 0, "{what}: {report}");
}

fn crossings(mesh: &Mesh) -> usize {
    let found = mesh.check().self_intersections;
    found.map_or(0, |s| s.crossing)
}

fn random_sets(prepared: &Prepared, seeds: std::ops::Range<u64>, what: &str) -> usize {
    let mut made = 0;
    for seed in seeds {
        let cracks = plan(&random(seed), (0.06, 0.03), seed);
        for surface in ["smooth", "fibrous"] {
            let mut p = BreakParameters {
                seed,
                ..Default::default()
            };
            p.set_text("surface", surface).unwrap();
            p.set_text("rings", "14").unwrap();
            p.set_text("sectors", "24").unwrap();
            let model = prepared.model(&p, 1.0, 1).unwrap();
            let what = format!("{what}, seed {seed}, {surface}");
            let cracked = prepared
                .crack_break(&model, &p, &cracks, 1)
                .unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_closed(&cracked.lower, &format!("{what}, lower"));
            assert_closed(&cracked.upper, &format!("{what}, upper"));
            assert!(cracked.void > 0.0, "{what}: {}", cracked.void);
            made += cracked.lower_face.cracks;
        }
        let far = seed % 2 == 0;
        let end = prepared
            .crack_end(&Default::default(), &cracks, far, 1)
            .unwrap_or_else(|e| panic!("{what}, seed {seed}, far {far}: {e}"));
        assert_closed(&end.stem, &format!("{what}, seed {seed}, far {far}"));
        assert!(end.void > 0.0);
    }
    made
}

#[test]
fn random_cracks_of_a_cylinder_are_closed() {
    let prepared = prepared(primitive::cylinder(0.05, 0.6, 48), 0.5);
    assert!(random_sets(&prepared, 0..8, "cylinder") > 50);
}

#[test]
fn random_cracks_of_a_bent_branch_are_closed() {
    let prepared = prepared(primitive::branch(&Default::default()), 0.5);
    assert!(random_sets(&prepared, 100..102, "branch") > 10);
}

fn assert_sound(mesh: &Mesh, what: &str) {
    assert_closed(mesh, what);
    assert_eq!(crossings(mesh), 0, "{what}");
    let mut written = mesh.clone();
    greenstick::skin::settle::settle(&mut written, 1);
    let done = greenstick::skin::untangle::untangle(&mut written, &Default::default());
    assert_closed(&written, &format!("{what}, as written"));
    assert_eq!(crossings(&written), 0, "{what}, as written: {done:?}");
    let change = written.volume() / mesh.volume() - 1.0;
    assert!(change.abs() < 1e-5, "{what}, as written: {change}");
}

fn scanned_pole() -> Option<Mesh> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/pole.ply");
    let bytes = std::fs::read(path).ok()?;
    let unit = Some(greenstick::formats::LengthUnit::Millimetre);
    let scene = greenstick::formats::read(
        greenstick::formats::Format::Ply,
        &bytes,
        "pole.ply",
        unit,
        &|_| Err(std::io::ErrorKind::NotFound.into()),
    );
    let node = scene.ok()?.nodes.into_iter().next()?;
    Some(node.mesh.transformed(&node.transform))
}

/// Sets of cracks in breaks, in turn of bent branch, board and scanned pole.
#[test]
fn cracks_in_breaks_are_sound_as_made_and_as_written() {
    let coarse = primitive::BranchOptions {
        around: 32,
        ..Default::default()
    };
    let mut bodies = vec![
        ("branch", prepared(primitive::branch(&coarse), 0.5)),
        ("board", prepared(primitive::board(0.6, 0.09, 0.03), 0.5)),
    ];
    match scanned_pole() {
        Some(mesh) => bodies.push(("pole", prepared(mesh, 0.6))),
        None => println!("without the pole: tests/data/pole.ply is not there"),
    }
    (0..30u64).into_par_iter().for_each(|seed| {
        let (name, body) = &bodies[seed as usize % bodies.len()];
        let what = format!("{name}, seed {seed}");
        let cracks = plan(&random(1000 + seed), (0.06, 0.03), seed);
        let mut p = BreakParameters {
            seed,
            ..Default::default()
        };
        p.set_text("rings", "8").unwrap();
        p.set_text("sectors", "16").unwrap();
        let model = body.model(&p, 1.0, 1).unwrap();
        let cracked = body.crack_break(&model, &p, &cracks, 1);
        let cracked = cracked.unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_sound(&cracked.lower, &format!("{what}, lower"));
        assert_sound(&cracked.upper, &format!("{what}, upper"));
    });
}

#[test]
fn the_papers_figures_crack_a_sawn_end() {
    let prepared = prepared(primitive::cylinder(0.05, 0.6, 64), 0.7);
    for (name, least) in [("fig20", 3), ("fig21", 20)] {
        let (mut face, mut cracks) = Default::default();
        Preset::find(name)
            .unwrap()
            .apply(&mut face, &mut cracks)
            .unwrap();
        let plan = plan(&cracks, (0.05, 0.025), 3);
        let end = prepared.crack_end(&face, &plan, true, 1).unwrap();
        eprintln!(
            "{name}: {} cracks, {} closed, {} outside, {} shortened, {} skipped, widest {:.2} mm, deepest {:.1} mm",
            end.face.cracks,
            end.face.closed,
            end.face.outside,
            plan.shortened,
            plan.skipped,
            1e3 * end.face.widest,
            1e3 * end.face.deepest
        );
        assert!(end.face.cracks >= least, "{name}: {}", end.face.cracks);
        // Seen at 1000 pixels across the section the widest crack is more than 10 wide, but no gap.
        assert!(end.face.widest > 0.001 && end.face.widest < 0.01);
        assert_closed(&end.stem, name);
        assert_eq!(crossings(&end.stem), 0, "{name}");
    }
}

/// Random cracks in the sawn ends of a bent branch, a board and a scanned pole, which is no flat face, broken whole.
#[test]
fn cracked_ends_of_any_stem_are_sound_in_the_file() {
    let coarse = primitive::BranchOptions {
        around: 32,
        ..Default::default()
    };
    let mut bodies = vec![
        ("branch", primitive::branch(&coarse), false),
        ("board", primitive::board(0.6, 0.09, 0.03), false),
    ];
    match scanned_pole() {
        Some(mesh) => bodies.push(("pole", mesh, true)),
        None => println!("without the pole: tests/data/pole.ply is not there"),
    }
    let faulty = AtomicUsize::new(0);
    (0..18u64).into_par_iter().for_each(|seed| {
        let (name, mesh, torn) = &bodies[seed as usize % bodies.len()];
        let what = format!("{name}, seed {seed}");
        let mut request = greenstick::BreakRequest {
            place: stem::StemLocation::Fraction(0.4),
            texture_width: 64,
            ..Default::default()
        };
        request.recipe.cracks = random(2000 + seed);
        let settings = &mut request.recipe.cracks.settings;
        settings.set_text("end", "sawn").unwrap();
        request.recipe.face.seed = seed;
        request.recipe.face.set_text("rings", "8").unwrap();
        request.recipe.face.set_text("sectors", "16").unwrap();
        let scene = Scene {
            nodes: vec![Node {
                name: (*name).into(),
                transform: glam::DAffine3::IDENTITY,
                mesh: mesh.clone().into(),
                parent: None,
            }],
            ..Scene::default()
        };
        let broken = greenstick::break_scene(scene, &request, &Context::quiet());
        let broken = broken.unwrap_or_else(|e| panic!("{what}: {e}"));
        let report = &broken.report;
        let sawn = |note: &String| note.contains("sawn off straight");
        assert_eq!(report.notes.iter().any(sawn), *torn, "{what}");
        assert!(report.crack_volume_m3.unwrap() > 0.0, "{what}");
        for piece in &broken.scene.nodes[..2] {
            let found = piece.mesh.check();
            let told = |n: &String| n.starts_with(&piece.name) && n.ends_with("are left");
            let told = report.notes.iter().any(told);
            assert_eq!(found.is_solid(), !told, "{what}, {}: {found:?}", piece.name);
            faulty.fetch_add(usize::from(told), Ordering::Relaxed);
        }
        // What the cracks took, and no more, is missing where nothing was sawn off.
        let pieces: f64 = report.pieces.iter().filter_map(|p| p.volume_m3).sum();
        let whole = report.input.volume_m3.unwrap() - report.crack_volume_m3.unwrap();
        assert!(
            *torn || (pieces / whole - 1.0).abs() < 1e-6,
            "{what}: {pieces} of {whole}"
        );
    });
    // One pole's crack ends in a wall thinner than neighbouring numbers of f32.
    assert!(faulty.into_inner() <= 1);
}

/// One radial crack from 0.2 to 0.9, distorted by nothing: ∫ ½ · width · depth along the radius.
#[test]
fn a_radial_crack_takes_out_the_volume_of_its_formula() {
    let radius = 0.05;
    let prepared = prepared(primitive::cylinder(radius, 0.6, 192), 0.5);
    let mut cracks = CrackParameters::default();
    cracks.settings.distortion = 0.0;
    for group in ["large.count", "medium.count", "small.count"] {
        cracks.settings.set_text(group, "0").unwrap();
    }
    let mut crack = greenstick::fracture::parameters::Crack::of_kind("radial").unwrap();
    for (key, value) in [
        ("angle", "0"),
        ("begin", "0.2"),
        ("end", "0.9"),
        ("range", "60"),
    ] {
        use greenstick::fracture::parameters::Value;
        crack
            .set(key, &Value::Number(value.parse().unwrap()))
            .unwrap();
    }
    cracks.cracks.push(crack);
    let plan = plan(&cracks, (0.06, 0.03), 1);
    let (steps, mut sum) = (100_000, 0.0);
    for i in 0..steps {
        let r = 0.2 + 0.7 * (f64::from(i) + 0.5) / f64::from(steps);
        let x = (r - 0.55f64).abs() / 0.35;
        let width = 0.06 * 60f64.to_radians() * r * (1.0 - x);
        sum += 0.5 * width * (1.0 - x * x).sqrt() * 0.7 / f64::from(steps);
    }
    let expected = sum * radius.powi(3);
    let end = prepared
        .crack_end(&Default::default(), &plan, true, 1)
        .unwrap();
    let off = end.void / expected - 1.0;
    assert!(
        off.abs() < 0.01,
        "end: {} against {expected}: {off}",
        end.void
    );
    let mut p = BreakParameters::default();
    p.set_text("surface", "smooth").unwrap();
    let model = prepared.model(&p, 1.0, 1).unwrap();
    let cracked = prepared.crack_break(&model, &p, &plan, 1).unwrap();
    let off = cracked.void / (2.0 * expected) - 1.0;
    assert!(
        off.abs() < 0.01,
        "break: {} against twice {expected}: {off}",
        cracked.void
    );
}
