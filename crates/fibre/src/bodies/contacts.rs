//! [`Contacts`] for [`Bodies`].

use super::contact_point::StepMotion;
use super::state::{BodyState, ContactsState};
use super::system::{Bodies, BodyVelocity};
use crate::contact::{ContactEnergy, ContactSpring, ContactStep, ContactTrial, Contacts};
use crate::error::SolverError;
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use greenstick_geometry::{Cancelled, Context};

impl Contacts for Bodies {
    fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.options.rod_restitution.is_none()
    }

    fn resolve(
        &mut self,
        step: &ContactStep,
        velocity: &mut Vectors,
        context: &Context,
    ) -> Result<Option<f64>, SolverError> {
        let (bundle, state, dt) = (step.bundle, step.state, step.length);
        let end = state.time + dt;
        self.before.clear();
        for body in &mut self.bodies {
            let free = body.inertia.is_some();
            let velocity = |b: &BodyState| BodyVelocity {
                linear: b.velocity,
                angular: b.angular_velocity,
            };
            let before = velocity(&body.state);
            body.update_velocity(end, dt, self.options.gravity);
            let now = velocity(&body.state);
            self.before.push(if free { before } else { now });
        }
        self.contacts.clear();
        let motion = Some(StepMotion {
            velocity: &*velocity,
            step: dt,
        });
        if !self.bodies.is_empty() {
            self.update_near_edges(bundle, state, context)?;
            self.gather_bodies(bundle, state, motion, context)?;
            self.gather_between_bodies();
        }
        if self.options.rod_restitution.is_some() {
            let (radius, contacts) = (&self.radius, &mut self.contacts);
            self.rods
                .gather(bundle, state, radius, motion, contacts, context)?;
        }
        let count = self.ledger.impulses;
        let given = self.resolve_by_impulses(state, velocity, dt, context)?;
        for body in &mut self.bodies {
            body.update_position(end, dt);
        }
        Ok((self.ledger.impulses > count).then_some(given))
    }

    fn find_springs(
        &mut self,
        trial: &ContactTrial,
        context: &Context,
        found: &mut Vec<ContactSpring>,
    ) -> Result<(), Cancelled> {
        self.find_overlap_springs(trial, context, found)
    }

    fn accept(&mut self, start: &State, time: f64, springs: &[ContactSpring]) -> ContactEnergy {
        self.account_springs(start, time, springs)
    }

    fn stored_energy(&self) -> f64 {
        self.ledger.stored
    }

    fn vertices_renumbered(&mut self, bundle: &RodBundle, before: &[u32]) {
        let held: Vec<bool> = self.inverse_mass.iter().map(|w| *w == 0.0).collect();
        self.rods.renumber(before);
        self.take_bundle(bundle);
        for (v, &b) in before.iter().enumerate() {
            if held.get(b as usize) == Some(&true) {
                self.inverse_mass[v] = 0.0;
            }
        }
    }

    fn body_energy(&self) -> f64 {
        self.energy()
    }

    fn snapshot(&self) -> ContactsState {
        ContactsState {
            bodies: self.checkpoint(),
            impulses: self.given.clone(),
        }
    }

    fn restore(&mut self, saved: &ContactsState, bundle: &RodBundle, loads: &Loads) {
        self.restore_state(saved, bundle, loads);
    }
}
