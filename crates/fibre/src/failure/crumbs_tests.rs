//! Crumbs that turn off the bond they hang by, and what the interactive solver spends on them.

use super::crumbs::{find_peeled_bonds, is_crumb};
use super::demand::bonds_in;
use crate::bonds::Bond;
use crate::energy::energies;
use crate::loads::{Clamp, Loads, Motion};
use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
use crate::solvers::{Interactive, Solver};
use crate::{BondCriterion, NoContacts, World};
use crate::{rotation::from_rotation_vector, topology::break_up};
use glam::DVec3;
use greenstick_geometry::Context;

/// Length of an edge and distance of rods, m; area of a facet, m².
const EDGE: f64 = 5e-3;
const DISTANCE: f64 = 1e-3;
const FACET: f64 = EDGE * DISTANCE;
/// Strength across a facet (Pa) and energy of fracture (J/m²): softening ends at an opening of 2 G/f = 0.1 mm.
const STRENGTH: f64 = 5e6;
const ENERGY: f64 = 250.0;

/// A rod and beside it one that is broken into pieces of `edges` edges, each held by one bond at its first vertex.
fn world(edges: usize) -> World {
    let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
    let rods = [0.0, DISTANCE].map(|x| {
        let vertex = |i: usize| DVec3::new(x, 0.0, EDGE * i as f64);
        Rod::new((0..9).map(vertex).collect(), material)
    });
    let mut world = World::new(RodBundle::new(&rods, false).unwrap());
    let World { bundle, state, .. } = &mut world;
    let splits: Vec<u32> = (9..18).step_by(edges).skip(1).collect();
    break_up(bundle, state, &mut Loads::default(), &[], &splits);
    let bonds = (1..bundle.rods()).map(|rod| {
        let first = bundle.rod(rod).start;
        Bond {
            vertex: first as u32,
            edge: (bundle.origin[first] - 9).min(7),
            t: f64::from(u8::from(bundle.origin[first] == 17)),
            distance: DISTANCE,
            rest_cosine: 0.0,
            transverse: 0.6e9 * FACET,
            shear: 0.35e9 * FACET * DISTANCE,
            area: FACET,
            tension_strength: STRENGTH * FACET,
            shear_strength: 2.0 * STRENGTH * FACET,
            fracture_energy: ENERGY * FACET,
            shear_fracture_energy: 3.0 * ENERGY * FACET,
            damage: 0.0,
        }
    });
    let bonds: Vec<Bond> = bonds.collect();
    bundle.set_bonds(bonds).unwrap();
    world.failure.bonds = BondCriterion::Cohesive;
    world
}

/// Turns a piece about its first vertex.
fn turn(world: &mut World, rod: usize, angle: f64) {
    let rotation = from_rotation_vector(DVec3::X * angle);
    let pin = world.state.position.get(world.bundle.rod(rod).start);
    for v in world.bundle.rod(rod) {
        let arm = world.state.position.get(v) - pin;
        world.state.position.set(v, pin + rotation * arm);
    }
}

#[test]
fn a_crumb_lets_go_where_its_facet_has_opened_by_turning_and_longer_pieces_hold() {
    // Half of the facet is a quarter of the edge, and open by half of sin θ times that: by 0.1 mm at θ = 9.2°.
    for (edges, degrees, expected) in [(1, 8.0, 0), (1, 10.0, 1), (2, 10.0, 1), (4, 40.0, 0)] {
        let mut world = world(edges);
        let mut queue = Vec::new();
        find_peeled_bonds(&world, &mut queue);
        assert!(queue.is_empty());
        assert_eq!(is_crumb(&world.bundle, 2), edges <= 2);
        assert!(!is_crumb(&world.bundle, 0));
        turn(&mut world, 2, f64::to_radians(degrees));
        find_peeled_bonds(&world, &mut queue);
        assert_eq!(queue.len(), expected, "{edges} edges, {degrees}°");
        let of_the_piece = world.bundle.rod(2).start as u32;
        for bond in bonds_in(&queue) {
            assert_eq!(world.bundle.bonds.vertex[bond as usize], of_the_piece);
        }
    }
}

/// Moves a crumb that whirls about its bond for a frame. Returns the equilibria that this took, how many pieces are
/// still held, and by how much the energy is off, J, with what there was at the start.
fn whirl(cohesive: bool) -> (u64, usize, [f64; 2]) {
    let mut world = world(1);
    let held = (0..9).collect();
    world.loads.clamps = vec![Clamp::new(&world.bundle, held, Motion::Fixed)];
    let second = world.bundle.rod(2).start + 1;
    world.state.velocity.set(second, DVec3::Y * 10.0);
    if !cohesive {
        // Bonds of the same stiffness that nothing breaks.
        world.failure.bonds = BondCriterion::Never;
    }
    let start = energies(&world.bundle, &world.state).total();
    let mut solver = Interactive::new(None);
    let report = solver
        .advance(&mut world, &mut NoContacts, 1.0 / 30.0, &Context::quiet())
        .unwrap();
    let end = energies(&world.bundle, &world.state).total() + world.fracture_loss;
    let off = end + report.damped + report.dissipated - report.work - start;
    (
        solver.effort().equilibria,
        world.bundle.bonds.len(),
        [off, start],
    )
}

#[test]
fn a_crumb_that_whirls_flies_off_and_costs_no_more_than_what_flies() {
    let (equilibria, bonds, [off, start]) = whirl(true);
    assert_eq!(bonds, world(1).bundle.bonds.len() - 1);
    assert!(off.abs() < 1e-3 * start, "{off} of {start} J");
    let (pinned, ..) = whirl(false);
    assert!(3 * equilibria < pinned, "{equilibria}, {pinned} on a pin");
}
