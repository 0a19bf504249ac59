//! What breaks, when, and what is left.

use super::breaking::break_elements;
use super::criteria::{BondCriterion, FailureCriteria};
use super::demand::{Element, Overstressed, bond_demand, combined_rod_demand};
use crate::contact::NoContacts;
use crate::energy::{add_forces, energies};
use crate::evaluator::ForceEvaluator;
use crate::event::{Cause, EventKind};
use crate::forces::Forces;
use crate::loads::{Clamp, Motion, PointForce, Ramp};
use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
use crate::solvers::{Explicit, Solver};
use crate::state::State;
use crate::support::{bond_all, four_rods, shaken, soft, straight};
use crate::world::World;
use glam::DVec3;
use greenstick_geometry::Context;

fn overstressed(element: Element) -> Overstressed {
    Overstressed {
        demand: 1.0,
        element,
    }
}

#[test]
fn a_broken_rod_is_two_rods_and_loses_only_its_bending_there() {
    for curved in [false, true] {
        let mut world = World::new(four_rods(curved));
        world.state = shaken(&world.bundle, 4, 0.1);
        let old = world.clone();
        let vertex = world.bundle.rod_offsets[1] + 3;
        world.loads.forces = vec![PointForce {
            vertex,
            force: DVec3::X,
            ramp: Ramp::Constant,
        }];
        world.loads.clamps = vec![Clamp::new(
            &world.bundle,
            vec![vertex, vertex + 1],
            Motion::Fixed,
        )];
        let queue = [
            overstressed(Element::Rod(vertex)),
            overstressed(Element::Rod(vertex + 1)),
            overstressed(Element::Bond(5)),
        ];
        let (before, momentum) = (
            energies(&world.bundle, &world.state),
            world.state.momentum(&world.bundle),
        );
        break_elements(&mut world, &mut NoContacts, &queue);
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
        check_forces(&world);
        check_gaps(&world.bundle);
    }
}

/// Checks that the fast forces are still the gradients.
fn check_forces(world: &World) {
    let (bundle, state) = (&world.bundle, &world.state);
    let mut exact = Forces::zeros(bundle.vertices());
    let mut fast = exact.clone();
    add_forces(bundle, state, &mut exact);
    ForceEvaluator::new(bundle).forces(bundle, state, &mut fast);
    for i in 0..bundle.vertices() {
        assert!(fast.linear.get(i).distance(exact.linear.get(i)) < 1e-11);
    }
}

/// Checks that there are edges within rods, and gaps and free ends between them.
fn check_gaps(bundle: &RodBundle) {
    for rod in 0..bundle.rods() {
        let range = bundle.rod(rod);
        assert!(bundle.bend[range.start] == 0.0 && bundle.stretch[range.end - 1] == 0.0);
        assert!((range.start..range.end - 1).all(|j| bundle.is_edge(j)));
    }
}

#[test]
fn the_bending_ratio_is_that_of_the_outer_fibre() {
    // Vertices on a circle of radius 1 m, stretched by 2 %.
    let material = RodMaterial {
        tension_limit: 0.01,
        ..soft()
    };
    let bundle = RodBundle::new(&[straight(DVec3::ZERO, 0.5, 20, material)], false).unwrap();
    let mut state = State::at_rest(&bundle);
    let angle = 2.0 * (1.02 * 0.025f64 / 2.0).asin();
    for i in 0..bundle.vertices() {
        let a = angle * i as f64;
        state.position.set(i, DVec3::new(a.cos(), 0.0, a.sin()));
    }
    let expected = (1.02 * (1.0 + 0.5 * material.diameter) - 1.0) / 0.01;
    let got = combined_rod_demand(&bundle, &state, 7, material.diameter);
    assert!((got / expected - 1.0).abs() < 1e-10, "{got} {expected}");
}

/// A damped rod that is slowly pulled (or compressed) at one end.
fn pulled(speed: f64, failure: FailureCriteria, material: RodMaterial) -> World {
    let mut rods = vec![straight(DVec3::ZERO, 0.05, 10, material)];
    rods[0].relative_strength = vec![1.0, 1.0, 1.0, 1.0, 0.8, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let mut world = World::new(RodBundle::new(&rods, false).unwrap());
    world.failure = failure;
    world.loads.damping = 2000.0;
    let motion = Motion::Steady {
        velocity: DVec3::Z * speed,
        angular_velocity: DVec3::ZERO,
    };
    world.loads.clamps = vec![
        Clamp::new(&world.bundle, vec![0], Motion::Fixed),
        Clamp::new(&world.bundle, vec![10], motion),
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
        FailureCriteria {
            rods_break: true,
            ..FailureCriteria::default()
        },
        material,
    );
    Explicit::new(None)
        .advance(&mut world, &mut NoContacts, 0.1, &Context::quiet())
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
fn a_compressed_rod_yields_and_stays_short() {
    let material = RodMaterial {
        yield_strain: 0.01,
        ..soft()
    };
    let mut world = pulled(
        -0.01,
        FailureCriteria {
            rods_yield: true,
            ..FailureCriteria::default()
        },
        material,
    );
    // The energy balance is of first order in the step.
    let mut solver = Explicit::new(Some(5e-6));
    let report = solver
        .advance(&mut world, &mut NoContacts, 0.15, &Context::quiet())
        .unwrap();
    // Compressed by 3 %, with the whole yield force from 1 % on: work = k ε_y (ε − ½ ε_y) L.
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
    // Released, it stays 2 % shorter.
    world.loads.clamps.pop();
    solver
        .advance(&mut world, &mut NoContacts, 0.05, &Context::quiet())
        .unwrap();
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
    let mut bundle = RodBundle::new(&rods, false).unwrap();
    bond_all(&mut bundle, 6e-3, 100.0, 5e-3);
    // Opened by 10 %: E_t = ½ k ε² d₀, force k ε. Slipped by 10 %: E_s = S γ², force 2 S γ/d₀, and no opening.
    for (by, energy, force) in [
        (DVec3::X * 0.5e-3, 0.5 * 100.0 * 0.01 * 5e-3, 10.0),
        (DVec3::Z * 0.5e-3, 5e-3 * 0.01, 2.0 * 5e-3 * 0.1 / 5e-3),
    ] {
        let mut state = State::at_rest(&bundle);
        bundle.rod(1).for_each(|i| state.position.add(i, by));
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
                let got = bond_demand(criterion, &bundle, &state, bond);
                assert!(
                    (got / expected - 1.0).abs() < 1e-9,
                    "{criterion:?}: {got}, not {expected}"
                );
            }
        }
    }
}
