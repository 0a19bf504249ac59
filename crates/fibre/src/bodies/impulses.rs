//! Contacts of a step resolved by impulses (Sutherland 2012 §4.3: elastic collisions, rechecked until none is left or a
//! limit is reached).
//!
//! Impulses act on velocities before positions move on, as the forces of the step do (Moreau 1988). A rod that is pressed
//! against a body therefore gets from it what presses it, step by step, and neither moves nor loses energy. Over a step of
//! symplectic Euler an impulse J does the work J·(v before the step + v after it)/2; with that, what contacts take and give
//! closes the energy balance exactly.

use super::contact_point::{ContactPoint, Side};
use super::system::Bodies;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Time in which an overlap beyond the tolerance is pushed out, s: slow against a step, so that it adds no energy to speak of.
const OVERLAP_RECOVERY_TIME: f64 = 2e-3;
/// Passes over the contacts of a step: the thesis's limit. Collisions between few parts need two.
const MAX_PASSES: usize = 12;
/// Change of velocity that counts as none, m/s.
const NEGLIGIBLE_VELOCITY: f64 = 1e-12;

/// Restitution and friction of a contact.
struct ContactMaterial {
    restitution: f64,
    friction: f64,
}

impl Bodies {
    /// Resolves all contacts of a step, at whose start velocities were those of `state`. Returns the energy that this gives to
    /// rods and free bodies, J.
    pub(super) fn resolve_by_impulses(
        &mut self,
        state: &State,
        velocity: &mut Vectors,
        step: f64,
        context: &Context,
    ) -> Result<f64, Cancelled> {
        self.impulses.clear();
        self.impulses.resize(self.contacts.len(), DVec3::ZERO);
        self.target_velocity.clear();
        for k in 0..self.contacts.len() {
            let target = self.target_velocity(&self.contacts[k], velocity, step);
            self.target_velocity.push(target);
        }
        for _ in 0..MAX_PASSES {
            context.check()?;
            let mut changed = false;
            for k in 0..self.contacts.len() {
                changed |= self.resolve_contact(k, velocity);
            }
            if !changed {
                break;
            }
        }
        Ok(self.account_impulses(state, velocity))
    }

    /// Enters the energy of all impulses of the step into the ledger.
    fn account_impulses(&mut self, state: &State, velocity: &Vectors) -> f64 {
        let mut given = 0.0;
        for k in 0..self.contacts.len() {
            let (contact, impulse) = (self.contacts[k], self.impulses[k]);
            if impulse == DVec3::ZERO {
                continue;
            }
            let after = self.relative_velocity(&contact, velocity);
            let before = self.relative_velocity_before(&contact, state);
            let dissipated = -0.5 * impulse.dot(before + after);
            let driven = |side: Side| match side {
                Side::Body(b) => {
                    let body = &self.bodies[b as usize];
                    body.is_driven()
                        .then(|| impulse.dot(body.velocity_at(contact.point)))
                }
                Side::Edge { .. } => None,
            };
            let mut work = 0.0;
            work += driven(contact.second).unwrap_or(0.0);
            work -= driven(contact.first).unwrap_or(0.0);
            self.ledger.dissipated += dissipated;
            self.ledger.work += work;
            given += work - dissipated;
        }
        given
    }

    /// Returns the velocity of the first side relative to the second, m/s.
    fn relative_velocity(&self, c: &ContactPoint, velocity: &Vectors) -> DVec3 {
        let body = |b: usize| self.bodies[b].velocity_at(c.point);
        side_velocity(c.first, velocity, &body) - side_velocity(c.second, velocity, &body)
    }

    /// Returns the same at the start of the step. Driven bodies have one velocity all through it.
    fn relative_velocity_before(&self, c: &ContactPoint, state: &State) -> DVec3 {
        let body = |b: usize| {
            let (centre, before) = (self.bodies[b].state.centre, self.before[b]);
            before.linear + before.angular.cross(c.point - centre)
        };
        let velocity = &state.velocity;
        side_velocity(c.first, velocity, &body) - side_velocity(c.second, velocity, &body)
    }

    /// Returns the inverse of the effective mass of a contact along `n`: the change of the relative velocity by a unit impulse,
    /// 1/kg.
    fn inverse_effective_mass(&self, c: &ContactPoint, n: DVec3) -> f64 {
        let of_side = |side: Side| match side {
            Side::Edge { edge, t } => {
                let j = edge as usize;
                self.inverse_mass[j] * (1.0 - t) * (1.0 - t) + self.inverse_mass[j + 1] * t * t
            }
            Side::Body(b) => self.bodies[b as usize].inverse_effective_mass(c.point, n),
        };
        of_side(c.first) + of_side(c.second)
    }

    fn material(&self, c: &ContactPoint) -> ContactMaterial {
        let of_body = |b: u32| &self.bodies[b as usize].body;
        match (c.first, c.second) {
            (Side::Body(a), Side::Body(b)) => {
                let (one, two) = (of_body(a), of_body(b));
                ContactMaterial {
                    restitution: one.restitution.min(two.restitution),
                    friction: (one.friction * two.friction).sqrt(),
                }
            }
            (_, Side::Body(b)) => ContactMaterial {
                restitution: of_body(b).restitution,
                friction: of_body(b).friction,
            },
            (_, Side::Edge { .. }) => ContactMaterial {
                restitution: self.options.rod_restitution.unwrap_or(0.0),
                friction: 0.0,
            },
        }
    }

    /// Returns the least relative velocity along the normal at the end of the step, m/s.
    fn target_velocity(&self, c: &ContactPoint, velocity: &Vectors, step: f64) -> f64 {
        let approach = self.relative_velocity(c, velocity).dot(c.normal);
        let bounce = -self.material(c).restitution * approach;
        if c.depth < 0.0 {
            // A gap may close.
            bounce.max(c.depth / step)
        } else {
            let recovery_time = OVERLAP_RECOVERY_TIME.max(4.0 * step);
            bounce.max((c.depth - c.slop).max(0.0) / recovery_time)
        }
    }

    /// Brings one contact to its target velocity. Returns whether that changed anything. What the contact has pushed in the
    /// step so far may be taken back where its neighbours push as well, but it never pulls (projected Gauss–Seidel; Catto
    /// 2005, *Iterative Dynamics with Temporal Coherence*).
    fn resolve_contact(&mut self, k: usize, velocity: &mut Vectors) -> bool {
        let c = self.contacts[k];
        let inverse_mass = self.inverse_effective_mass(&c, c.normal);
        if inverse_mass <= 0.0 {
            return false;
        }
        let approach = self.relative_velocity(&c, velocity).dot(c.normal);
        let before = self.impulses[k].dot(c.normal).max(0.0);
        let pressure = (before + (self.target_velocity[k] - approach) / inverse_mass).max(0.0);
        let mut changed = (pressure - before).abs() * inverse_mass > NEGLIGIBLE_VELOCITY;
        if changed {
            self.apply_impulse(k, c.normal * (pressure - before), velocity);
        }
        let friction = self.material(&c).friction;
        if friction > 0.0 && pressure > 0.0 {
            let u = self.relative_velocity(&c, velocity);
            let slide = u - c.normal * u.dot(c.normal);
            let tangential = self.impulses[k].reject_from_normalized(c.normal);
            let sticking = slide.try_normalize().map_or(tangential, |way| {
                tangential - slide / self.inverse_effective_mass(&c, way)
            });
            let change = sticking.clamp_length_max(friction * pressure) - tangential;
            if change.length() * inverse_mass > NEGLIGIBLE_VELOCITY {
                changed = true;
                self.apply_impulse(k, change, velocity);
            }
        }
        changed
    }

    fn apply_impulse(&mut self, k: usize, impulse: DVec3, velocity: &mut Vectors) {
        let c = self.contacts[k];
        self.impulses[k] += impulse;
        self.ledger.impulses += 1;
        for (side, impulse) in [(c.first, impulse), (c.second, -impulse)] {
            match side {
                Side::Edge { edge, t } => {
                    let j = edge as usize;
                    velocity.add(j, impulse * ((1.0 - t) * self.inverse_mass[j]));
                    velocity.add(j + 1, impulse * (t * self.inverse_mass[j + 1]));
                }
                Side::Body(b) => self.push_body(b as usize, c.point, impulse),
            }
        }
    }

    fn push_body(&mut self, body: usize, point: DVec3, impulse: DVec3) {
        self.bodies[body].apply_impulse(point, impulse);
        let arm = point - self.bodies[body].state.centre;
        let given = &mut self.given[body];
        given.linear += impulse;
        given.angular += arm.cross(impulse);
    }
}

/// Returns the velocity of one side of a contact, from velocities of vertices and of bodies at the contact.
fn side_velocity(side: Side, velocity: &Vectors, body: &dyn Fn(usize) -> DVec3) -> DVec3 {
    match side {
        Side::Edge { edge, t } => {
            let j = edge as usize;
            velocity.get(j) * (1.0 - t) + velocity.get(j + 1) * t
        }
        Side::Body(b) => body(b as usize),
    }
}
