//! Contacts as penalty springs, for solvers that look for equilibrium: an overlap has an energy, so that contacts are a potential
//! like all others ([`super::crushing`]). The stiffness is that of wood across the grain over the length in contact.
//!
//! Friction is Coulomb's, over the distance slid since the step began. Below [`FULL_FRICTION_SLIDE`] of a rod's radius it
//! grows in proportion to the distance, so that it has a stiffness too.

use super::contact_point::{ContactPoint, Side};
use super::crushing::Overlap;
use super::system::Bodies;
use crate::contact::{ContactEnergy, ContactSpring, ContactTrial};
use crate::state::State;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Distance slid at which friction is complete, in radii of the rod.
const FULL_FRICTION_SLIDE: f64 = 2e-3;

impl Bodies {
    /// Moves driven bodies to where they are at `time`, a step after `start`.
    fn move_driven_bodies(&mut self, start: &State, time: f64) {
        for body in self.bodies.iter_mut().filter(|b| b.is_driven()) {
            body.update_velocity(time, time - start.time, DVec3::ZERO);
            body.update_position(time, time - start.time);
        }
    }

    /// Sets `found` to the springs of all overlaps of a trial state.
    pub(super) fn find_overlap_springs(
        &mut self,
        trial: &ContactTrial,
        context: &Context,
        found: &mut Vec<ContactSpring>,
    ) -> Result<(), Cancelled> {
        found.clear();
        self.move_driven_bodies(trial.start, trial.time);
        self.contacts.clear();
        let (bundle, state) = (trial.bundle, trial.state);
        if !self.bodies.is_empty() {
            self.update_near_edges(bundle, state, context)?;
            self.gather_bodies(bundle, state, None, context)?;
        }
        if self.options.rod_restitution.is_some() {
            let (radius, contacts) = (&self.radius, &mut self.contacts);
            self.rods
                .gather(bundle, state, radius, None, contacts, context)?;
        }
        for contact in &self.contacts {
            found.extend(self.spring(contact, trial));
        }
        Ok(())
    }

    fn spring(&self, c: &ContactPoint, trial: &ContactTrial) -> Option<ContactSpring> {
        let Side::Edge { edge, t } = c.first else {
            return None;
        };
        let (state, start) = (trial.state, trial.start);
        let j = edge as usize;
        let mut stiffness = self.side_stiffness[j] * c.length;
        let mut strength = self.side_strength[j] * c.length;
        let (mut coefficient, mut slide, mut body, mut other) = (0.0, DVec3::ZERO, None, None);
        match c.second {
            Side::Body(b) => {
                let moving = &self.bodies[b as usize];
                coefficient = moving.body.friction;
                let way = |v: usize| state.position.get(v) - start.position.get(v);
                let moved = way(j) * (1.0 - t) + way(j + 1) * t;
                slide = moved - moving.velocity_at(c.point) * (trial.time - start.time);
                slide -= c.normal * slide.dot(c.normal);
                body = Some(b);
            }
            Side::Edge { edge: e, t: s } => {
                // Two springs in series.
                stiffness *= self.side_stiffness[e as usize]
                    / (self.side_stiffness[j] + self.side_stiffness[e as usize])
                        .max(f64::MIN_POSITIVE);
                strength = strength.min(self.side_strength[e as usize] * c.length);
                other = Some((e, s));
            }
        }
        let overlap = Overlap::new(stiffness, strength, self.radius[j], c.depth);
        let tangential_stiffness =
            coefficient * overlap.force / slide.length().max(FULL_FRICTION_SLIDE * self.radius[j]);
        Some(ContactSpring {
            edge,
            t,
            other,
            body,
            point: c.point,
            normal: c.normal,
            force: c.normal * overlap.force - slide * tangential_stiffness,
            normal_stiffness: overlap.stiffness,
            tangential_stiffness,
            energy: overlap.energy,
            friction_loss: tangential_stiffness * slide.length_squared(),
        })
    }

    /// Ends a step from `start` to `time` whose contacts are `springs`, and enters their energy into the ledger.
    pub(super) fn account_springs(
        &mut self,
        start: &State,
        time: f64,
        springs: &[ContactSpring],
    ) -> ContactEnergy {
        self.move_driven_bodies(start, time);
        let step = time - start.time;
        let mut energy = ContactEnergy::default();
        let mut power = 0.0;
        for spring in springs {
            energy.stored += spring.energy;
            energy.dissipated += spring.friction_loss;
            if let Some(b) = spring.body.map(|b| b as usize) {
                let moving = &self.bodies[b];
                if moving.is_driven() {
                    power += spring.force.dot(moving.velocity_at(spring.point));
                }
                let arm = spring.point - moving.state.centre;
                let impulse = spring.force * -step;
                self.given[b].linear += impulse;
                self.given[b].angular += arm.cross(impulse);
            }
        }
        // The trapezoidal rule over the step.
        energy.work = 0.5 * step * (self.ledger.power + power);
        self.ledger.work += energy.work;
        self.ledger.dissipated += energy.dissipated;
        if step > 0.0 {
            self.ledger.power = power;
        }
        self.ledger.stored = energy.stored;
        energy
    }
}
