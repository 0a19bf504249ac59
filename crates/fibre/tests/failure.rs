//! What breaks, when, and what is left.

mod support;

use glam::DVec3;
use greenstick_fibre::energy::{Forces, add_forces, energies};
use greenstick_fibre::failure::{Break, apply, rod_demand};
use greenstick_fibre::{
    BondCriterion, Bundle, Cause, Clamp, Evaluator, EventKind, Explicit, Failure, Motion,
    NoContacts, PointForce, Ramp, Rod, RodMaterial, Solver, State, World,
};
use support::{four_rods, shaken, soft, straight};

fn rod_break(vertex: u32) -> Break {
    Break {
        demand: 1.0,
        bond: false,
        number: vertex,
    }
}

#[test]
fn a_broken_rod_is_two_rods_and_loses_only_its_bending_there() {
    for curved in [false, true] {
        let mut world = World::new(four_rods(curved));
        world.state = shaken(&world.bundle, 4, 0.1);
        let old = world.clone();
        let vertex = world.bundle.first[1] + 3;
        world.loads.forces = vec![PointForce {
            vertex,
            force: DVec3::X,
            ramp: Ramp::Constant,
        }];
        world.loads.clamps = vec![Clamp::of(
            &world.bundle,
            vec![vertex, vertex + 1],
            Motion::Fixed,
        )];
        let queue = [
            rod_break(vertex),
            rod_break(vertex + 1),
            Break {
                demand: 2.0,
                bond: true,
                number: 5,
            },
        ];
        let (before, momentum) = (
            energies(&world.bundle, &world.state),
            world.state.momentum(&world.bundle),
        );
        apply(&mut world, &mut NoContacts, &queue);
        let after = energies(&world.bundle, &world.state);
        let loss = before.total() - after.total();
        assert!(
            (loss - world.fracture_loss).abs() < 1e-12 * before.total(),
            "{loss} {}",
            world.fracture_loss
        );
        assert!(world.state.momentum(&world.bundle).distance(momentum) < 1e-15);
        assert!((world.bundle.total_mass() / old.bundle.total_mass() - 1.0).abs() < 1e-14);
        assert_eq!(world.bundle.rods(), 6);
        assert_eq!(world.bundle.vertices(), old.bundle.vertices() + 2);
        assert_eq!(world.bundle.parent, [0, 1, 1, 1, 2, 3]);
        assert_eq!(world.bundle.rod(2).len(), 2);
        assert_eq!(world.events.len(), 3);
        let total: DVec3 = world.loads.forces.iter().map(|f| f.force).sum();
        assert!(world.loads.check(&world.bundle).is_ok() && total.distance(DVec3::X) < 1e-15);
        assert_eq!(world.loads.clamps[0].vertices.len(), 4);
        // All lists are right: the fast forces are still the gradients.
        let (mut exact, mut fast) = (Forces::zeros(world.bundle.vertices()), Forces::default());
        fast.linear = exact.linear.clone();
        fast.moment = exact.moment.clone();
        add_forces(&world.bundle, &world.state, &mut exact);
        Evaluator::new(&world.bundle).forces(&world.bundle, &world.state, &mut fast);
        for i in 0..world.bundle.vertices() {
            assert!(fast.linear.get(i).distance(exact.linear.get(i)) < 1e-11);
        }
        // Made from its parts the bundle is what breaking left.
        for rod in 0..world.bundle.rods() {
            let range = world.bundle.rod(rod);
            assert!(
                world.bundle.bend[range.start] == 0.0 && world.bundle.stretch[range.end - 1] == 0.0
            );
            assert!(
                range
                    .clone()
                    .take(range.len() - 1)
                    .all(|j| world.bundle.is_edge(j))
            );
        }
    }
}

#[test]
fn the_bending_ratio_is_that_of_the_outer_fibre() {
    // Vertices on a circle of radius 1 m, stretched by 2 %.
    let material = RodMaterial {
        tension_limit: 0.01,
        ..soft()
    };
    let bundle = Bundle::new(&[straight(DVec3::ZERO, 0.5, 20, material)], false).unwrap();
    let mut state = State::at_rest(&bundle);
    let angle = 2.0 * (1.02 * 0.025f64 / 2.0).asin();
    for i in 0..bundle.vertices() {
        let a = angle * i as f64;
        state.position.set(i, DVec3::new(a.cos(), 0.0, a.sin()));
    }
    let expected = (1.02 * (1.0 + 0.5 * material.diameter) - 1.0) / 0.01;
    let got = rod_demand(&bundle, &state, 7, material.diameter);
    assert!((got / expected - 1.0).abs() < 1e-10, "{got} {expected}");
}

/// A rod pulled (or pressed) at one end, slowly; damped.
fn pulled(speed: f64, failure: Failure, material: RodMaterial) -> World {
    let mut rods = vec![straight(DVec3::ZERO, 0.05, 10, material)];
    rods[0].relative_strength = vec![1.0, 1.0, 1.0, 1.0, 0.8, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let mut world = World::new(Bundle::new(&rods, false).unwrap());
    world.failure = failure;
    world.loads.damping = 2000.0;
    let motion = Motion::Steady {
        velocity: DVec3::Z * speed,
        angular: DVec3::ZERO,
    };
    world.loads.clamps = vec![
        Clamp::of(&world.bundle, vec![0], Motion::Fixed),
        Clamp::of(&world.bundle, vec![10], motion),
    ];
    world
}

#[test]
fn a_pulled_rod_breaks_at_its_weakest_vertex_and_strain() {
    let material = RodMaterial {
        tension_limit: 0.02,
        ..soft()
    };
    let mut world = pulled(
        0.01,
        Failure {
            rods_break: true,
            ..Failure::default()
        },
        material,
    );
    Explicit::new(None)
        .advance(&mut world, &mut NoContacts, 0.1)
        .unwrap();
    assert_eq!(world.events.len(), 1, "{:?}", world.events);
    let event = world.events[0];
    assert_eq!(
        (event.kind, event.cause, event.vertex),
        (EventKind::RodBroke, Cause::Tension, 4)
    );
    // 0.8 × 2 % of 50 mm at 10 mm/s.
    assert!((event.time / 0.08 - 1.0).abs() < 0.02, "{}", event.time);
}

#[test]
fn a_pressed_rod_yields_and_stays_short() {
    let material = RodMaterial {
        yield_strain: 0.01,
        ..soft()
    };
    let mut world = pulled(
        -0.01,
        Failure {
            rods_yield: true,
            ..Failure::default()
        },
        material,
    );
    // The balance of energy is of the step's first order.
    let mut solver = Explicit::new(Some(5e-6));
    let report = solver.advance(&mut world, &mut NoContacts, 0.15).unwrap();
    // Pressed by 3 % with all of the yield force from 1 % on: work = k ε_y (ε − ½ ε_y) L.
    let work = material.stretch * 0.01 * (0.03 - 0.005) * 0.05;
    assert!(
        (report.work / work - 1.0).abs() < 0.03,
        "{} {work}",
        report.work
    );
    let total = energies(&world.bundle, &world.state).total() + world.fracture_loss + report.damped;
    assert!(
        (total / report.work - 1.0).abs() < 1e-3,
        "{total} {}",
        report.work
    );
    // Let go, it stays 2 % short.
    world.loads.clamps.pop();
    solver.advance(&mut world, &mut NoContacts, 0.05).unwrap();
    let length = world.state.position.get(10).z;
    assert!((length / (0.98 * 0.05) - 1.0).abs() < 2e-3, "{length}");
    assert!(
        !world.events.is_empty() && world.events.iter().all(|e| e.kind == EventKind::RodYielded)
    );
}

#[test]
fn bonds_break_by_each_criterion_at_their_strength() {
    let rods: Vec<Rod> = [0.0, 5e-3]
        .map(|x| straight(DVec3::X * x, 0.05, 5, soft()))
        .into();
    let mut bundle = Bundle::new(&rods, false).unwrap();
    support::bond_all(&mut bundle, 6e-3, 100.0, 5e-3);
    // Drawn apart by 10 %: E_t = ½ k ε² d₀, force k ε. Slid by 10 %: E_s = S sin²γ, force 2 S sin γ/d₀.
    for (by, energy, force) in [
        (DVec3::X * 0.5e-3, 0.5 * 100.0 * 0.01 * 5e-3, 10.0),
        (
            DVec3::Z * 0.5e-3,
            5e-3 * 0.01 / 1.01,
            2.0 * 5e-3 * 0.1 / 1.01f64.sqrt() / 5e-3,
        ),
    ] {
        let mut state = State::at_rest(&bundle);
        bundle.rod(1).for_each(|i| state.position.add(i, by));
        // The change of length in sliding is no matter here.
        let mut bundle = bundle.clone();
        if by.z > 0.0 {
            bundle.bonds.transverse.fill(0.0);
        }
        for (criterion, expected) in [
            (
                BondCriterion::Potential {
                    threshold: 1e-3,
                    shear_weight: 0.5,
                },
                0.5 * energy / 1e-3,
            ),
            (BondCriterion::Griffith, energy / 1e-3),
            (BondCriterion::Stress, force / 1.0),
        ] {
            for bond in 0..bundle.bonds.len() {
                let got = greenstick_fibre::failure::bond_demand(criterion, &bundle, &state, bond);
                assert!(
                    (got / expected - 1.0).abs() < 1e-9,
                    "{criterion:?}: {got}, not {expected}"
                );
            }
        }
    }
}
