//! Breaking of overstressed rods and bonds, with its record in the world's events.

use super::break_place::{BreakPlace, corner_energy, move_breaks};
use super::cohesion::{FAILED, Softening};
use super::criteria::BondCriterion;
use super::demand::{Element, FailureDetector, Overstressed, bonds_in, rod_demand, rods_in};
use super::yielding::yield_rods;
use crate::contact::Contacts;
use crate::energy;
use crate::evaluator::ForceEvaluator;
use crate::event::{Cause, Event, EventKind};
use crate::forces::Forces;
use crate::topology;
use crate::world::World;
use glam::DVec3;

/// Finds what fails in the world's state after a step of `step` seconds of symplectic Euler, and lets it fail, in a fixed order.
/// Returns whether anything broke, so that the bundle has changed.
///
/// Velocities are half a step behind positions. What breaks, breaks in between: the forces before it act over the first half
/// of the step around it and those after it over the second, without which a break adds the work of its force over half a step.
pub(crate) fn check_after_step(
    world: &mut World,
    contacts: &mut dyn Contacts,
    step: f64,
    evaluator: &mut ForceEvaluator,
    detector: &mut FailureDetector,
) -> bool {
    let failure = world.failure;
    let interval = u64::from(failure.check_interval.max(1));
    if !world.state.step.is_multiple_of(interval) {
        return false;
    }
    if failure.rods_yield {
        let World {
            bundle,
            state,
            events,
            ..
        } = &mut *world;
        world.fracture_loss += yield_rods(bundle, state, events, 0.5 * step);
    }
    detector.detect(&failure, &world.bundle, &world.state, evaluator);
    if detector.queue.is_empty() {
        return false;
    }
    let softened = soften(world, &mut detector.queue, 0.5 * step);
    for bond in softened {
        let damage = world.bundle.bonds.damage[bond as usize];
        evaluator.set_bond_damage(&world.bundle, bond, damage);
    }
    if detector.queue.is_empty() {
        return false;
    }
    kick(world, evaluator, 0.5 * step);
    break_elements(world, contacts, &detector.queue);
    kick(world, evaluator, -0.5 * step);
    true
}

/// Lets the present forces, that of damping among them, act over a time (s), which may be negative, on all that no clamp holds.
pub(crate) fn kick(world: &mut World, evaluator: &mut ForceEvaluator, time: f64) {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let mut forces = Forces::zeros(bundle.vertices());
    evaluator.forces(bundle, state, &mut forces);
    let (x, v) = (&state.position, &state.velocity);
    loads.add_forces(bundle, state.time, x, v, &mut forces);
    let damping = loads.damping;
    let damping_factor = 1.0 / (1.0 + damping * time);
    for v in 0..bundle.vertices() {
        let force = forces.linear.get(v) - state.velocity.get(v) * (damping * bundle.mass[v]);
        forces.linear.set(v, force * damping_factor);
        let moment = forces.moment[v] - state.spin[v] * (damping * bundle.inertia[v]);
        forces.moment[v] = moment * damping_factor;
    }
    for clamp in &loads.clamps {
        for &v in &clamp.vertices {
            let free = DVec3::from_array(clamp.axes.map(|held| f64::from(u8::from(!held))));
            let force = forces.linear.get(v as usize);
            forces.linear.set(v as usize, force * free);
        }
        for &e in &clamp.edges {
            forces.moment[e as usize] = 0.0;
        }
    }
    for v in 0..bundle.vertices() {
        let change = forces.linear.get(v) * (time / bundle.mass[v]);
        state.velocity.add(v, change);
        if bundle.twisting && bundle.is_edge(v) {
            state.spin[v] += forces.moment[v] * time / bundle.inertia[v];
        }
    }
}

/// Takes over the damage of bonds that have softened in an equilibrium, which is the world's state. Returns the energy that this
/// takes, J.
pub(crate) fn take_damage(world: &mut World, softened: &[(u32, f64)]) -> f64 {
    let mut lost = 0.0;
    for &(bond, damage) in softened {
        let number = bond as usize;
        let softening = Softening::new(&world.bundle, &world.state, number);
        let before = std::mem::replace(&mut world.bundle.bonds.damage[number], damage);
        lost += softening.dissipated(damage) - softening.dissipated(before);
    }
    lost
}

/// Adds to `queue` the cohesive bonds that have softened to their end.
pub(crate) fn find_softened_bonds(world: &World, queue: &mut Vec<Overstressed>) {
    let damage = world.bundle.bonds.damage.iter().enumerate();
    let failed = damage.filter(|(_, damage)| **damage >= FAILED);
    queue.extend(failed.map(|(bond, _)| Overstressed {
        // Their traction is the law's at all times.
        demand: 1.0,
        element: Element::Bond(bond as u32),
    }));
}

/// Softens the cohesive bonds of `queue`, and leaves in it what breaks. Returns the bonds that have softened. Velocities are
/// those of `lag` seconds before, over which the forces from before act.
fn soften(world: &mut World, queue: &mut Vec<Overstressed>, lag: f64) -> Vec<u32> {
    let mut softened = Vec::new();
    if world.failure.bonds != BondCriterion::Cohesive {
        return softened;
    }
    let World { bundle, state, .. } = world;
    queue.retain(|o| {
        let Element::Bond(bond) = o.element else {
            return true;
        };
        let softening = Softening::new(bundle, state, bond as usize);
        if softening.has_failed() {
            return true;
        }
        let number = bond as usize;
        let growth = softening.damage() - bundle.bonds.damage[number];
        if growth > 0.0 {
            let before = energy::bond::forces(bundle, state, number);
            bundle.bonds.damage[number] += growth;
            let after = energy::bond::forces(bundle, state, number);
            let edge = bundle.bonds.edge[number] as usize;
            let x = bundle.bonds.vertex[number] as usize;
            for (v, force) in [
                (x, before.0 - after.0),
                (edge, before.1 - after.1),
                (edge + 1, before.2 - after.2),
            ] {
                state.velocity.add(v, force * (lag / bundle.mass[v]));
            }
            world.fracture_loss += growth * softening.undamaged_energy;
            softened.push(bond);
        }
        false
    });
    softened
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
    let bonds = place_breaks(world, bonds_in(queue), &splits);
    remove_elements(world, contacts, bonds, splits)
}

/// Moves the vertices at which rods are about to break to where the demand along the rods is greatest, where the criteria
/// say so. As that renumbers bonds, the broken ones are removed before. Returns those that are still to be removed.
fn place_breaks(world: &mut World, mut bonds: Vec<u32>, splits: &[u32]) -> Vec<u32> {
    if !world.failure.between_vertices || splits.is_empty() {
        return bonds;
    }
    bonds.sort_unstable();
    topology::break_up(
        &mut world.bundle,
        &mut world.state,
        &mut world.loads,
        &bonds,
        &[],
    );
    move_breaks(world, splits);
    Vec::new()
}

/// Records that all elements of `queue` break: as events, and as energy lost.
fn record_breaks(world: &mut World, queue: &[Overstressed]) {
    for o in queue {
        let event = match o.element {
            Element::Bond(bond) => bond_event(world, bond as usize, o.demand),
            Element::Rod(vertex) => rod_event(world, vertex as usize, o.demand),
        };
        world.fracture_loss += match (o.element, world.failure.bonds) {
            // What it took before it broke is booked as it softened.
            (Element::Bond(bond), BondCriterion::Cohesive) => {
                let (transverse, shear) =
                    energy::bond::energy(&world.bundle, &world.state, bond as usize);
                transverse + shear
            }
            _ => event.energy,
        };
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
    let softening = Softening::new(bundle, state, bond);
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
            BondCriterion::Cohesive if softening.slip_share > 0.5 => Cause::Shear,
            BondCriterion::Cohesive => Cause::Cohesive,
        },
        demand,
        energy: match world.failure.bonds {
            BondCriterion::Cohesive => softening.fracture_energy,
            _ => transverse + shear,
        },
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
fn remove_elements(
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
