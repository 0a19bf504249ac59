//! Yielding of rods in compression.

use crate::energy;
use crate::event::{Cause, Event, EventKind};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::world::World;

/// Lets rods yield: strain beyond the yield strain becomes plastic. Velocities are those of `lag` seconds before, over which the
/// forces from before act. Returns the energy that this dissipates, J.
pub(crate) fn yield_rods(
    bundle: &RodBundle,
    state: &mut State,
    events: &mut Vec<Event>,
    lag: f64,
) -> f64 {
    let mut dissipated = 0.0;
    for j in 0..bundle.vertices() {
        if !bundle.is_edge(j) {
            continue;
        }
        let strain = energy::rod::strain(bundle, state, j);
        let limit = bundle.yield_strain[j];
        if strain >= -limit {
            continue;
        }
        let energy =
            0.5 * bundle.stretch[j] * bundle.rest_length[j] * (strain * strain - limit * limit);
        if state.plastic_strain[j] == 0.0 {
            events.push(yield_event(bundle, state, j, -strain / limit, energy));
        }
        state.plastic_strain[j] += strain + limit;
        let impulse =
            state.edge(j).normalize_or_zero() * (bundle.stretch[j] * (strain + limit) * lag);
        state.velocity.add(j, impulse / bundle.mass[j]);
        state.velocity.add(j + 1, -impulse / bundle.mass[j + 1]);
        dissipated += energy;
    }
    dissipated
}

/// Records the edges of the world that began to yield since `old`, for solvers that find the plastic strain with the
/// equilibrium. Returns the energy that yielding dissipated, J.
pub(crate) fn record_yielding(world: &mut World, old: &State) -> f64 {
    let World {
        bundle,
        state,
        events,
        ..
    } = world;
    let mut dissipated = 0.0;
    for j in 0..bundle.vertices() {
        let more = old.plastic_strain[j] - state.plastic_strain[j];
        if !bundle.is_edge(j) || more == 0.0 {
            continue;
        }
        let limit = bundle.yield_strain[j];
        let energy = bundle.stretch[j] * limit * more * bundle.rest_length[j];
        dissipated += energy;
        if old.plastic_strain[j] == 0.0 {
            let demand = (more - energy::rod::strain(bundle, state, j)) / limit;
            events.push(yield_event(bundle, state, j, demand, energy));
        }
    }
    dissipated
}

fn yield_event(bundle: &RodBundle, state: &State, edge: usize, demand: f64, energy: f64) -> Event {
    let [start, end] = [edge, edge + 1].map(|v| state.position.get(v));
    Event {
        time: state.time,
        kind: EventKind::RodYielded,
        rod: bundle.parent[bundle.rod_of(edge)],
        vertex: bundle.origin[edge],
        other: None,
        position: start.midpoint(end),
        cause: Cause::Compression,
        demand,
        energy,
    }
}
