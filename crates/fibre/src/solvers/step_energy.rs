//! The energy of a step of implicit Euler, each part by itself, so that their sum is a check.
//!
//! With M (v₁ − v₀)/h = F(x₁) and x₁ − x₀ = h v₁, the kinetic energy grows by the work F(x₁)·(x₁ − x₀) less ½ M |v₁ − v₀|²,
//! and the potential V falls by the work of its force at the end, F_V(x₁)·(x₁ − x₀), and the gap V(x₀) − V(x₁) −
//! F_V(x₁)·(x₁ − x₀), which is positive where V is convex. Both are what the method takes from the motion (Hairer, Lubich
//! and Wanner, *Geometric Numerical Integration*, chapter IX has the method as a system that loses energy). What is left of
//! the balance is the work of forces that Newton's method leaves unbalanced.

use super::newton::{Equilibrium, Newton};
use crate::contact::{ContactSpring, Contacts};
use crate::failure::breaking::take_damage;
use crate::failure::yielding::record_yielding;
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::world::World;
use std::ops::AddAssign;

/// Energy of a step, J.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StepEnergy {
    /// Work of loads and clamps.
    pub work: f64,
    /// Dissipated by damping.
    pub damped: f64,
    /// Taken from the motion by the method.
    pub dissipated: f64,
}

impl AddAssign for StepEnergy {
    fn add_assign(&mut self, other: Self) {
        self.work += other.work;
        self.damped += other.damped;
        self.dissipated += other.dissipated;
    }
}

impl StepEnergy {
    /// Ends a step of `dt` from the world's state with the equilibrium `found` by `newton`.
    pub fn accept(
        world: &mut World,
        contacts: &mut dyn Contacts,
        newton: &mut Newton,
        found: Equilibrium,
        dt: f64,
    ) -> Self {
        let stored = newton.energies(&world.bundle, &world.state).potential();
        let stored = stored + contacts.stored_energy();
        let Equilibrium {
            state,
            reaction,
            springs,
            softened,
            ..
        } = found;
        let bundle = &world.bundle;
        let mut internal = Forces::zeros(bundle.vertices());
        newton.internal_forces(bundle, &state, &mut internal);
        let mut external = reaction;
        let (x, v) = (&state.position, &state.velocity);
        (world.loads).add_forces(bundle, state.time + dt, x, v, &mut external);
        let old = std::mem::replace(&mut world.state, state);
        let work = work_between(bundle, &old, &world.state, &external);
        let mut given = work_between(bundle, &old, &world.state, &internal);
        given += contact_work(&old, &world.state, &springs);
        let inertia_loss = set_velocities(world, &old, dt);
        let yielded = record_yielding(world, &old);
        let lost = yielded + take_damage(world, &softened);
        world.fracture_loss += lost;
        let contact = contacts.accept(&old, world.state.time, &springs);
        let after = newton.energies(&world.bundle, &world.state).potential() + contact.stored;
        let gap = stored + contact.work - contact.dissipated - lost - after - given;
        StepEnergy {
            work,
            damped: damping_power(world) * dt,
            dissipated: inertia_loss + gap,
        }
    }
}

/// Sets the velocities at the end of a step of `dt` from `old`, and its time. Returns half the mass times the square of their
/// change, J.
fn set_velocities(world: &mut World, old: &State, dt: f64) -> f64 {
    let World { bundle, state, .. } = world;
    let mut loss = 0.0;
    for v in 0..bundle.vertices() {
        let velocity = (state.position.get(v) - old.position.get(v)) / dt;
        let spin = (state.angle[v] - old.angle[v]) / dt;
        let change = velocity - old.velocity.get(v);
        loss += 0.5 * bundle.mass[v] * change.length_squared();
        if bundle.twisting {
            loss += 0.5 * bundle.inertia[v] * (spin - old.spin[v]).powi(2);
        }
        state.velocity.set(v, velocity);
        state.spin[v] = spin;
    }
    state.time = old.time + dt;
    state.step = old.step + 1;
    loss
}

/// Returns the work of forces on the way from one state to another, J.
pub(super) fn work_between(bundle: &RodBundle, from: &State, to: &State, forces: &Forces) -> f64 {
    let mut work = 0.0;
    for v in 0..bundle.vertices() {
        let way = to.position.get(v) - from.position.get(v);
        work += forces.linear.get(v).dot(way);
        if bundle.twisting {
            work += forces.moment[v] * (to.angle[v] - from.angle[v]);
        }
    }
    work
}

/// Returns the work of contacts on rods, J.
pub(super) fn contact_work(from: &State, to: &State, springs: &[ContactSpring]) -> f64 {
    let mut work = 0.0;
    for spring in springs {
        for (v, share) in spring.shares() {
            let way = to.position.get(v) - from.position.get(v);
            work += share * spring.force.dot(way);
        }
    }
    work
}

/// Returns the power of damping, W.
fn damping_power(world: &World) -> f64 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let twice_kinetic = (0..bundle.vertices()).fold(0.0, |sum, v| {
        let linear = bundle.mass[v] * state.velocity.get(v).length_squared();
        let spin = if bundle.twisting {
            bundle.inertia[v] * state.spin[v] * state.spin[v]
        } else {
            0.0
        };
        sum + linear + spin
    });
    loads.damping * twice_kinetic
}
