//! Faces on a branch with furrowed bark: whole bark; and of the published smooth ones thorns inside it, and heights as reported.

use crate::support;
use glam::DVec3;
use greenstick::fracture::presets::PRESETS;
use greenstick::fracture::recipe::{apply_preset, apply_setting};
use greenstick::geometry::{Context, Mesh, Scene};
use greenstick::session::Broken;
use greenstick::wood::branch::branch_scene;
use greenstick::wood::primitive::BranchOptions;
use greenstick::{BreakRequest, break_scene, built_in_branch};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// A branch with few triangles.
fn branch() -> &'static Scene {
    static BRANCH: OnceLock<Scene> = OnceLock::new();
    BRANCH.get_or_init(|| {
        branch_scene(&BranchOptions {
            around: 40,
            ..BranchOptions::default()
        })
    })
}

/// Requests of all presets of a broken face; fewer rings and sectors keep the test quick.
fn requests() -> Vec<(&'static str, BreakRequest)> {
    let faces = PRESETS.iter().filter(|p| !p.is_cracks());
    let request = |name| {
        let mut request = support::request(0.5, &Default::default());
        request.texture_width = 8;
        let recipe = &mut request.breaks[0].recipe;
        apply_preset(recipe, name).unwrap();
        for (key, most) in [("rings", 40), ("sectors", 50)] {
            let value = if key == "rings" {
                recipe.face.rings
            } else {
                recipe.face.sectors
            };
            apply_setting(recipe, &format!("{key}={}", value.min(most))).unwrap();
        }
        recipe.complete().unwrap();
        request
    };
    faces.map(|p| (p.name, request(p.name))).collect()
}

fn broken(request: &BreakRequest) -> Broken {
    break_scene(branch().clone(), request, &Context::quiet()).unwrap()
}

/// Vertices by their position.
fn points(mesh: &Mesh) -> Vec<usize> {
    let mut known = BTreeMap::new();
    let point = |p: &DVec3| {
        let next = known.len();
        *known.entry(p.to_array().map(f64::to_bits)).or_insert(next)
    };
    mesh.positions.iter().map(point).collect()
}

/// The lines in which the broken face, of material `inner`, meets the skin.
fn outlines(mesh: &Mesh, inner: u32) -> usize {
    let points = points(mesh);
    let edges = |inside: bool| -> BTreeSet<(usize, usize)> {
        let own = (0..mesh.triangles.len()).filter(|&t| (mesh.material(t) == inner) == inside);
        own.flat_map(|t| {
            let [a, b, c] = mesh.triangles[t].map(|v| points[v as usize]);
            [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b)))
        })
        .collect()
    };
    let mut neighbours: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &(a, b) in edges(true).intersection(&edges(false)) {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    }
    let (mut count, mut seen) = (0, BTreeSet::new());
    for &start in neighbours.keys() {
        let mut open = vec![start];
        count += usize::from(!seen.contains(&start));
        while let Some(point) = open.pop() {
            if seen.insert(point) {
                open.extend(&neighbours[&point]);
            }
        }
    }
    count
}

/// Returns the solid angle of a mesh seen from a point, in full spheres: 1 within, 0 outside (van Oosterom and Strackee 1983).
fn winding(mesh: &Mesh, p: DVec3) -> f64 {
    let angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|q| q - p);
        let lengths = [a, b, c].map(DVec3::length);
        let below = lengths[0] * lengths[1] * lengths[2]
            + a.dot(b) * lengths[2]
            + b.dot(c) * lengths[0]
            + c.dot(a) * lengths[1];
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[test]
fn presets_are_sound_and_reach_as_far_as_they_report() {
    requests().par_iter().for_each(|(name, request)| {
        let broken = broken(request);
        let report = &broken.report;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for node in &broken.scene.nodes[..2] {
            let what = format!("{name}, {}", node.name);
            let check = node.mesh.check();
            assert!(check.closed && check.oriented, "{what}: {check}");
            let crossing = check.self_intersections.map_or(0, |s| s.crossing);
            assert_eq!(crossing, 0, "{what}: pairs cross");
            let inner = broken.woods[0].material;
            let grain = &node.mesh.attributes["_GRAIN"];
            let face = (0..node.mesh.triangles.len()).filter(|&t| node.mesh.material(t) == inner);
            for v in face.flat_map(|t| node.mesh.triangles[t]) {
                let height = f64::from(grain.at(v as usize)[2]) - report.place.length_m;
                range = [range[0].min(height), range[1].max(height)];
            }
        }
        for (found, reported) in range.iter().zip(report.face.range_m) {
            let off = (found - reported).abs();
            assert!(off < 1e-6, "{name}: {range:?} of {:?}", report.face.range_m);
        }
    });
}

#[test]
fn smooth_faces_leave_no_holes_in_the_bark_and_stay_inside_it() {
    let whole = &branch().nodes[0].mesh;
    requests().par_iter().for_each(|(name, request)| {
        if !name.starts_with("fig") {
            return;
        }
        let broken = broken(request);
        let inner = broken.woods[0].material;
        for node in &broken.scene.nodes[..2] {
            let mesh = &node.mesh;
            assert_eq!(outlines(mesh, inner), 1, "{name}, {}", node.name);
            // The middles of triangles, as vertices on the skin are neither in nor out; a few hundred tell enough.
            let face = (0..mesh.triangles.len()).filter(|&t| mesh.material(t) == inner);
            let face: Vec<usize> = face.collect();
            for &t in face.iter().step_by(face.len() / 300 + 1) {
                let inside = winding(whole, mesh.corners(t).iter().sum::<DVec3>() / 3.0);
                assert!(
                    inside > 0.5,
                    "{name}, {}: triangle {t} has {inside}",
                    node.name
                );
            }
        }
    });
}

/// Fig. 17's thorns are as many as its probability calls for, but where they would pierce the bark.
#[test]
fn thorns_are_counted() {
    let requests = requests();
    let (_, request) = requests.iter().find(|(name, _)| *name == "fig17").unwrap();
    let count = broken(request).report.face.thorns as f64;
    // 0.1 of the cells of 0.6 of 40 rings and 150 of 360° of 50 sectors.
    assert!((count - 50.0).abs() < 3.0 * 50f64.sqrt(), "{count}");
}

#[test]
fn fibrous_faces_leave_no_wood_bare_in_furrows_and_no_bark_on_splinters() {
    let cases = [
        "simple-tension",
        "splintering-tension",
        "twist",
        "green-stick",
    ];
    let cases = cases.into_iter().flat_map(|name| [(name, 1), (name, 3)]);
    cases
        .collect::<Vec<_>>()
        .into_par_iter()
        .for_each(|(name, seed)| {
            let mut request = support::request(0.5, &Default::default());
            request.texture_width = 8;
            let recipe = &mut request.breaks[0].recipe;
            apply_preset(recipe, name).unwrap();
            apply_setting(recipe, &format!("seed={seed}")).unwrap();
            recipe.complete().unwrap();
            let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
            for node in &broken.scene.nodes[..2] {
                let outlines = outlines(&node.mesh, broken.woods[0].material);
                assert_eq!(outlines, 1, "{name}, seed {seed}, {}", node.name);
            }
        });
}
