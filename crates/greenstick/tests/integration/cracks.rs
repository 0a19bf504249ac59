//! Cracked breaks and ends of a straight cylinder and of a bent branch: closed, oriented, volumes as calculated.

use crate::support::{pieces, request, scanned_pole, scene, session, stages};
use greenstick::fracture::cracks::{CrackPlan, plan};
use greenstick::fracture::parameters::{BreakParameters, CrackParameters};
use greenstick::fracture::presets::Preset;
use greenstick::fracture::recipe::{apply_preset, apply_setting};
use greenstick::geometry::repair::{resolve_self_intersections, snap_to_f32};
use greenstick::geometry::{Context, Mesh};
use greenstick::schema::Parameters;
use greenstick::session::StemStage;
use greenstick::skin::BreakError;
use greenstick::skin::cracks::{crack_end, crack_faces};
use greenstick::wood::{noise, primitive};
use greenstick::{BreakSession, break_scene, built_in_branch};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A break with the cracks of a plan in both faces.
struct CrackedBreak {
    pieces: [Mesh; 2],
    /// Cracks in the lower face.
    cracks: usize,
    /// Volume of the cracks, m³.
    void: f64,
}

fn crack_break(
    session: &mut BreakSession,
    at: f64,
    p: &BreakParameters,
    plan: &CrackPlan,
) -> Result<CrackedBreak, BreakError> {
    let stages = stages(session, at, p);
    let (stem, inner) = (stages.stem.stem(), stages.inner_wood(p));
    let faces = crack_faces(
        stem,
        &stages.heights.heights.surface,
        plan,
        &inner,
        &Context::quiet(),
    )?;
    let cracked = [0, 1].map(|i| faces[i].piece(stem, &inner, i == 1));
    let volume = |pieces: &[Mesh; 2]| pieces.iter().map(Mesh::volume).sum::<f64>();
    Ok(CrackedBreak {
        void: volume(&pieces(&stages, p)) - volume(&cracked),
        cracks: faces[0].grooves.cracks,
        pieces: cracked,
    })
}

fn stem_of(session: &mut BreakSession, at: f64) -> StemStage {
    let request = request(at, &Default::default());
    session.stem(&request, &Context::quiet()).unwrap()
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

fn random_sets(
    session: &mut BreakSession,
    at: f64,
    seeds: std::ops::Range<u64>,
    what: &str,
) -> usize {
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
            let what = format!("{what}, seed {seed}, {surface}");
            let cracked = crack_break(session, at, &p, &cracks);
            let cracked = cracked.unwrap_or_else(|e| panic!("{what}: {e}"));
            let [lower, upper] = &cracked.pieces;
            assert_closed(lower, &format!("{what}, lower"));
            assert_closed(upper, &format!("{what}, upper"));
            assert!(cracked.void > 0.0, "{what}: {}", cracked.void);
            made += cracked.cracks;
        }
        let far = seed % 2 == 0;
        let stem = stem_of(session, at).sound;
        let end = crack_end(
            &stem,
            &Default::default(),
            &cracks,
            far,
            1,
            &Context::quiet(),
        )
        .unwrap_or_else(|e| panic!("{what}, seed {seed}, far {far}: {e}"));
        assert_closed(&end.mesh, &format!("{what}, seed {seed}, far {far}"));
        assert!(end.void > 0.0);
    }
    made
}

#[test]
fn random_cracks_of_a_cylinder_are_closed() {
    let mut session = session(primitive::cylinder(0.05, 0.6, 48));
    assert!(random_sets(&mut session, 0.5, 0..8, "cylinder") > 50);
}

#[test]
fn random_cracks_of_a_bent_branch_are_closed() {
    let mut session = session(primitive::branch(&Default::default()));
    assert!(random_sets(&mut session, 0.5, 100..102, "branch") > 10);
}

fn assert_sound(mesh: &Mesh, what: &str) {
    assert_closed(mesh, what);
    assert_eq!(crossings(mesh), 0, "{what}");
    let mut written = mesh.clone();
    snap_to_f32(&mut written, 1);
    let done = resolve_self_intersections(&mut written, &Default::default(), &Context::quiet());
    assert_closed(&written, &format!("{what}, as written"));
    assert_eq!(crossings(&written), 0, "{what}, as written: {done:?}");
    let change = written.volume() / mesh.volume() - 1.0;
    assert!(change.abs() < 1e-5, "{what}, as written: {change}");
}

fn pole_mesh() -> Mesh {
    let node = &scanned_pole().nodes[0];
    node.mesh.transformed(&node.transform)
}

/// Sets of cracks in breaks, in turn of bent branch, board and scanned pole.
#[test]
fn cracks_in_breaks_are_sound_as_made_and_as_written() {
    let coarse = primitive::BranchOptions {
        around: 32,
        ..Default::default()
    };
    let bodies = [
        ("branch", 0.5, session(primitive::branch(&coarse))),
        ("board", 0.5, session(primitive::board(0.6, 0.09, 0.03))),
        ("pole", 0.6, session(pole_mesh())),
    ];
    (0..30u64).into_par_iter().for_each(|seed| {
        let (name, at, body) = &bodies[seed as usize % bodies.len()];
        let what = format!("{name}, seed {seed}");
        let cracks = plan(&random(1000 + seed), (0.06, 0.03), seed);
        let mut p = BreakParameters {
            seed,
            ..Default::default()
        };
        p.set_text("rings", "8").unwrap();
        p.set_text("sectors", "16").unwrap();
        let cracked = crack_break(&mut body.fork(), *at, &p, &cracks);
        let cracked = cracked.unwrap_or_else(|e| panic!("{what}: {e}"));
        for (name, piece) in ["lower", "upper"].iter().zip(&cracked.pieces) {
            assert_sound(piece, &format!("{what}, {name}"));
        }
    });
}

#[test]
fn the_papers_figures_crack_a_sawn_end() {
    let stem = stem_of(&mut session(primitive::cylinder(0.05, 0.6, 64)), 0.7).sound;
    for (name, least) in [("fig20", 3), ("fig21", 20)] {
        let (mut face, mut cracks) = Default::default();
        Preset::find(name)
            .unwrap()
            .apply(&mut face, &mut cracks)
            .unwrap();
        let plan = plan(&cracks, (0.05, 0.025), 3);
        let end = crack_end(&stem, &face, &plan, true, 1, &Context::quiet()).unwrap();
        let made = &end.grooves;
        eprintln!(
            "{name}: {} cracks, {} closed, {} outside, {} shortened, {} skipped, widest {:.2} mm, deepest {:.1} mm",
            made.cracks,
            made.closed,
            made.outside,
            plan.shortened,
            plan.skipped,
            1e3 * made.widest,
            1e3 * made.deepest
        );
        assert!(made.cracks >= least, "{name}: {}", made.cracks);
        // Seen at 1000 pixels across the section the widest crack is more than 10 wide, but no gap.
        assert!(made.widest > 0.001 && made.widest < 0.01);
        assert_closed(&end.mesh, name);
        assert_eq!(crossings(&end.mesh), 0, "{name}");
    }
}

/// Random cracks in the sawn ends of a bent branch, a board and a scanned pole, which is no flat face, broken whole.
#[test]
fn cracked_ends_of_any_stem_are_sound_in_the_file() {
    let coarse = primitive::BranchOptions {
        around: 32,
        ..Default::default()
    };
    let bodies = [
        ("branch", primitive::branch(&coarse), false),
        ("board", primitive::board(0.6, 0.09, 0.03), false),
        ("pole", pole_mesh(), true),
    ];
    let faulty = AtomicUsize::new(0);
    (0..18u64).into_par_iter().for_each(|seed| {
        let (name, mesh, torn) = &bodies[seed as usize % bodies.len()];
        let what = format!("{name}, seed {seed}");
        let mut request = request(0.4, &Default::default());
        request.texture_width = 64;
        let recipe = &mut request.breaks[0].recipe;
        recipe.cracks = random(2000 + seed);
        recipe.cracks.settings.set_text("end", "sawn").unwrap();
        recipe.face.seed = seed;
        recipe.face.set_text("rings", "8").unwrap();
        recipe.face.set_text("sectors", "16").unwrap();
        let broken = break_scene(scene(mesh.clone(), 1.0), &request, &Context::quiet());
        let broken = broken.unwrap_or_else(|e| panic!("{what}: {e}"));
        let report = &broken.report;
        let sawn = |note: &String| note.contains("sawn off straight");
        assert_eq!(report.notes.iter().any(sawn), *torn, "{what}");
        assert!(report.crack_volume_m3.unwrap() > 0.0, "{what}");
        for piece in &broken.scene.nodes[..2] {
            let found = piece.mesh.check();
            let is_left = |n: &String| n.starts_with(&piece.name) && n.ends_with("are left");
            let reported = report.notes.iter().any(is_left);
            assert_eq!(
                found.is_solid(),
                !reported,
                "{what}, {}: {found:?}",
                piece.name
            );
            faulty.fetch_add(usize::from(reported), Ordering::Relaxed);
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

/// The same at the base; of the pole it is no flat face either.
#[test]
fn cracks_open_the_end_at_the_base_as_that_at_the_tip() {
    let coarse = primitive::BranchOptions {
        around: 32,
        ..Default::default()
    };
    let bodies = [
        ("branch", primitive::branch(&coarse), false),
        ("board", primitive::board(0.6, 0.09, 0.03), false),
        ("pole", pole_mesh(), true),
    ];
    for (seed, (name, mesh, torn)) in bodies.into_iter().enumerate() {
        let mut request = request(0.6, &Default::default());
        request.texture_width = 64;
        let recipe = &mut request.breaks[0].recipe;
        recipe.cracks = random(2100 + seed as u64);
        recipe.cracks.settings.set_text("end", "base").unwrap();
        recipe.face.set_text("rings", "8").unwrap();
        recipe.face.set_text("sectors", "16").unwrap();
        let broken = break_scene(scene(mesh, 1.0), &request, &Context::quiet());
        let broken = broken.unwrap_or_else(|e| panic!("{name}: {e}"));
        let report = &broken.report;
        let said = |text: &str| report.notes.iter().any(|n| n.contains(text));
        assert_eq!(said("sawn off straight"), torn, "{name}");
        assert!(said("end at the base"), "{name}: {:?}", report.notes);
        assert!(report.crack_volume_m3.unwrap() > 0.0, "{name}");
        let ([lower, upper], at) = (
            [0, 1].map(|i| &broken.scene.nodes[i].mesh),
            broken.end.unwrap(),
        );
        for piece in [lower, upper] {
            assert!(piece.check().is_solid(), "{name}: {}", piece.check());
        }
        // It faces away from the upper piece, and lies at the lower one.
        let nearest = |mesh: &Mesh| {
            let off = |p: &glam::DVec3| p.distance(at.middle);
            mesh.positions.iter().map(off).fold(f64::INFINITY, f64::min)
        };
        assert!(
            nearest(lower) < at.radius && nearest(upper) > at.radius,
            "{name}"
        );
        let middle = upper.positions.iter().sum::<glam::DVec3>() / upper.positions.len() as f64;
        assert!((middle - at.middle).dot(at.outward) < 0.0, "{name}");
        let pieces: f64 = report.pieces.iter().filter_map(|p| p.volume_m3).sum();
        let whole = report.input.volume_m3.unwrap() - report.crack_volume_m3.unwrap();
        let off = pieces / whole - 1.0;
        assert!(
            if torn { off < 0.0 } else { off.abs() < 1e-6 },
            "{name}: {off}"
        );
    }
}

/// One radial crack from 0.2 to 0.9, distorted by nothing: ∫ ½ · width · depth along the radius.
#[test]
fn a_radial_crack_takes_out_the_volume_of_its_formula() {
    let radius = 0.05;
    let mut session = session(primitive::cylinder(radius, 0.6, 192));
    let mut cracks = CrackParameters::default();
    cracks.settings.distortion = 0.0;
    for group in ["large.count", "medium.count", "small.count"] {
        cracks.settings.set_text(group, "0").unwrap();
    }
    let mut crack = greenstick::fracture::parameters::Crack::default();
    for (key, value) in [
        ("angle", "0"),
        ("begin", "0.2"),
        ("end", "0.9"),
        ("range", "60"),
    ] {
        use greenstick::schema::Value;
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
    let stem = stem_of(&mut session, 0.5).sound;
    let end = crack_end(
        &stem,
        &Default::default(),
        &plan,
        true,
        1,
        &Context::quiet(),
    )
    .unwrap();
    let off = end.void / expected - 1.0;
    assert!(
        off.abs() < 0.01,
        "end: {} against {expected}: {off}",
        end.void
    );
    let mut p = BreakParameters::default();
    p.set_text("surface", "smooth").unwrap();
    let cracked = crack_break(&mut session, 0.5, &p, &plan).unwrap();
    let off = cracked.void / (2.0 * expected) - 1.0;
    assert!(
        off.abs() < 0.01,
        "break: {} against twice {expected}: {off}",
        cracked.void
    );
}

/// The paper's cracked sections on the built-in branch, straight and distorted: nothing crosses in what is written.
#[test]
fn sawn_ends_of_the_figures_are_free_of_crossings() {
    let straight = "crack_groups.distortion=0";
    let cases = [
        ("fig20", None),
        ("fig20b", None),
        ("fig21", None),
        ("fig21", Some(straight)),
    ];
    cases.into_par_iter().for_each(|(preset, setting)| {
        let mut request = request(0.5, &Default::default());
        request.texture_width = 8;
        let recipe = &mut request.breaks[0].recipe;
        apply_preset(recipe, preset).unwrap();
        for setting in ["rings=8", "sectors=16"].into_iter().chain(setting) {
            apply_setting(recipe, setting).unwrap();
        }
        let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
        for node in &broken.scene.nodes[..2] {
            let what = format!("{preset}, {setting:?}, {}", node.name);
            assert_closed(&node.mesh, &what);
            assert_eq!(
                crossings(&node.mesh),
                0,
                "{what}: {:?}",
                broken.report.notes
            );
        }
    });
}
