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
/// Speed at which a crumb's free vertex moves across it, m/s.
const SPEED: f64 = 10.0;

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

/// What holds a crumb that whirls.
#[derive(Clone, Copy, PartialEq)]
enum Hold {
    /// A cohesive bond.
    Cohesive,
    /// A bond of the same stiffness that nothing breaks.
    Pin,
    /// Nothing.
    Nothing,
}

/// What became of it in a frame.
struct Whirl {
    /// Equilibria that it took.
    equilibria: u64,
    /// Pieces that are still held.
    bonds: usize,
    /// Energy at the start and by how much it is off at the end, J.
    start: f64,
    off: f64,
    /// How far the crumb has come and its momentum over its mass, m and m/s.
    way: DVec3,
    velocity: DVec3,
}

/// Moves a crumb that whirls about its first vertex for a frame.
fn whirl(hold: Hold) -> Whirl {
    let mut world = world(1);
    let held = (0..9).collect();
    world.loads.clamps = vec![Clamp::new(&world.bundle, held, Motion::Fixed)];
    let crumb = world.bundle.rod(2);
    world.state.velocity.set(crumb.start + 1, DVec3::Y * SPEED);
    match hold {
        Hold::Cohesive => {}
        Hold::Pin => world.failure.bonds = BondCriterion::Never,
        Hold::Nothing => {
            let others = world.bundle.bonds.iter();
            let others = others
                .filter(|b| b.vertex as usize != crumb.start)
                .collect();
            world.bundle.set_bonds(others).unwrap();
        }
    }
    let start = energies(&world.bundle, &world.state).total();
    let centre = |world: &World| {
        let p = &world.state.position;
        p.get(crumb.start).midpoint(p.get(crumb.start + 1))
    };
    let before = centre(&world);
    let mut solver = Interactive::new(None);
    let report = solver
        .advance(&mut world, &mut NoContacts, 1.0 / 30.0, &Context::quiet())
        .unwrap();
    let end = energies(&world.bundle, &world.state).total() + world.fracture_loss;
    let v = &world.state.velocity;
    Whirl {
        equilibria: solver.effort().equilibria,
        bonds: world.bundle.bonds.len(),
        start,
        off: end + report.damped + report.dissipated - report.work - start,
        way: centre(&world) - before,
        velocity: v.get(crumb.start).midpoint(v.get(crumb.start + 1)),
    }
}

#[test]
fn a_crumb_that_whirls_lets_go_and_flies_off_where_one_on_a_pin_goes_on_whirling() {
    let [whirled, pinned, free] = [Hold::Cohesive, Hold::Pin, Hold::Nothing].map(whirl);
    assert_eq!(pinned.bonds, world(1).bundle.bonds.len());
    assert_eq!(whirled.bonds, free.bonds);
    assert!(whirled.off.abs() < 1e-3 * whirled.start, "{}", whirled.off);
    // As a rod of two equal masses it flies at half the speed of the one that moved, along its first way: half of it at least is
    // left where it lets go, and a crumb on a pin stays within its own length.
    assert!((free.way.length() / (0.5 * SPEED / 30.0) - 1.0).abs() < 1e-6);
    assert!(whirled.way.dot(free.way) > 0.5 * free.way.length_squared());
    assert!(whirled.velocity.dot(free.velocity) > 0.5 * free.velocity.length_squared());
    assert!(pinned.way.length() < EDGE, "{}", pinned.way);
    assert!(3 * whirled.equilibria < pinned.equilibria);
}
