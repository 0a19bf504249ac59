//! Leaning splinters: pieces stay solids, halves fit where nothing leans, and splinters lean as much and to as many sides as they are
//! asked to, more towards their tips, and some snap.

use crate::support::{data::data, scanned_pole};
use glam::{DVec2, DVec3};
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{CheckOptions, Context, Scene};
use greenstick::skin::lean::LeanReport;
use greenstick::wood::stem::StemLocation;
use greenstick::{Break, BreakRequest, Broken, break_scene, built_in_branch};
use std::collections::HashMap;

fn broken(scene: Scene, at: f64, settings: &[&str]) -> Broken {
    moved_apart(scene, at, 0.0, settings)
}

/// A break whose pieces are moved apart by a length, m.
fn moved_apart(scene: Scene, at: f64, separation: f64, settings: &[&str]) -> Broken {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break {
            place: StemLocation::Fraction(at),
            separation,
            recipe: Recipe::resolve(&[], None, settings).unwrap(),
            ..Break::default()
        })
    };
    break_scene(scene, &request, &Context::quiet()).unwrap()
}

fn leans(broken: &Broken) -> [LeanReport; 2] {
    [0, 1].map(|i| broken.report.pieces[i].lean.expect("splinters lean"))
}

#[test]
fn pieces_with_leaning_splinters_are_solids_of_nearly_the_same_volume() {
    let read = |name: &str| greenstick::files::read(&data(name), None).unwrap();
    for (name, scene, at) in [
        ("branch", built_in_branch(), 0.5),
        ("pole", scanned_pole(), 0.5),
        ("dead tree", read("quaternius_DeadTree_1.gltf"), 0.1),
        ("bare tree", read("kaykit_Tree_Bare_1_C_Color1.obj"), 0.5),
    ] {
        let [straight, leaning] = [
            ["splinter_lean=0", "splinter_snap=0"],
            ["splinter_lean=8", "splinter_snap=0.3"],
        ]
        .map(|[lean, snap]| broken(scene.clone(), at, &["fuzz=0", lean, snap]));
        let splinters: usize = leans(&leaning).iter().map(|l| l.splinters).sum();
        assert!(splinters > 20, "{name}: {splinters}");
        for i in 0..2 {
            let [before, after] = [&straight, &leaning].map(|b| &b.scene.nodes[i].mesh);
            let [was, is] = [before, after].map(|mesh| mesh.check_with(CheckOptions::default()));
            assert_eq!(
                (is.closed, is.oriented),
                (was.closed, was.oriented),
                "{name}: {is}"
            );
            let crossings = |r: &greenstick::geometry::Report| {
                r.self_intersections.as_ref().map_or(0, |s| s.crossing)
            };
            assert!(crossings(&is) <= crossings(&was), "{name}: {is}");
            let change = after.volume() / before.volume() - 1.0;
            assert!(change.abs() < 1e-3, "{name}: {change}");
            let report = &leaning.report.pieces[i];
            let told = report.lean.unwrap().straight_volume_m3;
            if let (Some(told), Some(true_volume)) = (told, straight.report.pieces[i].volume_m3) {
                assert!((told / true_volume - 1.0).abs() < 1e-6, "{name}: {told}");
            }
        }
    }
}

/// Where vertices of a face have gone, by their grain coordinates as files have them: way in the section (m) and height (m).
fn ways(straight: &Broken, leaning: &Broken, node: usize) -> Vec<(DVec2, f64)> {
    let stem = &straight.woods[0].stem;
    let frame = stem.grain.axis().frame(stem.location);
    let material = straight.woods[0].material;
    let places = |broken: &Broken| {
        let mesh = &broken.scene.nodes[node].mesh;
        let grain = &mesh.attributes["_GRAIN"];
        let mut places: HashMap<[u32; 3], DVec3> = HashMap::new();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for &v in corners.iter().filter(|_| mesh.material(t) == material) {
                let g = grain.at(v as usize);
                let key = [g[0], g[1], g[2]].map(f32::to_bits);
                places.insert(key, mesh.positions[v as usize]);
            }
        }
        places
    };
    let (from, to) = (places(straight), places(leaning));
    let mut ways: Vec<(DVec2, f64)> = (from.iter())
        .filter_map(|(key, from)| {
            let way = *to.get(key)? - *from;
            let along = way.dot(frame.tangent);
            assert!(along.abs() < 1e-6, "{along} of {way} at {from}");
            let height = f64::from(f32::from_bits(key[2])) - stem.location;
            Some((DVec2::new(way.dot(frame.x), way.dot(frame.y)), height))
        })
        .collect();
    ways.sort_by(|a, b| a.1.total_cmp(&b.1));
    ways
}

#[test]
fn splinters_lean_to_all_sides_as_much_as_asked_for() {
    let branch = built_in_branch();
    let none = ["fuzz=0", "splinter_lean=0", "splinter_snap=0"];
    let straight = broken(branch.clone(), 0.5, &none);
    assert!(straight.report.pieces.iter().all(|p| p.lean.is_none()));
    let volumes = straight.report.pieces.iter().map(|p| p.volume_m3.unwrap());
    let whole = straight.report.input.volume_m3.unwrap();
    assert!((volumes.sum::<f64>() / whole - 1.0).abs() < 1e-6);
    let mut means = Vec::new();
    for degrees in [3.0, 6.0, 9.0] {
        let lean = format!("splinter_lean={degrees}");
        let leaning = broken(branch.clone(), 0.5, &["fuzz=0", &lean, "splinter_snap=0"]);
        for (i, report) in leans(&leaning).into_iter().enumerate() {
            // Of those that lean, most are thin enough to lean as much as they are to.
            let mean = report.mean_degrees / degrees;
            assert!((0.55..1.1).contains(&mean), "{degrees}: {mean}");
            let steepest = 3.2 * degrees.to_radians().tan();
            let greatest = report.greatest_degrees.to_radians().tan();
            assert!(greatest <= steepest + 1e-9, "{}", report.greatest_degrees);
            assert!(report.straight * 4 < report.splinters, "{report:?}");
            means.push(report.mean_degrees);
            // What has moved, seen from outside: no farther than the steepest splinter would take it from the lowest point.
            let ways = ways(&straight, &leaning, i);
            let sign = if i == 0 { 1.0 } else { -1.0 };
            let foot = if i == 0 {
                ways[0].1
            } else {
                ways[ways.len() - 1].1
            };
            let mut moved = Vec::new();
            for (way, height) in &ways {
                let over = sign * (height - foot);
                assert!(way.length() <= steepest * over + 1e-6, "{way} at {over}");
                if way.length() > 3e-5 * degrees {
                    moved.push(way.normalize());
                }
            }
            assert!(moved.len() > 500, "{} of {}", moved.len(), ways.len());
            // To all sides: some to each of the four quarters.
            for quarter in 0..4 {
                let side = DVec2::from_angle(f64::from(quarter) * std::f64::consts::FRAC_PI_2);
                let share = moved.iter().filter(|way| way.dot(side) > 0.7).count();
                assert!(
                    share * 33 > moved.len(),
                    "{quarter}: {share} of {}",
                    moved.len()
                );
            }
        }
    }
    // Three times the lean, three times the angle, but for splinters that then would cross.
    for i in 0..2 {
        let ratio = means[4 + i] / means[i];
        assert!((2.0..3.3).contains(&ratio), "{ratio}");
    }
}

/// Ring coordinate beyond which there is no wood.
const BARK: f32 = 0.93;

/// How far the sides of splinters lie off the grain, below the highest tenth of them and in it: mean angles, degrees, by the area of
/// the broken face that is steep.
fn slopes(broken: &Broken, node: usize) -> [f64; 2] {
    let stem = &broken.woods[0].stem;
    let frame = stem.grain.axis().frame(stem.location);
    let mesh = &broken.scene.nodes[node].mesh;
    let inner = (0..mesh.triangles.len()).filter(|&t| mesh.material(t) == broken.woods[0].material);
    let ring = &mesh.attributes["_RING"];
    let mut sides: Vec<(f64, f64, f64)> = inner
        .filter_map(|t| {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a).cross(c - a);
            let area = normal.length();
            // Sides of splinters, not their torn ends, nor those of bark, which are slanted.
            let along = normal.normalize_or_zero().dot(frame.tangent).abs();
            let height = ((a + b + c) / 3.0 - frame.origin).dot(frame.tangent);
            let is_wood = mesh.triangles[t]
                .iter()
                .all(|&v| ring.at(v as usize)[0] < BARK);
            (area > 0.0 && along < 0.6 && is_wood).then_some((
                height,
                area,
                along.asin().to_degrees(),
            ))
        })
        .collect();
    sides.sort_by(|a, b| a.0.total_cmp(&b.0));
    if node == 1 {
        sides.reverse();
    }
    let (foot, tips) = sides.split_at(sides.len() * 9 / 10);
    [foot, tips].map(|half| {
        let area: f64 = half.iter().map(|s| s.1).sum();
        half.iter().map(|s| s.1 * s.2).sum::<f64>() / area
    })
}

/// Splinters of halves that were moved apart are no parallel columns: their sides lie off the grain to the one side and to the
/// other, and more so towards the tips. Some of those of a splintered break have snapped. Halves that lie in each other fit.
#[test]
fn splinters_of_halves_moved_apart_are_not_parallel_and_lean_more_towards_their_tips() {
    let branch = built_in_branch();
    // Means over breaks, as the tips of one are few.
    let seeds = ["seed=1", "seed=2", "seed=3", "seed=4"];
    let mut added = [[0.0; 2]; 2];
    for seed in seeds {
        let made = moved_apart(branch.clone(), 0.5, 0.1, &["fuzz=0", seed]);
        let straight = broken(branch.clone(), 0.5, &["fuzz=0", seed]);
        assert!(straight.report.pieces.iter().all(|p| p.lean.is_none()));
        for (node, added) in added.iter_mut().enumerate() {
            let (after, before) = (slopes(&made, node), slopes(&straight, node));
            for k in 0..2 {
                added[k] += (after[k] - before[k]) / seeds.len() as f64;
            }
        }
    }
    for [foot, tips] in added {
        assert!(tips > 1.0, "{tips}");
        assert!(tips > 1.5 * foot, "{foot} {tips}");
    }
    let mut snapped = 0;
    for seed in ["seed=1", "seed=2"] {
        let settings = ["fuzz=0", "slab_height=1.4", "splinter_snap=0.5", seed];
        let made = moved_apart(branch.clone(), 0.5, 0.1, &settings);
        snapped += leans(&made).iter().map(|lean| lean.snapped).sum::<usize>();
    }
    assert!(snapped >= 4, "{snapped}");
}
