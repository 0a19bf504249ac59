//! Pieces that `separation` moves apart.

use glam::{DAffine3, DVec2, DVec3};
use greenstick::geometry::{Aabb, Bvh, Context, Mesh, Node, Scene};
use greenstick::wood::primitive;
use greenstick::{Break, BreakRequest, Broken, break_scene};

/// A limb 4 cm thick that is bent to an arc of 35 cm radius.
fn bent_limb() -> Scene {
    const RADIUS: f64 = 0.35;
    let mut mesh = primitive::cylinder_of(0.02, 0.5, 48, 60);
    for p in &mut mesh.positions {
        let (sin, cos) = libm::sincos(p.y / RADIUS);
        *p = DVec3::new((RADIUS + p.x) * cos - RADIUS, (RADIUS + p.x) * sin, p.z);
    }
    Scene {
        nodes: vec![Node::new("limb", DAffine3::IDENTITY, mesh)],
        ..Scene::default()
    }
}

/// A closed mesh that is asked where lines along x are in it.
struct Solid {
    corners: Vec<[DVec3; 3]>,
    tree: Bvh,
}

impl Solid {
    fn new(mesh: &Mesh, transform: DAffine3) -> Self {
        let corners: Vec<[DVec3; 3]> = (0..mesh.triangles.len())
            .map(|t| mesh.corners(t).map(|p| transform.transform_point3(p)))
            .collect();
        let boxes: Vec<Aabb> = corners.iter().map(|c| Aabb::around(c)).collect();
        let tree = Bvh::new(&boxes);
        Solid { corners, tree }
    }

    /// Where the line along x through a point of the plane across it passes the surface, ascending.
    fn crossings(&self, at: DVec2) -> Vec<f64> {
        let meets =
            |b: &Aabb| (b.low.y..=b.high.y).contains(&at.x) && (b.low.z..=b.high.z).contains(&at.y);
        let mut crossings = Vec::new();
        self.tree.visit(meets, |t| {
            let [a, b, c] = self.corners[t].map(|q| DVec2::new(q.y, q.z) - at);
            let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
            if areas.iter().all(|&w| w > 0.0) || areas.iter().all(|&w| w < 0.0) {
                let x = (0..3).map(|i| areas[i] * self.corners[t][i].x).sum::<f64>();
                crossings.push(x / areas.iter().sum::<f64>());
            }
        });
        crossings.sort_by(f64::total_cmp);
        crossings
    }
}

/// Volume that two solids share, m³, by points on a grid of half a millimetre.
fn shared(a: &Solid, b: &Solid) -> f64 {
    const STEP: f64 = 5e-4;
    let both = a.tree.bounds().intersection(&b.tree.bounds());
    let count = ((both.high - both.low) / STEP).max(DVec3::ZERO).as_uvec3();
    // Off the middle, so that no line runs along an edge of the mesh.
    let at = |low: f64, i: u32| low + (f64::from(i) + 0.437) * STEP;
    let mut found = 0;
    for (j, k) in (0..count.y).flat_map(|j| (0..count.z).map(move |k| (j, k))) {
        let line = DVec2::new(at(both.low.y, j), at(both.low.z, k));
        let crossings = [a, b].map(|solid| solid.crossings(line));
        let is_within =
            |x: f64| (crossings.iter()).all(|c| c.partition_point(|&c| c <= x) % 2 == 1);
        found += (0..count.x)
            .filter(|&i| is_within(at(both.low.x, i)))
            .count();
    }
    found as f64 * STEP.powi(3)
}

/// Long splinters, whatever the seed makes of them, that fit.
fn long_splinters() -> Break {
    let mut one = Break::default();
    let face = &mut one.recipe.face;
    (face.slab_height, face.slab_count) = (4.0, 12);
    (face.splinter_lean, face.splinter_snap) = (Some(0.0), Some(0.0));
    one
}

fn broken(scene: Scene, one: Break) -> Broken {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(one)
    };
    break_scene(scene, &request, &Context::quiet()).unwrap()
}

/// The lower piece of a break, and the upper one.
fn halves(broken: &Broken) -> [&Node; 2] {
    let [lower, upper] = &broken.scene.nodes[..2] else {
        panic!("two pieces");
    };
    [lower, upper]
}

/// Volume that the halves of a break share, m³.
fn shared_by(broken: &Broken) -> f64 {
    let [lower, upper] = halves(broken).map(|node| Solid::new(&node.mesh, node.transform));
    shared(&lower, &upper)
}

/// Pairs of triangles, one of each half of a break, that cross.
fn crossings_between(broken: &Broken) -> usize {
    let mut both = Mesh::default();
    let mut own = 0;
    let crossing = |mesh: &Mesh| mesh.check().self_intersections.map_or(0, |s| s.crossing);
    for node in halves(broken) {
        let first = both.positions.len() as u32;
        own += crossing(&node.mesh);
        let places = node.mesh.positions.iter();
        (both.positions).extend(places.map(|&p| node.transform.transform_point3(p)));
        let triangles = node.mesh.triangles.iter();
        (both.triangles).extend(triangles.map(|t| t.map(|v| v + first)));
    }
    crossing(&both) - own
}

/// Volume that the halves would share if the upper one had been moved straight by a way.
fn shared_if_moved(broken: &Broken, way: DVec3) -> f64 {
    let [lower, upper] = halves(broken);
    let moved = DAffine3::from_translation(way) * lower.transform;
    let fixed = Solid::new(&lower.mesh, lower.transform);
    shared(&fixed, &Solid::new(&upper.mesh, moved))
}

/// The ways (m) of pieces that were moved farther than requested, as the report says.
fn ways(broken: &Broken) -> Vec<f64> {
    let way = |note: &String| {
        let cm = note.strip_prefix("the pieces were moved apart by ")?;
        cm.split_once(" cm")?.0.parse::<f64>().ok()
    };
    let cm = broken.report.notes.iter().filter_map(way);
    cm.map(|cm| cm / 100.0).collect()
}

#[test]
fn halves_of_a_bent_limb_slide_out_of_each_other() {
    let request = Break {
        separation: 0.03,
        part_clear: false,
        ..long_splinters()
    };
    let (distance, made) = (request.separation, broken(bent_limb(), request));
    // Moved straight along the stem at the break, they overlap.
    let axis = made.woods[0].stem.grain.axis();
    let tangent = axis.frame(made.woods[0].stem.location).tangent;
    let before = shared_if_moved(&made, tangent * distance);
    let slid = shared_by(&made);
    assert!(before > 2e-7, "{before}");
    assert!(slid > 0.0 && slid < 0.3 * before, "{slid} of {before}");
}

#[test]
fn halves_of_a_bent_limb_are_moved_until_neither_lies_in_the_other() {
    let request = Break {
        separation: 0.03,
        ..long_splinters()
    };
    let made = broken(bent_limb(), request.clone());
    let [way] = ways(&made)[..] else {
        panic!("one way: {:?}", made.report);
    };
    assert!(way > request.separation);
    assert_eq!(shared_by(&made), 0.0);
    // On a way that is a little shorter, tips still reach into the other half, though a grid may miss them.
    let meet = |part: f64| {
        let shorter = Break {
            separation: part * way,
            part_clear: false,
            ..request.clone()
        };
        let made = broken(bent_limb(), shorter);
        crossings_between(&made) > 0
    };
    assert!([0.98, 0.95, 0.9].into_iter().any(meet));
}

#[test]
fn halves_with_spiral_grain_are_screwed_out_of_each_other() {
    let straight = || Scene {
        nodes: vec![Node::new(
            "stick",
            DAffine3::IDENTITY,
            primitive::cylinder_of(0.02, 0.5, 48, 60),
        )],
        ..Scene::default()
    };
    let mut request = Break {
        separation: 0.02,
        part_clear: false,
        ..long_splinters()
    };
    request.recipe.face.spiral_angle = 20.0;
    let made = broken(straight(), request);
    let (screwed, pulled) = (shared_by(&made), shared_if_moved(&made, DVec3::Y * 0.02));
    // Between levels walls are straight, so that they do not slide on each other quite.
    assert!(screwed < 0.1 * pulled, "{screwed} of {pulled}");
}
