//! Rods and bundles against closed forms of mechanics (`model.md` §5).

mod support;

use glam::DVec3;
use greenstick_fibre::{
    Bundle, Clamp, Explicit, Motion, NoContacts, PointForce, Ramp, Rod, RodMaterial, Solver, World,
};
use std::f64::consts::PI;
use support::straight;

/// A rod that is 40 times as stiff in stretch as its bending needs: nearly inextensible, at a step that is not small.
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

/// Lets a world come to rest: heavy damping, until it hardly moves.
fn settle(world: &mut World, damping: f64, time: f64) {
    world.loads.damping = damping;
    Explicit::new(None)
        .advance(world, &mut NoContacts, time)
        .unwrap();
}

/// Tip (x, z) of an inextensible cantilever along z under a tip force f across it, by shooting with Runge–Kutta steps.
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

/// Tip of a cantilever under a tip force. Its clamp holds the first edge; bending is spread over the half edges about
/// vertices, so the free length begins at the middle of that edge.
fn cantilever(edges: usize, force: f64, twisting: bool) -> DVec3 {
    let (rod, _) = rod(1.0, edges);
    let mut world = World::new(Bundle::new(&[rod], twisting).unwrap());
    world.loads.clamps = vec![Clamp::of(&world.bundle, vec![0, 1], Motion::Fixed)];
    world.loads.forces = vec![PointForce {
        vertex: edges as u32,
        force: DVec3::X * force,
        ramp: Ramp::Constant,
    }];
    settle(&mut world, 1.4, 25.0);
    world.state.position.get(edges)
}

#[test]
fn a_cantilever_bends_as_the_elastica() {
    let half = |n: usize| 0.5 / n as f64;
    // P L²/α = 4: the tip leans far over.
    let (force, mut misses) = (4e-3, Vec::new());
    for (edges, twisting) in [(10, false), (20, false), (40, false), (20, true)] {
        let (x, z) = elastica(1e-3, 1.0 - half(edges), force);
        let tip = cantilever(edges, force, twisting);
        let miss = ((tip.x - x).powi(2) + (tip.z - half(edges) - z).powi(2)).sqrt() / x;
        println!(
            "{edges} edges, twist {twisting}: tip {tip}, elastica ({x}, {z}), off by {:.3} %",
            100.0 * miss
        );
        misses.push(miss);
    }
    assert!(misses[2] < 5e-3 && misses[3] < 5e-3, "{misses:?}");
    assert!(misses[1] < 0.5 * misses[0], "{misses:?}");
}

/// Rate (1/s²) at which a small bow grows under a load, negative where it swings back: the square of the frequency of
/// the first mode, from the Rayleigh quotient along the motion of a rod let go at rest.
fn swing(mut world: World, time: f64) -> f64 {
    let shape: Vec<f64> = world.state.position.x.clone();
    let amplitude = |w: &World| -> f64 {
        let b = &w.bundle;
        (0..b.vertices())
            .map(|i| b.mass[i] * w.state.position.x[i] * shape[i])
            .sum()
    };
    let start = amplitude(&world);
    Explicit::new(None)
        .advance(&mut world, &mut NoContacts, time)
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
    let bundle = Bundle::new(&[made], false).unwrap();
    // Clamped and free, from the half edge that the clamp leaves; free and free.
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
            world.loads.clamps = vec![Clamp::of(&world.bundle, vec![0, 1], Motion::Fixed)];
        }
        let exact = beam(k, 1.0 - offset);
        let got = swing(world, 1.0 / exact.sqrt());
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
    let bundle = Bundle::new(&[made], false).unwrap();
    let euler = PI * PI * material.bend;
    // The frequency squared of the bow falls evenly with the load, to 0 at the critical one.
    let at = |load: f64| {
        let mut world = World::new(bundle.clone());
        let strain = -load / material.stretch;
        for i in 0..=edges {
            let s = i as f64 / edges as f64;
            world.state.position.x[i] = 1e-5 * (PI * s).sin();
            world.state.position.z[i] = s * (1.0 + strain);
        }
        let mut ends = [0, edges as u32].map(|v| Clamp::of(&world.bundle, vec![v], Motion::Fixed));
        ends[0].axes = [true, true, true];
        ends[1].axes = [true, true, false];
        world.loads.clamps = ends.into();
        world.loads.forces = vec![PointForce {
            vertex: edges as u32,
            force: DVec3::Z * -load,
            ramp: Ramp::Constant,
        }];
        swing(world, 0.5)
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
