//! Breaking of overstressed rods and bonds, with its record in the world's events.

use super::break_place::{BreakPlace, corner_energy, move_breaks};
use super::criteria::BondCriterion;
use super::demand::{Element, FailureDetector, Overstressed, bonds_in, rod_demand, rods_in};
use super::yielding::yield_rods;
use crate::contact::Contacts;
use crate::energy;
use crate::evaluator::ForceEvaluator;
use crate::event::{Cause, Event, EventKind};
use crate::topology;
use crate::world::World;

/// Finds what fails in the world's state and lets it fail, in a fixed order. Returns whether anything broke, so that the
/// bundle has changed.
pub(crate) fn check_after_step(
    world: &mut World,
    contacts: &mut dyn Contacts,
    evaluator: &mut ForceEvaluator,
    detector: &mut FailureDetector,
) -> bool {
    let failure = world.failure;
    let interval = u64::from(failure.check_interval.max(1));
    if !world.state.step.is_multiple_of(interval) {
        return false;
    }
    if failure.rods_yield {
        world.fracture_loss += yield_rods(&world.bundle, &mut world.state, &mut world.events);
    }
    detector.detect(&failure, &world.bundle, &world.state, evaluator);
    if detector.queue.is_empty() {
        return false;
    }
    break_elements(world, contacts, &detector.queue);
    true
}

/// Breaks all elements of `queue`, records it, and renumbers whatever names a vertex. Returns for each vertex of the bundle
/// its number before.
pub(crate) fn break_elements(
    world: &mut World,
    contacts: &mut dyn Contacts,
    queue: &[Overstressed],
) -> Vec<u32> {
    record_breaks(world, queue);
    let splits = rods_in(queue);
    let placed = place_breaks(world, bonds_in(queue), &splits);
    remove_elements(world, contacts, placed.bonds, splits)
}

/// Breaks whose vertices were moved to their places.
pub(crate) struct PlacedBreaks {
    /// The vertices that were moved.
    pub places: Vec<BreakPlace>,
    /// Bonds that are still to be removed.
    pub bonds: Vec<u32>,
}

/// Moves the vertices at which rods are about to break to where the demand along the rods is greatest, where the criteria
/// say so. As that renumbers bonds, the broken ones are removed before.
pub(crate) fn place_breaks(world: &mut World, mut bonds: Vec<u32>, splits: &[u32]) -> PlacedBreaks {
    if !world.failure.between_vertices || splits.is_empty() {
        return PlacedBreaks {
            places: Vec::new(),
            bonds,
        };
    }
    bonds.sort_unstable();
    topology::break_up(
        &mut world.bundle,
        &mut world.state,
        &mut world.loads,
        &bonds,
        &[],
    );
    PlacedBreaks {
        places: move_breaks(world, splits),
        bonds: Vec::new(),
    }
}

/// Records that all elements of `queue` break: as events, and as energy lost.
pub(crate) fn record_breaks(world: &mut World, queue: &[Overstressed]) {
    for o in queue {
        let event = match o.element {
            Element::Bond(bond) => bond_event(world, bond as usize, o.demand),
            Element::Rod(vertex) => rod_event(world, vertex as usize, o.demand),
        };
        world.fracture_loss += event.energy;
        world.events.push(event);
    }
}

fn bond_event(world: &World, bond: usize, demand: f64) -> Event {
    let World { bundle, state, .. } = world;
    let (vertex, edge) = (
        bundle.bonds.vertex[bond] as usize,
        bundle.bonds.edge[bond] as usize,
    );
    let (transverse, shear) = energy::bond::energy(bundle, state, bond);
    let (_, d) = energy::bond::vectors(bundle, state, bond);
    Event {
        time: state.time,
        kind: EventKind::BondBroke,
        rod: bundle.parent[bundle.rod_of(vertex)],
        vertex: bundle.origin[vertex],
        other: Some(bundle.parent[bundle.rod_of(edge)]),
        position: state.position.get(vertex) - d * 0.5,
        cause: match world.failure.bonds {
            BondCriterion::Never | BondCriterion::Potential { .. } => Cause::Potential,
            BondCriterion::Griffith => Cause::Griffith,
            BondCriterion::Stress => Cause::Stress,
        },
        demand,
        energy: transverse + shear,
    }
}

fn rod_event(world: &World, vertex: usize, demand: f64) -> Event {
    let World { bundle, state, .. } = world;
    let energy = corner_energy(bundle, state, vertex);
    let rod = bundle.rod_of(vertex);
    let parts = rod_demand(bundle, state, vertex, bundle.diameter[rod]);
    let place = if world.failure.between_vertices {
        BreakPlace::new(bundle, state, &world.loads, vertex as u32)
    } else {
        None
    };
    Event {
        time: state.time,
        kind: EventKind::RodBroke,
        rod: bundle.parent[rod],
        vertex: bundle.origin[vertex],
        other: None,
        position: place.map_or(state.position.get(vertex), |p| p.position(state)),
        cause: if parts.torsion > parts.tension {
            Cause::Torsion
        } else {
            Cause::Tension
        },
        demand,
        energy,
    }
}

/// Removes `bonds`, splits rods at the vertices `splits`, and renumbers whatever names a vertex. Returns for each vertex of
/// the bundle its number before.
pub(crate) fn remove_elements(
    world: &mut World,
    contacts: &mut dyn Contacts,
    mut bonds: Vec<u32>,
    mut splits: Vec<u32>,
) -> Vec<u32> {
    bonds.sort_unstable();
    splits.sort_unstable();
    let before = topology::break_up(
        &mut world.bundle,
        &mut world.state,
        &mut world.loads,
        &bonds,
        &splits,
    );
    contacts.vertices_renumbered(&world.bundle, &before);
    before
}
