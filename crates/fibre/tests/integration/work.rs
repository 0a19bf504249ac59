//! The work of clamps and loads: it is the energy that they store, where that is known.

use crate::support::{soft, straight};
use glam::DVec3;
use greenstick_fibre::energy::energies;
use greenstick_fibre::scene::{Scene, SolverChoice};
use greenstick_fibre::simulate::{SimulateRequest, simulate};
use greenstick_fibre::store::MemoryRun;
use greenstick_fibre::{
    AdvanceReport, Clamp, Explicit, Implicit, Interactive, Moment, Motion, NoContacts, PointForce,
    QuasiStatic, Ramp, RodBundle, RodMaterial, Solver, World,
};
use greenstick_geometry::Context;

/// Length of the rod, m, and its edges.
const LENGTH: f64 = 0.1;
const EDGES: usize = 40;
/// Its length between the middles of the outermost edges, which clamps hold: twist is distributed over the half edges about
/// vertices.
const FREE_LENGTH: f64 = LENGTH * (1.0 - 1.0 / EDGES as f64);

/// A rod that resists twist, clamped at its lower end.
fn clamped_rod() -> World {
    let rod = straight(DVec3::ZERO, LENGTH, EDGES, soft());
    let mut world = World::new(RodBundle::new(&[rod], true).unwrap());
    world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed)];
    world
}

fn advance(solver: &mut dyn Solver, world: &mut World, time: f64) -> AdvanceReport {
    solver
        .advance(world, &mut NoContacts, time, &Context::quiet())
        .unwrap()
}

/// Checks that `value` is `expected` but for a fraction `tolerance` of it.
fn assert_near(what: &str, value: f64, expected: f64, tolerance: f64) {
    let off = value / expected - 1.0;
    println!("{what}: {value} for {expected}, off by {off:e}");
    assert!(off.abs() <= tolerance, "{what}: {value} for {expected}");
}

/// Checks that the energy of the world and what was taken from it are the work that was done.
fn assert_balanced(what: &str, world: &World, report: &AdvanceReport, tolerance: f64) {
    let total = energies(&world.bundle, &world.state).total();
    let taken = report.damped + report.dissipated + world.fracture_loss;
    assert_near(what, total + taken, report.work, tolerance);
}

#[test]
fn the_work_of_a_turned_clamp_is_the_energy_of_twist() {
    let (angle, time, steps) = (1.0, 0.5, 50.0);
    let expected = 0.5 * soft().twist / FREE_LENGTH * angle * angle;
    // Implicit Euler takes the moment at the end of each step along it, of which it dissipates the excess.
    let solvers: [(Box<dyn Solver>, f64, f64); 4] = [
        (Box::new(Explicit::new(None)), 1.0, 5e-3),
        (Box::new(Implicit::new(Some(time / steps))), 1.0, 1e-3),
        (
            Box::new(Interactive::new(Some(time / steps))),
            1.0 + 1.0 / steps,
            1e-3,
        ),
        (Box::new(QuasiStatic::new(Some(time / steps))), 1.0, 1e-9),
    ];
    for (mut solver, rule, tolerance) in solvers {
        let mut world = clamped_rod();
        let turn = Motion::Steady {
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::Z * (angle / time),
        };
        let end = vec![EDGES as u32 - 1, EDGES as u32];
        world
            .loads
            .clamps
            .push(Clamp::new(&world.bundle, end, turn));
        let report = advance(&mut *solver, &mut world, time);
        let stored = energies(&world.bundle, &world.state);
        assert_near(solver.name(), stored.twist, expected, tolerance);
        assert_near(solver.name(), report.work, expected * rule, tolerance);
        assert_balanced(solver.name(), &world, &report, 1e-4);
    }
}

#[test]
fn the_work_of_a_growing_moment_is_the_energy_of_twist() {
    let (time, moment) = (0.5, 1e-4);
    let free = LENGTH - LENGTH / EDGES as f64;
    let expected = 0.5 * moment * moment * free / soft().twist;
    for mut solver in [
        Box::new(Explicit::new(None)) as Box<dyn Solver>,
        Box::new(Implicit::new(Some(0.01))),
        Box::new(QuasiStatic::new(Some(0.01))),
    ] {
        let mut world = clamped_rod();
        world.loads.moments = vec![Moment {
            edge: EDGES as u32 - 1,
            moment: DVec3::Z * moment,
            ramp: Ramp::Linear(time),
        }];
        world.loads.damping = 20.0;
        let report = advance(&mut *solver, &mut world, 2.0 * time);
        let stored = energies(&world.bundle, &world.state);
        assert_near(solver.name(), stored.twist, expected, 1e-4);
        assert_balanced(solver.name(), &world, &report, 1e-4);
    }
}

#[test]
fn the_work_of_a_growing_load_is_the_energy_of_a_cantilever() {
    let (time, force, weight) = (1.0, 1e-5, 2e-4);
    let bend = soft().bend;
    // The clamp holds the first edge to its middle.
    let free = LENGTH * (1.0 - 0.5 / EDGES as f64);
    let ramp = Ramp::Linear(time);
    let bundle = clamped_rod().bundle;
    let share = |v: usize| weight * LENGTH * bundle.mass[v] / bundle.total_mass();
    let load = |vertex: usize, force: f64| PointForce {
        vertex: vertex as u32,
        force: DVec3::X * force,
        ramp,
    };
    let end_load = vec![load(EDGES, force)];
    let own_weight = (0..=EDGES).map(|v| load(v, share(v))).collect();
    // F² L³/(6 E I) and q² L⁵/(40 E I).
    let cases: [(&str, Vec<PointForce>, f64); 2] = [
        (
            "end load",
            end_load,
            force * force * free.powi(3) / (6.0 * bend),
        ),
        (
            "own weight",
            own_weight,
            weight * weight * free.powi(5) / (40.0 * bend),
        ),
    ];
    for (what, forces, expected) in cases {
        let mut world = clamped_rod();
        world.loads.forces = forces;
        let report = advance(&mut QuasiStatic::new(Some(0.05)), &mut world, time);
        let stored = energies(&world.bundle, &world.state);
        assert_near(what, stored.bend, expected, 2e-3);
        assert_near(what, report.work, stored.total(), 1e-6);
        // From one equilibrium to the next the method takes nothing but the error of the trapezoidal rule.
        assert!(
            report.dissipated.abs() < 1e-6 * stored.total(),
            "{report:?}"
        );
    }
}

#[test]
fn half_the_work_of_a_sudden_weight_is_stored() {
    let mut world = clamped_rod();
    world.loads.gravity = DVec3::X * 0.02;
    let report = advance(&mut QuasiStatic::new(Some(0.05)), &mut world, 1.0);
    let stored = energies(&world.bundle, &world.state).total();
    // The weight times the way that it sinks.
    let sunk = (0..world.bundle.vertices()).fold(0.0, |sum, v| {
        let way = world.state.position.get(v) - world.bundle.rest.get(v);
        sum + world.bundle.mass[v] * world.loads.gravity.dot(way)
    });
    assert_near("work", report.work, sunk, 1e-12);
    assert_near("stored", stored, 0.5 * sunk, 1e-3);
    assert_balanced("balance", &world, &report, 1e-9);
}

#[test]
fn the_balance_of_the_built_in_scene_twist_closes() {
    let mut scene = Scene::built_in("twist").unwrap();
    (scene.solver, scene.duration) = (SolverChoice::QuasiStatic, 0.05);
    let request = SimulateRequest {
        scene,
        ..SimulateRequest::default()
    };
    let report = simulate(&request, &mut MemoryRun::new(), &Context::quiet()).unwrap();
    let energy = report.energy;
    println!("off by {} J of {} J", energy.largest_j, energy.most_j);
    assert!(energy.most_j > 0.1, "{}", energy.most_j);
    assert!(
        energy.largest_j < 5e-4 * energy.most_j,
        "{}",
        energy.largest_j
    );
}

#[test]
fn yielding_between_two_half_steps_neither_makes_nor_loses_energy() {
    let material = RodMaterial {
        yield_strain: 0.01,
        ..soft()
    };
    let rod = straight(DVec3::ZERO, LENGTH, EDGES, material);
    let mut world = World::new(RodBundle::new(&[rod], false).unwrap());
    world.failure.rods_yield = true;
    // Its halves run into each other, fast enough for twice the yield strain.
    let speed = 0.02 * (1e7f64 / 600.0).sqrt();
    for v in 0..=EDGES {
        let way = (EDGES as f64 / 2.0 - v as f64).clamp(-1.0, 1.0);
        world.state.velocity.set(v, DVec3::Z * speed * way);
    }
    let before = energies(&world.bundle, &world.state).kinetic;
    let step = 0.1 * Explicit::new(None).step(&world, &Context::quiet()).unwrap();
    let mut solver = Explicit::new(Some(step));
    advance(&mut solver, &mut world, 600.0 * step);
    let there = energies(&world.bundle, &world.state);
    let lost = world.fracture_loss;
    advance(&mut solver, &mut world, step);
    // Velocities are those of half a step before.
    let after = energies(&world.bundle, &world.state).kinetic;
    let total = there.potential() + 0.5 * (there.kinetic + after) + lost;
    assert!(lost > 0.1 * before, "{lost} of {before}");
    assert_near("energy", total, before, 1e-3);
}
