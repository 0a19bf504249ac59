//! Rods break where the demand is greatest, and nothing is lost on the way there.

use super::break_place::{BreakPlace, move_breaks, move_state};
use super::breaking::break_elements;
use super::criteria::FailureCriteria;
use super::demand::{Element, Overstressed, combined_rod_demand};
use crate::contact::NoContacts;
use crate::energy::energies;
use crate::rod_bundle::{Rod, RodBundle};
use crate::state::State;
use crate::support::{four_rods, random, shaken, soft};
use crate::world::{StabilityLimit, World};
use glam::DVec3;

/// Length of the rod, m.
const LENGTH: f64 = 0.2;

/// A rod of 40 edges whose lengths differ by up to 40 %, and its vertices' lengths along it.
fn uneven_rod() -> (RodBundle, Vec<f64>) {
    let mut along = vec![0.0];
    for i in 0..40 {
        along.push(along[i] + 1.0 + 0.2 * random(7, i));
    }
    let whole = along[40];
    along.iter_mut().for_each(|s| *s *= LENGTH / whole);
    let vertices = along.iter().map(|&s| DVec3::Z * s).collect();
    let bundle = RodBundle::new(&[Rod::new(vertices, soft())], false).unwrap();
    (bundle, along)
}

/// Bends a rod without stretching it, so that its bending moment is greatest at `peak` (m) and falls off as a parabola.
fn bent(bundle: &RodBundle, along: &[f64], peak: f64) -> State {
    let mut state = State::at_rest(bundle);
    let (mut angle, mut position) = (0.0f64, DVec3::ZERO);
    for vertex in 0..along.len() - 1 {
        if vertex > 0 {
            let off = (along[vertex] - peak) / 0.04;
            let curvature = 20.0 * (1.0 - off * off).max(0.0);
            let half_lengths = 0.5 * (along[vertex + 1] - along[vertex - 1]);
            angle += curvature * half_lengths;
        }
        position += DVec3::new(angle.sin(), 0.0, angle.cos()) * bundle.rest_length[vertex];
        state.position.set(vertex + 1, position);
    }
    state
}

#[test]
fn a_rod_breaks_where_its_curvature_is_greatest_wherever_vertices_are() {
    let (bundle, along) = uneven_rod();
    let mut places = Vec::new();
    for k in 0..60 {
        let peak = 0.09 + 0.02 * f64::from(k) / 60.0;
        let state = bent(&bundle, &along, peak);
        let mut world = World::new(bundle.clone());
        world.state = state;
        let demand = |v: &usize| combined_rod_demand(&bundle, &world.state, *v, bundle.diameter[0]);
        let vertex = (1..40)
            .max_by(|a, b| demand(a).total_cmp(&demand(b)))
            .unwrap();
        let found = BreakPlace::new(&bundle, &world.state, &world.loads, vertex as u32);
        let s = found.map_or(along[vertex], |p| {
            along[vertex] + p.fraction * (along[p.towards] - along[vertex])
        });
        // Edges are 5 mm long; a break at the nearest vertex is up to 3 mm off.
        assert!((s - peak).abs() < 0.5e-3, "{peak} {s}");
        places.push(s);
    }
    let nearest = |s: f64| along.iter().fold(1.0, |m: f64, v| m.min((v - s).abs()));
    assert!(places.iter().any(|&s| nearest(s) > 2e-3));
}

/// The vertex of a rod with the greatest demand of those that may be moved.
fn weakest(world: &World, rod: usize) -> u32 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let demand = |v: &u32| combined_rod_demand(bundle, state, *v as usize, bundle.diameter[rod]);
    let movable = |v: &u32| BreakPlace::new(bundle, state, loads, *v).is_some();
    (bundle.rod_offsets[rod]..bundle.rod_offsets[rod + 1])
        .filter(movable)
        .max_by(|a, b| demand(a).total_cmp(&demand(b)))
        .unwrap()
}

fn momenta(world: &World) -> [DVec3; 2] {
    let (state, bundle) = (&world.state, &world.bundle);
    let about = DVec3::new(0.3, -0.2, 0.1);
    [
        state.momentum(bundle),
        state.angular_momentum(bundle, about),
    ]
}

#[test]
fn moving_a_break_keeps_mass_momentum_and_strain() {
    for curved in [false, true] {
        let mut world = World::new(four_rods(curved));
        world.state = shaken(&world.bundle, 4, 0.1);
        let old = world.clone();
        let splits: Vec<u32> = (0..4).map(|r| weakest(&world, r)).collect();
        let places = move_breaks(&mut world, &splits);
        assert_eq!(places.len(), 4);
        let mass = |w: &World| w.bundle.total_mass();
        assert!((mass(&world) / mass(&old) - 1.0).abs() < 1e-14);
        for (new, before) in momenta(&world).into_iter().zip(momenta(&old)) {
            let off = (new - before).length() / before.length();
            assert!(off < 1e-11, "{off}");
        }
        for place in &places {
            // The vertex lies on its rod, where the wood was.
            let own = world.state.position.get(place.vertex);
            assert!(own.distance(place.position(&old.state)) < 1e-15);
            let strain = |w: &World, edge: usize| {
                w.state.edge(edge).length() / w.bundle.rest_length[edge] - 1.0
            };
            let [before, after] = [place.vertex - 1, place.vertex].map(|e| strain(&old, e));
            for edge in [place.vertex - 1, place.vertex] {
                let now = strain(&world, edge);
                let range = before.min(after) - 1e-12..=before.max(after) + 1e-12;
                assert!(range.contains(&now), "{now} {range:?}");
            }
        }
        // Bonds hold as much as before: their energies are sums that do not depend on their order.
        let [new, before] = [&world, &old].map(|w| energies(&w.bundle, &w.state));
        assert!((new.bond_shear / before.bond_shear - 1.0).abs() < 1e-9);
        assert!((new.bond_transverse / before.bond_transverse - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_break_between_vertices_is_booked_whole() {
    let mut world = World::new(four_rods(true));
    world.state = shaken(&world.bundle, 9, 0.1);
    world.failure = FailureCriteria {
        between_vertices: true,
        ..FailureCriteria::default()
    };
    world.limit = Some(StabilityLimit {
        limit: 1e-6,
        generation: world.bundle.generation,
        step: world.state.step,
    });
    let old = world.clone();
    let overstressed = |element| Overstressed {
        demand: 1.0,
        element,
    };
    let vertex = weakest(&world, 1);
    let queue = [
        overstressed(Element::Rod(vertex)),
        overstressed(Element::Bond(5)),
    ];
    break_elements(&mut world, &mut NoContacts, &queue);
    assert_eq!(world.bundle.rods(), 5);
    // An edge is shorter than it was, so that the largest stable step is another.
    assert_eq!(world.limit, None);
    assert_eq!(world.bundle.vertices(), old.bundle.vertices() + 1);
    let loss =
        energies(&old.bundle, &old.state).total() - energies(&world.bundle, &world.state).total();
    assert!(
        (loss / world.fracture_loss - 1.0).abs() < 1e-9,
        "{loss} {}",
        world.fracture_loss
    );
    let place = BreakPlace::new(&old.bundle, &old.state, &old.loads, vertex).unwrap();
    assert_eq!(world.events[0].position, place.position(&old.state));
    // The start of a step that is moved along has the same velocity.
    let mut start = old.state.clone();
    move_state(&mut start, &old.bundle, &[place]);
    let velocity = start.velocity.get(place.vertex);
    let between = old
        .state
        .velocity
        .get(place.vertex)
        .lerp(old.state.velocity.get(place.towards), place.fraction);
    assert_eq!(velocity, between);
}
