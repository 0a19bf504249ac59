//! Random parameters over the whole of their ranges, on a bent branch, a board and a scanned pole: both pieces are
//! always closed, oriented and free of crossings, and their volumes add up to the input's.

use crate::support::{
    data::{data, outside_data},
    pieces, request, scanned_pole, scene, stages,
};
use glam::DVec3;
use greenstick::fracture::parameters::BreakParameters;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::intersect::{Contact, contact_tree, self_contacts};
use greenstick::geometry::repair::snap_to_f32;
use greenstick::geometry::{Aabb, CheckOptions, Context, Mesh, Scene};
use greenstick::schema::{Kind, Parameters, Value};
use greenstick::wood::stem::StemLocation;
use greenstick::wood::{noise, primitive};
use greenstick::{Break, BreakRequest, BreakSession, break_scene, built_in_branch};
use rayon::prelude::*;

const SETS: usize = 1000;
/// Material of the wood inside.
const INNER: u32 = 1;

/// A value anywhere in every parameter's range; counts and frequencies evenly over their orders of magnitude.
fn random_parameters(set: usize) -> BreakParameters {
    let mut p = BreakParameters::default();
    let unit = |i: usize| noise::unit(0xd1ce, set as i64, i as i64, 0);
    for (i, info) in BreakParameters::table().into_iter().enumerate() {
        let u = unit(i);
        // A third of all parameters stays as it is, so that sets are not all of one kind.
        // Spiral grain is no parameter of Table 2 and is tried by its own test below.
        let kept = unit(i + 1000) < 0.33 && info.key != "seed";
        if kept || info.key == "spiral_angle" {
            continue;
        }
        let value = match info.kind {
            Kind::Number { min, max, .. } if max / min.max(1e-9) >= 1000.0 && min > 0.0 => {
                Value::Number(min * (max / min).powf(u))
            }
            Kind::Number { min, max, .. } => Value::Number(min + (max - min) * u),
            Kind::Integer { min, max, .. } if max <= 1000 && min > 0 => {
                let (min, max) = (min as f64, max as f64);
                Value::Integer((min * (max / min).powf(u)).round() as i128)
            }
            Kind::Integer { min, max, .. } => {
                Value::Integer(min + ((max - min) as f64 * u) as i128)
            }
            Kind::Choice { options } => {
                let choice = options[(u * options.len() as f64) as usize % options.len()];
                Value::Text(choice.word.to_owned())
            }
            _ => panic!("{} is of no kind that a face has", info.key),
        };
        p.set(&info.key, &value)
            .unwrap_or_else(|e| panic!("{}: {e}", info.key));
    }
    // Proportions must not pass 1 together.
    let sum = p.pith_proportion + p.heartwood_proportion + p.phloem_proportion;
    if sum > 1.0 {
        p.pith_proportion /= sum * 1.001;
        p.heartwood_proportion /= sum * 1.001;
        p.phloem_proportion /= sum * 1.001;
    }
    // The largest faces are made often enough to be tried, and seldom enough for the time there is.
    let most = match set % 50 {
        49 => 12_000,
        _ => 600,
    };
    while p.rings * p.sectors > most {
        (p.rings, p.sectors) = (p.rings / 2, p.sectors / 2);
    }
    (p.rings, p.sectors) = (p.rings.max(3), p.sectors.max(10));
    p.check().unwrap();
    p
}

const QUICK: CheckOptions = CheckOptions {
    self_intersections: false,
};

/// The triangles of a piece that may cross others. What lies away from the break is skin of the input, which crosses nothing: only
/// triangles that reach into the box of the broken face, of the skin cut along it and of the skin beside that are looked at.
fn about_break(piece: &Mesh) -> impl Iterator<Item = usize> {
    let (points, count) = piece.points();
    let mut changed = vec![false; count];
    let point = |v: &u32| points[*v as usize] as usize;
    for (t, corners) in piece.triangles.iter().enumerate() {
        if piece.material(t) == INNER {
            corners.iter().for_each(|v| changed[point(v)] = true);
        }
    }
    let touches = |t: &[u32; 3]| t.iter().any(|v| changed[point(v)]);
    let near = (0..piece.triangles.len())
        .filter(|&t| touches(&piece.triangles[t]))
        .map(|t| Aabb::around(&piece.corners(t)))
        .fold(Aabb::EMPTY, |all, one| all.join(&one));
    (0..piece.triangles.len()).filter(move |&t| Aabb::around(&piece.corners(t)).overlaps(&near))
}

/// Pairs of triangles of a piece that cross.
fn crossings(piece: &Mesh) -> usize {
    let part = Mesh {
        positions: piece.positions.clone(),
        triangles: about_break(piece).map(|t| piece.triangles[t]).collect(),
        ..Mesh::default()
    };
    let mut crossing = 0;
    self_contacts(&part, &contact_tree(&part), |_, _, contact| {
        crossing += usize::from(contact == Contact::Crossing);
    });
    crossing
}

/// Pairs of triangles that cross, of the lower and of the upper piece. Their broken faces must be the same, the upper one turned over,
/// and are looked at once.
fn crossings_of_both([lower, upper]: &[Mesh; 2]) -> Result<[usize; 2], &'static str> {
    let face = |piece: &Mesh| -> Vec<[DVec3; 3]> {
        let inner = (0..piece.triangles.len()).filter(|&t| piece.material(t) == INNER);
        inner.map(|t| piece.corners(t)).collect()
    };
    let turned_over = |[a, b, c]: [DVec3; 3]| [a, c, b];
    let faces = [lower, upper].map(face);
    if !faces[0]
        .iter()
        .copied()
        .map(turned_over)
        .eq(faces[1].iter().copied())
    {
        return Err("two broken faces");
    }
    let mut both = Mesh {
        positions: [&*lower.positions, &*upper.positions].concat(),
        ..Mesh::default()
    };
    // Which pieces each triangle belongs to.
    let mut owners: Vec<[bool; 2]> = Vec::new();
    for t in about_break(lower) {
        both.triangles.push(lower.triangles[t]);
        owners.push([true, lower.material(t) == INNER]);
    }
    for t in about_break(upper).filter(|&t| upper.material(t) != INNER) {
        let shifted = upper.triangles[t].map(|v| v + lower.positions.len() as u32);
        both.triangles.push(shifted);
        owners.push([false, true]);
    }
    let mut crossing = [0; 2];
    self_contacts(&both, &contact_tree(&both), |a, b, contact| {
        for (piece, crossing) in crossing.iter_mut().enumerate() {
            let is_own = owners[a][piece] && owners[b][piece];
            *crossing += usize::from(is_own && contact == Contact::Crossing);
        }
    });
    Ok(crossing)
}

/// What is wrong with the break of one set of parameters.
fn faults(session: &mut BreakSession, at: f64, set: usize, volume: f64) -> Vec<String> {
    let p = random_parameters(set);
    let what = format!(
        "set {set}, rings {}, sectors {}, {:?}",
        p.rings, p.sectors, p.surface
    );
    let stages = match session.stages(&request(at, &p), &Context::quiet()) {
        Ok(stages) => stages,
        Err(error) => return vec![format!("{what}: {error}")],
    };
    let mut faults = Vec::new();
    let mut sum = 0.0;
    let pieces = pieces(&stages, &p);
    let crossing = match crossings_of_both(&pieces) {
        Ok(crossing) => crossing,
        Err(error) => return vec![format!("{what}: {error}")],
    };
    let named = ["lower", "upper"].into_iter().zip(crossing);
    for ((name, crossing), mut piece) in named.zip(pieces) {
        let report = piece.check_with(QUICK);
        if !report.is_solid() || crossing > 0 {
            faults.push(format!("{what}, {name}: {crossing} crossings, {report}"));
        }
        sum += piece.volume();
        snap_to_f32(&mut piece, INNER);
        let report = piece.check_with(QUICK);
        if !(report.closed || report.non_manifold_edges > 0) || !report.oriented {
            faults.push(format!("{what}, {name} as written: {report}"));
        }
    }
    if (sum / volume - 1.0).abs() > 1e-6 {
        faults.push(format!("{what}: volumes {sum} against {volume}"));
    }
    faults
}

/// Breaks a scene with random parameters. `scenes` are the same body, the first of them in fine triangles, which every
/// tenth set breaks.
fn run(name: &str, scenes: [Scene; 2], at: f64) {
    let bodies = scenes.map(|scene| {
        let volume = scene.nodes[0].mesh.volume();
        let mut session = BreakSession::new(scene);
        let stem = session.stem(&request(at, &Default::default()), &Context::quiet());
        let report = stem.unwrap().sound.node().mesh.check();
        assert!(report.is_solid(), "{name}, before any break: {report}");
        (session, volume)
    });
    let faults: Vec<String> = (0..SETS / 3 + 1)
        .into_par_iter()
        .flat_map_iter(|set| {
            let (session, volume) = &bodies[usize::from(set % 10 != 0)];
            faults(&mut session.fork(), at, set, *volume)
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{name}: {} faults\n{}",
        faults.len(),
        faults.join("\n")
    );
}

#[test]
fn random_breaks_of_a_bent_branch_are_sound() {
    let coarse = primitive::BranchOptions {
        around: 40,
        ..Default::default()
    };
    let scenes = [Default::default(), coarse].map(|o| scene(primitive::branch(&o), 1.0));
    run("branch", scenes, 0.45);
}

#[test]
fn random_breaks_of_a_board_are_sound() {
    let board = || scene(primitive::board(0.9, 0.12, 0.025), 1.0);
    run("board", [board(), board()], 0.4);
}

#[test]
fn random_breaks_of_a_scanned_pole_are_sound() {
    run("pole", [scanned_pole(), scanned_pole()], 0.6);
}

#[test]
fn a_break_in_spiral_grain_is_closed_and_adds_up() {
    let scene = built_in_branch();
    let volume = scene.nodes[0].mesh.volume();
    let mut session = BreakSession::new(scene);
    for seed in 0..2 {
        let mut p = BreakParameters {
            seed,
            ..BreakParameters::default()
        };
        let twist = greenstick::fracture::presets::Preset::find("twist").unwrap();
        twist.apply(&mut p, &mut Default::default()).unwrap();
        let stages = stages(&mut session, 0.5, &p);
        let repair = stages.cut.face.spiral.unwrap();
        let mut sum = 0.0;
        for mut piece in pieces(&stages, &p) {
            let report = piece.check_with(QUICK);
            assert!(report.closed && report.oriented, "seed {seed}: {report}");
            sum += piece.volume();
            // The report counts all crossings that there are at the positions that files hold.
            snap_to_f32(&mut piece, INNER);
            let crossing = crossings(&piece);
            assert!(
                crossing <= repair.remaining,
                "seed {seed}: {crossing}, {repair:?}"
            );
        }
        assert!(
            (sum / volume - 1.0).abs() < 1e-5,
            "seed {seed}: {sum} against {volume}"
        );
    }
}

/// Stems of all sizes, thick and thin, of large and of small triangles, smooth and furrowed, bent at random. Most faces are
/// coarse, which takes less time. Of the others, that of stem 4 has 8,302 pairs that cross at first: moving their vertices one by
/// one took minutes. On stem 14 files hold two vertices of the outline at one position, where edges of four triangles came about.
#[test]
fn twisted_breaks_of_random_stems_are_closed_and_do_not_cross() {
    let twist = Recipe::resolve(&["twist"], None, &[]).unwrap();
    (0..20).into_par_iter().for_each(|stem: i64| {
        let unit = |what: i64| noise::unit(0x5eed, stem, what, 0);
        let options = primitive::BranchOptions {
            length: 0.6 + 3.0 * unit(0),
            diameter: 0.03 + 0.15 * unit(1).powi(2),
            relief: unit(2),
            around: 12 + (60.0 * unit(3).powi(2)) as u32,
            seed: stem as u64,
        };
        let mut recipe = twist.clone();
        recipe.face.seed = 100 + stem as u64;
        if ![4, 14].contains(&stem) {
            (recipe.face.rings, recipe.face.sectors) = (8, 32);
        }
        let place = 0.3 + 0.4 * unit(4);
        let request = BreakRequest {
            texture_width: 0,
            ..BreakRequest::single(Break {
                place: StemLocation::Fraction(place),
                recipe,
                ..Break::default()
            })
        };
        let mesh = primitive::branch(&options);
        let volume = mesh.volume();
        let broken = break_scene(scene(mesh, 1.0), &request, &Context::quiet())
            .unwrap_or_else(|error| panic!("stem {stem}, {options:?} at {place}: {error}"));
        let mut sum = 0.0;
        for node in &broken.scene.nodes[..2] {
            let report = node.mesh.check_with(QUICK);
            let what = format!("stem {stem}, {}, {options:?} at {place}", node.name);
            assert!(report.closed && report.oriented, "{what}: {report}");
            let crossing = crossings(&node.mesh);
            assert_eq!(crossing, 0, "{what}: {}", broken.report);
            sum += node.mesh.volume();
        }
        assert!(
            (sum / volume - 1.0).abs() < 1e-5,
            "stem {stem}: {sum} {volume}"
        );
    });
}

/// A scan, and trees of few, large triangles; the last high up on a thin stem, where positions in files lie far apart for its radius,
/// and sides are wide.
#[test]
fn twisted_breaks_of_scans_and_trees_do_not_cross() {
    let read = |name| greenstick::files::read(&data(name), None).unwrap();
    let cases = [
        ("pole", scanned_pole(), 0.5),
        ("dead tree", read("quaternius_DeadTree_1.gltf"), 0.1),
        ("bare tree", read("kaykit_Tree_Bare_1_C_Color1.obj"), 0.5),
        ("its top", read("kaykit_Tree_Bare_1_C_Color1.obj"), 0.82),
    ];
    cases.into_par_iter().for_each(assert_no_twisted_crossings);
}

/// The other bare tree. Rings of its vertices lie within micrometres of where the levels of spiral grain would be, where triangles
/// without height came about.
#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn twisted_breaks_where_vertices_lie_at_levels_do_not_cross() {
    let file = outside_data("trees/kaykit_Tree_Bare_2_C_Color1.obj");
    let scene = greenstick::files::read(&file, None).unwrap();
    (["0.82", "0.84"].into_par_iter()).for_each(|place| {
        assert_no_twisted_crossings((place, scene.clone(), place.parse().unwrap()));
    });
}

/// Breaks a scene with the preset `twist` at a fraction of its stem; both pieces have no crossing triangles.
fn assert_no_twisted_crossings((name, scene, place): (&str, Scene, f64)) {
    let request = BreakRequest {
        texture_width: 0,
        ..BreakRequest::single(Break {
            place: StemLocation::Fraction(place),
            recipe: Recipe::resolve(&["twist"], None, &[]).unwrap(),
            ..Break::default()
        })
    };
    let closed = scene.nodes[0].mesh.check_with(QUICK).closed;
    let broken = break_scene(scene, &request, &Context::quiet()).unwrap();
    for node in &broken.scene.nodes[..2] {
        let report = node.mesh.check();
        let what = format!("{name}, {}: {report}", node.name);
        assert!(report.oriented && (report.closed || !closed), "{what}");
        assert_eq!(
            report.self_intersections.map(|s| s.crossing),
            Some(0),
            "{what}"
        );
    }
}
