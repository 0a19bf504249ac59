//! Pieces that `separation` moves apart.

use glam::{DAffine3, DVec2, DVec3};
use greenstick::geometry::{Aabb, Bvh, Context, Mesh, Node, Scene};
use greenstick::wood::primitive;
use greenstick::{Break, BreakRequest, break_scene};

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

/// A closed mesh that is asked where it is solid.
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

    /// Whether a ray along x leaves from inside.
    fn contains(&self, p: DVec3) -> bool {
        let meets = |b: &Aabb| {
            b.high.x >= p.x
                && (b.low.y..=b.high.y).contains(&p.y)
                && (b.low.z..=b.high.z).contains(&p.z)
        };
        let mut crossings = 0;
        self.tree.visit(meets, |t| {
            let [a, b, c] = self.corners[t].map(|q| DVec2::new(q.y - p.y, q.z - p.z));
            let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
            if areas.iter().all(|&w| w > 0.0) || areas.iter().all(|&w| w < 0.0) {
                let x = (0..3).map(|i| areas[i] * self.corners[t][i].x).sum::<f64>();
                crossings += usize::from(x / areas.iter().sum::<f64>() > p.x);
            }
        });
        crossings % 2 == 1
    }
}

/// Volume that two solids share, m³, by points on a grid of half a millimetre.
fn shared(a: &Solid, b: &Solid) -> f64 {
    const STEP: f64 = 5e-4;
    let both = a.tree.bounds().intersection(&b.tree.bounds());
    let count = ((both.high - both.low) / STEP).max(DVec3::ZERO).as_uvec3();
    let mut found = 0;
    for (i, j, k) in (0..count.x)
        .flat_map(|i| (0..count.y).flat_map(move |j| (0..count.z).map(move |k| (i, j, k))))
    {
        // Off the middle, so that no ray runs along an edge of the mesh.
        let p = both.low + (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.437) * STEP;
        found += usize::from(a.contains(p) && b.contains(p));
    }
    found as f64 * STEP.powi(3)
}

#[test]
fn halves_of_a_bent_limb_slide_out_of_each_other() {
    // Long splinters, whatever the seed makes of them.
    let request = |separation| {
        let mut one = Break {
            separation,
            ..Break::default()
        };
        let face = &mut one.recipe.face;
        (face.slab_height, face.slab_count) = (4.0, 12);
        (face.splinter_lean, face.splinter_snap) = (0.0, 0.0);
        BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(one)
        }
    };
    let quiet = Context::quiet();
    let distance = 0.03;
    let broken = break_scene(bent_limb(), &request(distance), &quiet).unwrap();
    let [lower, upper] = &broken.scene.nodes[..2] else {
        panic!("two pieces");
    };
    let fixed = Solid::new(&lower.mesh, lower.transform);
    let overlap = shared(&fixed, &Solid::new(&upper.mesh, upper.transform));
    // Moved straight along the stem at the break, they overlap.
    let tangent = broken.woods[0]
        .stem
        .grain
        .axis()
        .frame(broken.woods[0].stem.location)
        .tangent;
    let straight = DAffine3::from_translation(tangent * distance) * lower.transform;
    let before = shared(&fixed, &Solid::new(&upper.mesh, straight));
    assert!(before > 2e-7, "{before}");
    assert!(overlap < 0.1 * before, "{overlap} of {before}");
}
