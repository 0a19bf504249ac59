//! A dowel that tapers was turned from a board: it cuts through the rings of the tree, which do not shrink with it.

use crate::support::scene;
use glam::{DVec2, DVec3};
use greenstick::geometry::{Context, Mesh};
use greenstick::schema::Parameters;
use greenstick::wood::anatomy::AnatomyRequest;
use greenstick::wood::appearance::WoodAppearance;
use greenstick::wood::rings::StemAddress;
use greenstick::{BreakRequest, BreakSession, RequestFile};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Where the pith lies in the world, m, and the dowel's length and radii at both ends.
const PITH: DVec2 = DVec2::new(0.0, -0.08);
const LENGTH: f64 = 0.5;
const RADII: [f64; 2] = [0.03, 0.012];
/// Rings between the pith and the farthest point of the dowel, 5 mm wide.
const RINGS: u16 = 22;

fn radius(z: f64) -> f64 {
    RADII[0] + (RADII[1] - RADII[0]) * z / LENGTH
}

/// A cone along z.
fn cone() -> Mesh {
    const AROUND: u32 = 64;
    const ROWS: u32 = 40;
    let mut mesh = Mesh::default();
    for row in 0..=ROWS {
        let z = LENGTH * f64::from(row) / f64::from(ROWS);
        for k in 0..AROUND {
            let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(AROUND));
            let r = radius(z);
            mesh.positions.push(DVec3::new(r * cos, r * sin, z));
        }
    }
    for row in 0..ROWS {
        for k in 0..AROUND {
            let [a, b] = [AROUND * row + k, AROUND * row + (k + 1) % AROUND];
            let [c, d] = [a + AROUND, b + AROUND];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    for (row, turned) in [(0, true), (ROWS, false)] {
        let middle = mesh.positions.len() as u32;
        let z = LENGTH * f64::from(row) / f64::from(ROWS);
        mesh.positions.push(DVec3::new(0.0, 0.0, z));
        for k in 0..AROUND {
            let [a, b] = [AROUND * row + k, AROUND * row + (k + 1) % AROUND];
            mesh.triangles.push(if turned {
                [middle, b, a]
            } else {
                [middle, a, b]
            });
        }
    }
    mesh
}

/// A break at a fraction of the length; the pith is that of the board where it is given.
fn request(at: &str, pith: bool) -> BreakRequest {
    let mut file = RequestFile::default();
    let rings = format!("annual_rings={RINGS}");
    let at = format!("at={at}");
    // Rings are cones about the pith only where grain is straight.
    let straight = "slope_of_grain=0";
    let mut settings = vec![&*at, straight, "kind=dowel", "surface=fibrous", &*rings];
    let pith_at = format!("pith={},{},0.1", PITH.x, PITH.y);
    if pith {
        settings.push(&pith_at);
    }
    for setting in settings {
        file.apply_setting(setting).unwrap();
    }
    file.complete().unwrap();
    BreakRequest {
        texture_width: 64,
        ..file.request()
    }
}

#[test]
fn fewer_rings_are_cut_where_a_dowel_is_thinner() {
    let context = Context::quiet();
    let request = request("0.3", true);
    let scene = scene(cone(), 1.0);
    let mut session = BreakSession::new(scene.clone());
    let stage = session.stem(&request, &context).unwrap();
    let found = &stage.sound.found;
    let face = &request.breaks[0].recipe.face;
    let wood = WoodAppearance::of_stem(&found.stem, &face.proportions(), face.seed, None, 0.95);
    let mesh = &scene.world_meshes()[found.node];
    let mut wanted = AnatomyRequest::default();
    wanted.set_text("resolution", "64").unwrap();
    let anatomy = wanted
        .anatomy(found, mesh, wood, face.proportions(), &context)
        .unwrap();
    let outer = found.stem.rings.outer_radius(0.0);
    assert!((outer / (PITH.length() + RADII[0]) - 1.0).abs() < 2e-3);
    let width = outer / f64::from(RINGS);
    let mut counts = Vec::new();
    for length in [0.02, 0.2, 0.35, 0.48] {
        let section = anatomy.sections().section(length).unwrap();
        let at = |p: DVec2| {
            let d = p.extend(length) - section.frame.origin;
            DVec2::new(d.dot(section.frame.x), d.dot(section.frame.y))
        };
        let mut rings = BTreeSet::new();
        let r = 0.999 * radius(length);
        for k in 0..=400 {
            // Across the dowel, straight away from the pith.
            let y = r * (f64::from(k) / 200.0 - 1.0);
            let (rho, angle) = section.field.address(at(DVec2::new(0.0, y)));
            let from_pith = y - PITH.y;
            let off = rho * section.field.outer_radius(0.0) - from_pith;
            assert!(off.abs() < 3e-4, "{length} m, {y} m: {off}");
            let address = StemAddress {
                rho,
                angle,
                across: at(DVec2::new(0.0, y)) - section.field.pith(),
                along: length,
            };
            rings.insert(stage.rings.ring_at(&address).unwrap().ring);
        }
        // Whole and cut rings between the nearest and the farthest place, as far as rounding decides at these.
        let at_ring = |from_pith: f64| (from_pith / width).floor();
        let expected = at_ring(PITH.length() + r) - at_ring(PITH.length() - r) + 1.0;
        let cut = rings.len() as f64;
        assert!(
            (cut - expected).abs() <= 1.0,
            "{length} m: {cut} for {expected}"
        );
        counts.push(rings.len());
    }
    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    assert!(counts[0] >= counts[3] + 5, "{counts:?}");
}

#[test]
fn a_tapering_dowel_has_the_same_rings_wherever_it_breaks() {
    let scene = scene(cone(), 1.0);
    // The dowel's own pith, and that of the board.
    for pith in [false, true] {
        let mut seen: Vec<(f64, f64)> = Vec::new();
        for at in ["0.2", "0.5", "0.8"] {
            let request = request(at, pith);
            let mut session = BreakSession::new(scene.clone());
            let stage = session.stem(&request, &Context::quiet()).unwrap();
            let stem = &stage.sound.found.stem;
            let middle = stem.grain.to_world(stem.rings.pith().extend(stem.location));
            seen.push((middle.truncate().length(), stem.rings.outer_radius(0.0)));
            if pith {
                assert!(middle.truncate().distance(PITH) < 1e-4, "{at}: {middle}");
            }
            // The world's place of every vertex of the broken faces, and the ring that it shows.
            let broken = session.broken(&request, &Context::quiet()).unwrap();
            let mut compared = 0;
            for node in broken.scene.nodes.iter().filter(|n| !n.is_detail) {
                let mesh = &node.mesh;
                let rings = mesh.attributes.get("_RING").unwrap();
                for (t, corners) in mesh.triangles.iter().enumerate() {
                    let material = &broken.scene.materials[mesh.materials[t] as usize].name;
                    for &v in corners.iter().filter(|_| material == "inner_wood") {
                        let v = v as usize;
                        let world = node.transform.transform_point3(mesh.positions[v]);
                        let from_pith = world.truncate().distance(middle.truncate());
                        let shown = f64::from(rings.at(v)[0]) * stem.rings.outer_radius(0.0);
                        assert!((shown - from_pith).abs() < 3e-4, "{shown} {from_pith}");
                        compared += 1;
                    }
                }
            }
            assert!(compared > 500, "{compared}");
        }
        let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-3;
        assert!(
            seen.iter()
                .all(|s| same(s.0, seen[0].0) && same(s.1, seen[0].1)),
            "{seen:?}"
        );
    }
}
