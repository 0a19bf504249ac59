//! Rods and bundles against closed forms of mechanics.

use crate::support;
use crate::support::{bond_all, straight};
use glam::DVec3;
use greenstick_fibre::{
    Clamp, Explicit, Motion, NoContacts, PointForce, Ramp, Rod, RodBundle, RodMaterial, Solver,
    World,
};
use greenstick_geometry::Context;
use std::f64::consts::PI;

/// A rod 40 times as stiff in stretch as its bending needs: nearly inextensible, at a step that is not small.
fn rod(length: f64, edges: usize) -> (Rod, RodMaterial) {
    let bend = 1e-3;
    let material = RodMaterial {
        line_density: 0.05,
        stretch: 4e4 * bend / (length * length),
        bend,
        twist: bend,
        ..RodMaterial::solid(1e-5, 1e7, 1e6, 600.0)
    };
    (straight(DVec3::ZERO, length, edges, material), material)
}

/// Lets a world come to rest with heavy damping.
fn come_to_rest(world: &mut World, damping: f64, time: f64) {
    world.loads.damping = damping;
    Explicit::new(None)
        .advance(world, &mut NoContacts, time, &Context::quiet())
        .unwrap();
}

/// Returns the tip (x, z) of an inextensible cantilever along z under a tip force f across it, by shooting with Runge–Kutta
/// steps.
fn elastica(bend: f64, length: f64, force: f64) -> (f64, f64) {
    let shoot = |moment: f64| {
        let n = 4000;
        let h = length / f64::from(n);
        let (mut x, mut z, mut angle, mut k) = (0.0, 0.0, 0.0f64, moment / bend);
        for _ in 0..n {
            let rate = |a: f64| -force * a.cos() / bend;
            let (k1, l1) = (k, rate(angle));
            let (k2, l2) = (k + 0.5 * h * l1, rate(angle + 0.5 * h * k1));
            let (k3, l3) = (k + 0.5 * h * l2, rate(angle + 0.5 * h * k2));
            let (k4, l4) = (k + h * l3, rate(angle + h * k3));
            let next = angle + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            let middle = angle + 0.5 * h * k1;
            x += h / 6.0 * (angle.sin() + 4.0 * middle.sin() + next.sin());
            z += h / 6.0 * (angle.cos() + 4.0 * middle.cos() + next.cos());
            k += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
            angle = next;
        }
        (k, x, z)
    };
    let (mut low, mut high) = (0.0, force * length);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle).0 > 0.0 {
            high = middle
        } else {
            low = middle
        }
    }
    let (_, x, z) = shoot(low);
    (x, z)
}

/// Returns the tip of a cantilever under a tip force. Its clamp holds the first edge; bending is distributed over the half
/// edges about vertices, so that the free length begins at the middle of that edge.
fn cantilever(edges: usize, force: f64, twisting: bool) -> DVec3 {
    let (rod, _) = rod(1.0, edges);
    let mut world = World::new(RodBundle::new(&[rod], twisting).unwrap());
    world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed)];
    world.loads.forces = vec![PointForce {
        vertex: edges as u32,
        force: DVec3::X * force,
        ramp: Ramp::Constant,
    }];
    come_to_rest(&mut world, 1.4, 25.0);
    world.state.position.get(edges)
}

#[test]
fn a_cantilever_bends_as_the_elastica() {
    let half = |n: usize| 0.5 / n as f64;
    // P L²/α = 4: the tip leans far over.
    let (force, mut errors) = (4e-3, Vec::new());
    for (edges, twisting) in [(10, false), (20, false), (40, false), (20, true)] {
        let (x, z) = elastica(1e-3, 1.0 - half(edges), force);
        let tip = cantilever(edges, force, twisting);
        let error = ((tip.x - x).powi(2) + (tip.z - half(edges) - z).powi(2)).sqrt() / x;
        println!(
            "{edges} edges, twist {twisting}: tip {tip}, elastica ({x}, {z}), off by {:.3} %",
            100.0 * error
        );
        errors.push(error);
    }
    assert!(errors[2] < 5e-3 && errors[3] < 5e-3, "{errors:?}");
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}

/// Returns the square of the frequency (1/s²) of the first mode, from the motion of a rod that is released at rest: positive
/// where it swings back, negative where its deflection grows.
fn squared_frequency(mut world: World, time: f64) -> f64 {
    let rest = world.bundle.rest.x.clone();
    let shape: Vec<f64> = world
        .state
        .position
        .x
        .iter()
        .zip(&rest)
        .map(|(x, r)| x - r)
        .collect();
    let amplitude = |w: &World| -> f64 {
        let b = &w.bundle;
        (0..b.vertices())
            .map(|i| b.mass[i] * (w.state.position.x[i] - rest[i]) * shape[i])
            .sum()
    };
    let start = amplitude(&world);
    Explicit::new(None)
        .advance(&mut world, &mut NoContacts, time, &Context::quiet())
        .unwrap();
    let ratio = amplitude(&world) / start;
    // cos(ωt) or cosh(ωt) of a pure mode.
    if ratio <= 1.0 {
        (ratio.acos() / time).powi(2)
    } else {
        -(ratio.acosh() / time).powi(2)
    }
}

#[test]
fn first_frequencies_are_those_of_beams() {
    let edges = 40;
    let (made, material) = rod(1.0, edges);
    let bundle = RodBundle::new(&[made], false).unwrap();
    // Clamped and free, from the half edge that the clamp leaves free; free and free.
    let beam = |k: f64, l: f64| (k / l).powi(4) * material.bend / material.line_density;
    let shape = |k: f64, s: f64, sign: f64| {
        let r = if sign < 0.0 {
            (k.cosh() + k.cos()) / (k.sinh() + k.sin())
        } else {
            (k.cosh() - k.cos()) / (k.sinh() - k.sin())
        };
        let (a, b) = (
            (k * s).cosh() + sign * (k * s).cos(),
            (k * s).sinh() + sign * (k * s).sin(),
        );
        a - r * b
    };
    let half = 0.5 / edges as f64;
    for (k, offset, sign) in [(1.875_104_068_7, half, -1.0), (4.730_040_745, 0.0, 1.0)] {
        let mut world = World::new(bundle.clone());
        for i in 0..=edges {
            let s = ((i as f64 / edges as f64 - offset) / (1.0 - offset)).max(0.0);
            let held = sign < 0.0 && i < 2;
            world.state.position.x[i] = if held { 0.0 } else { 1e-4 * shape(k, s, sign) };
        }
        if sign < 0.0 {
            world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed)];
        }
        let exact = beam(k, 1.0 - offset);
        let got = squared_frequency(world, 1.0 / exact.sqrt());
        let off = (got / exact).sqrt() - 1.0;
        println!(
            "mode {k}: {} Hz, beam {} Hz, off by {:.3} %",
            got.sqrt() / 2.0 / PI,
            exact.sqrt() / 2.0 / PI,
            100.0 * off
        );
        assert!(off.abs() < 0.01);
    }
}

#[test]
fn a_pinned_strut_buckles_at_eulers_load() {
    let edges = 40;
    let (made, material) = rod(1.0, edges);
    let bundle = RodBundle::new(&[made], false).unwrap();
    let euler = PI * PI * material.bend;
    // The squared frequency falls linearly with the load, to 0 at the critical load.
    let at = |load: f64| {
        let mut world = World::new(bundle.clone());
        let strain = -load / material.stretch;
        for i in 0..=edges {
            let s = i as f64 / edges as f64;
            world.state.position.x[i] = 1e-5 * (PI * s).sin();
            world.state.position.z[i] = s * (1.0 + strain);
        }
        let mut ends = [0, edges as u32].map(|v| Clamp::new(&world.bundle, vec![v], Motion::Fixed));
        ends[0].axes = [true, true, true];
        ends[1].axes = [true, true, false];
        world.loads.clamps = ends.into();
        world.loads.forces = vec![PointForce {
            vertex: edges as u32,
            force: DVec3::Z * -load,
            ramp: Ramp::Constant,
        }];
        squared_frequency(world, 0.5)
    };
    let (low, high) = (0.9 * euler, 1.1 * euler);
    let (a, b) = (at(low), at(high));
    let critical = low + (high - low) * a / (a - b);
    println!(
        "buckles at {critical} N, Euler {euler} N: off by {:.3} %",
        100.0 * (critical / euler - 1.0)
    );
    assert!(a > 0.0 && b < 0.0 && (critical / euler - 1.0).abs() < 0.02);
}

/// Returns the bending stiffness over E h⁴/12, from the frequency, of a free beam of 4 × 4 rods, 5 mm apart, staggered by half
/// an edge, with bonds between side neighbours for a shear modulus of `ratio` times E.
fn bonded_beam(ratio: f64) -> f64 {
    let (young, a, length, edges) = (1e7, 5e-3, 0.6, 240);
    let material = RodMaterial::solid(a * a, young, ratio * young, 600.0);
    let step = length / edges as f64;
    let rods: Vec<Rod> = (0..16)
        .map(|r| {
            let corner = DVec3::new((r % 4) as f64, (r / 4) as f64, 0.0) * a;
            let mut rod = straight(corner, length, edges, material);
            if (r % 4 + r / 4) % 2 == 1 {
                let end = rod.vertices[edges];
                rod.vertices.pop();
                rod.vertices
                    .iter_mut()
                    .skip(1)
                    .for_each(|v| v.z -= 0.5 * step);
                rod.vertices.push(end - DVec3::Z * (0.5 * step));
                rod.vertices.push(end);
            }
            rod
        })
        .collect();
    let mut bundle = RodBundle::new(&rods, false).unwrap();
    // Each of the two rods of a facet has half of it.
    let facet = 0.5 * a * step;
    bond_all(
        &mut bundle,
        1.2 * a,
        young / 20.0 * facet,
        0.5 * ratio * young * facet * a,
    );
    let mut world = World::new(bundle);
    let k: f64 = 4.730_040_745;
    let r = (k.cosh() - k.cos()) / (k.sinh() - k.sin());
    let depth = |y: f64| y - 1.5 * a;
    for i in 0..world.bundle.vertices() {
        let p = world.bundle.rest.get(i);
        let u = k * p.z / length;
        let slope = 1e-4 * k / length * (u.sinh() - u.sin() - r * (u.cosh() + u.cos()));
        world.state.position.x[i] += 1e-4 * (u.cosh() + u.cos() - r * (u.sinh() + u.sin()));
        // Plane sections, where the rods are held together at all.
        world.state.position.z[i] -= if ratio > 0.0 { slope * depth(p.x) } else { 0.0 };
    }
    let height = 4.0 * a;
    let solid = young * height.powi(4) / 12.0 / (600.0 * height * height) * (k / length).powi(4);
    squared_frequency(world, 0.3 / solid.sqrt()) / solid
}

#[test]
fn a_bonded_bundle_lies_between_layers_and_the_solid_beam() {
    let ratios = [0.0, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];
    let made = ratios.map(bonded_beam);
    for (g, s) in ratios.iter().zip(made) {
        println!("G/E {g}: {s:.4} of the solid beam's stiffness");
    }
    // Sixteen round rods of the same area, each by itself.
    let layers = 16.0 * (12.0 / (4.0 * PI)) / 256.0;
    assert!(
        (made[0] / layers - 1.0).abs() < 0.01,
        "{} {layers}",
        made[0]
    );
    assert!(made.windows(2).all(|p| p[0] < p[1]), "{made:?}");
    assert!((made[5] - 1.0).abs() < 0.03 && made[5] < 1.01, "{made:?}");
}

/// Returns the ratio of late to early out-of-plane deflection of a closed ring whose ends are twisted by `turns` times
/// Michell's critical twist.
fn twisted_ring(turns: f64) -> f64 {
    let edges = 60;
    let (bend, twist) = (1e-3, 0.8e-3);
    let material = RodMaterial {
        twist,
        bend,
        stretch: 4e1,
        line_density: 0.05,
        ..rod(1.0, 2).1
    };
    // The last edge lies on the first.
    let step = 1.0 / edges as f64;
    let vertices = (0..=edges + 1)
        .map(|i| DVec3::Z * (i as f64 * step))
        .collect();
    let mut made = Rod::new(vertices, material);
    made.director = Some(DVec3::Y);
    let mut world = World::new(RodBundle::new(&[made], true).unwrap());
    let radius = 0.5 * step / (PI * step).sin();
    for i in 0..=edges + 1 {
        let a = 2.0 * PI * i as f64 * step;
        let free = i > 1 && i < edges;
        let bow = if free {
            1e-6 * (2.0 * a).sin() + 1e-6 * support::random(3, i)
        } else {
            0.0
        };
        world
            .state
            .position
            .set(i, DVec3::new(radius * a.sin(), bow, radius * a.cos()));
    }
    world.state.transport_frames(&world.bundle);
    let total = turns * 2.0 * PI * 3.0f64.sqrt() * bend / twist;
    let ends = [0, edges];
    for (k, j) in ends.into_iter().enumerate() {
        let mut clamp = Clamp::new(&world.bundle, vec![j as u32, j as u32 + 1], Motion::Fixed);
        clamp.rest_positions = [j, j + 1].map(|v| world.state.position.get(v)).into();
        let tangent = world.state.edge(j).normalize();
        clamp.directors = vec![greenstick_fibre::material_frame::rotate_director(
            DVec3::Y,
            tangent,
            total * k as f64,
        )];
        world.loads.clamps.push(clamp);
    }
    for j in 0..=edges {
        world.state.angle[j] = total * j as f64 * step;
    }
    world.loads.damping = 0.5;
    let mut solver = Explicit::new(None);
    let mut size = |time: f64| {
        solver
            .advance(&mut world, &mut NoContacts, time, &Context::quiet())
            .unwrap();
        world
            .state
            .position
            .y
            .iter()
            .map(|y| y * y)
            .sum::<f64>()
            .sqrt()
    };
    let (early, late) = (size(1.0), size(3.0));
    late / early
}

#[test]
fn a_twisted_ring_leaves_its_plane_at_michells_twist() {
    let (below, above) = (twisted_ring(0.95), twisted_ring(1.05));
    println!(
        "out of plane in 3 s: times {below} at 95 %, times {above} at 105 % of Michell's twist"
    );
    assert!(below < 2.0 && above > 20.0);
}
