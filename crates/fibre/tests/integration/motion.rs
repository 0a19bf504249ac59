//! Momenta and energy of moving bundles.

use crate::support::{four_rods, random_vector, shaken, soft, straight};
use glam::DVec3;
use greenstick_fibre::energy::{add_forces, energies};
use greenstick_fibre::solvers::BLOW_UP_RATIO;
use greenstick_fibre::{
    Clamp, Explicit, Forces, Motion, NoContacts, RodBundle, Solver, SolverError, State, World,
};
use greenstick_geometry::Context;

/// A free bundle that vibrates, moves and turns.
fn flying(curved: bool) -> World {
    let bundle = four_rods(curved);
    let mut world = World::new(bundle);
    world.state = shaken(&world.bundle, 3, 0.004);
    for i in 0..world.bundle.vertices() {
        let p = world.state.position.get(i);
        let v = random_vector(9, i) * 0.1
            + DVec3::new(1.0, -0.5, 0.2)
            + DVec3::new(3.0, 8.0, -2.0).cross(p);
        world.state.velocity.set(i, v);
        world.state.spin[i] = 0.0;
        world.state.angle[i] = 0.0;
    }
    world
}

#[test]
fn a_free_bundle_conserves_its_momenta() {
    // Transporting frames in each step makes the angular momentum of curved rods less exact: it is not checked.
    for (curved, steps) in [(false, 1e5), (true, 5e3)] {
        let mut world = flying(curved);
        let mut solver = Explicit::new(None);
        let momenta = |world: &World| {
            let about = world.state.angular_momentum(&world.bundle, DVec3::ZERO);
            (world.state.momentum(&world.bundle), about)
        };
        let (p, l) = momenta(&world);
        let step = solver.step(&world, &Context::quiet()).unwrap();
        solver
            .advance(&mut world, &mut NoContacts, step * steps, &Context::quiet())
            .unwrap();
        assert!(world.state.step as f64 >= steps);
        let (q, m) = momenta(&world);
        let (linear, about) = (q.distance(p) / p.length(), m.distance(l) / l.length());
        println!("curved {curved}: momentum {linear:e}, angular momentum {about:e}");
        assert!(linear < 1e-10 && (curved || about < 1e-10));
    }
}

#[test]
fn energy_is_conserved() {
    for curved in [false, true] {
        let mut world = flying(curved);
        // At a tenth of the limit, because the measured energy oscillates by ω Δt about the conserved one.
        let step = Explicit::new(None).step(&world, &Context::quiet()).unwrap();
        let mut solver = Explicit::new(Some(0.125 * step));
        let start = energies(&world.bundle, &world.state).total();
        let mut worst: f64 = 0.0;
        for _ in 0..20 {
            solver
                .advance(&mut world, &mut NoContacts, 5e-3, &Context::quiet())
                .unwrap();
            worst = worst.max((energies(&world.bundle, &world.state).total() / start - 1.0).abs());
        }
        println!(
            "curved {curved}: energy off by {worst:e} in {} steps",
            world.state.step
        );
        assert!(worst < 0.02);
    }
}

#[test]
fn too_large_a_step_is_refused_and_the_limit_is_sharp() {
    let world = flying(false);
    let mut solver = Explicit::new(None);
    let step = solver.step(&world, &Context::quiet()).unwrap();
    let limit = step / 0.8;
    let refused = Explicit::new(Some(1.01 * limit)).advance(
        &mut world.clone(),
        &mut NoContacts,
        1.0,
        &Context::quiet(),
    );
    assert!(
        matches!(refused, Err(SolverError::UnstableStep { limit: l, .. }) if (l / limit - 1.0).abs() < 1e-12)
    );
    // Just below the limit it runs. Beyond it the same motion blows up, which is caught with the state before the step.
    let mut near = world.clone();
    Explicit::new(Some(0.95 * limit))
        .advance(
            &mut near,
            &mut NoContacts,
            2000.0 * limit,
            &Context::quiet(),
        )
        .unwrap();
    let mut beyond = world.clone();
    let mut known = world.clone();
    Explicit::new(None)
        .advance(&mut known, &mut NoContacts, step, &Context::quiet())
        .unwrap();
    beyond.limit = known.limit.map(|mut l| {
        l.limit *= 2.0;
        l
    });
    let caught = Explicit::new(Some(1.1 * limit)).advance(
        &mut beyond,
        &mut NoContacts,
        2000.0 * limit,
        &Context::quiet(),
    );
    let Err(SolverError::BlowUp {
        rod,
        energy,
        before,
        after,
        step,
        ..
    }) = caught
    else {
        panic!("{caught:?}");
    };
    println!(
        "blew up after {} steps: {energy} of rod {rod}, {before} J to {after} J",
        beyond.state.step
    );
    assert!(beyond.state.is_finite() && after > before && beyond.state.step > 0);
    // Nothing does work: all energy that there can be is that of the start. The refused step would have moved with more than
    // the solver's multiple of it, and no step before it did.
    let most = BLOW_UP_RATIO * energies(&world.bundle, &world.state).total();
    let (bundle, state) = (&beyond.bundle, &beyond.state);
    assert!(energies(bundle, state).kinetic <= most);
    let mut forces = Forces::zeros(bundle.vertices());
    add_forces(bundle, state, &mut forces);
    let mut next = state.clone();
    for i in 0..bundle.vertices() {
        let push = forces.linear.get(i) * (step / bundle.mass[i]);
        next.velocity.add(i, push);
    }
    assert!(energies(bundle, &next).kinetic > most);
}

#[test]
fn a_resumed_run_ends_in_the_same_bytes() {
    let mut whole = flying(false);
    let mut solver = Explicit::new(None);
    for _ in 0..4 {
        solver
            .advance(&mut whole, &mut NoContacts, 3e-3, &Context::quiet())
            .unwrap();
    }
    let mut world = flying(false);
    for _ in 0..4 {
        Explicit::new(None)
            .advance(&mut world, &mut NoContacts, 3e-3, &Context::quiet())
            .unwrap();
        let text = serde_json::to_string(&world).unwrap();
        world = serde_json::from_str(&text).unwrap();
    }
    assert_eq!(world.state, whole.state);
    let rest: &State = &whole.state;
    assert!(rest.is_finite());
}

/// Returns the largest relative change of the mean energy over a tenth of the time from that over the first tenth, of rods
/// clamped at one end (Sutherland 2012 Fig. 4.1) that start with a velocity growing along them.
fn oscillation_drift(bundle: RodBundle, duration: f64) -> f64 {
    let held = (0..bundle.rods()).flat_map(|r| {
        let first = bundle.rod_offsets[r];
        [first, first + 1]
    });
    let clamp = Clamp::new(&bundle, held.collect(), Motion::Fixed);
    let mut world = World::new(bundle);
    world.loads.clamps.push(clamp);
    for i in 0..world.bundle.vertices() {
        let along = world.bundle.rest.get(i).z / 0.06;
        let v = DVec3::X * (0.3 * along * along);
        world.state.velocity.set(i, v);
    }
    let mut solver = Explicit::new(None);
    let samples = 200;
    let mut means = [0.0; 10];
    for mean in &mut means {
        for _ in 0..samples {
            solver
                .advance(
                    &mut world,
                    &mut NoContacts,
                    0.1 * duration / samples as f64,
                    &Context::quiet(),
                )
                .unwrap();
            *mean += energies(&world.bundle, &world.state).total() / samples as f64;
        }
    }
    println!("{} steps, mean energies {means:?}", world.state.step);
    means
        .iter()
        .fold(0.0, |worst, m| worst.max((m / means[0] - 1.0).abs()))
}

#[test]
fn a_cantilever_swings_for_3_s_without_losing_energy() {
    let rod = straight(DVec3::ZERO, 0.06, 8, soft());
    for bundle in [RodBundle::new(&[rod], false).unwrap(), four_rods(false)] {
        let drift = oscillation_drift(bundle, 3.0);
        println!("energy drift {drift:e}");
        assert!(drift < 1e-3);
    }
}
