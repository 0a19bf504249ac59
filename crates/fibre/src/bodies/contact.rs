//! Contacts of a step and the impulses that end them (Sutherland 2012 §4.3: elastic collisions, rechecked until none is
//! left or a limit is met).
//!
//! Impulses act on velocities before places move on, as the forces of the step do (Moreau 1988). So a rod that lies
//! pressed against a body gets from it what presses it, step by step, and neither moves nor loses energy. Over a step of
//! symplectic Euler an impulse J does the work J·(v before the step + v after it)/2: with that, what contacts take and
//! give closes the balance of energy exactly.

use super::{Bodies, PASSES, RECOVERY, SLOP, is_driven};
use crate::bundle::Bundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// What an edge touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Other {
    /// A body.
    Body(u32),
    /// Another rod's edge, at a place on it.
    Edge(u32, f64),
}

/// A contact of a rod's edge, or of two bodies where `edge` is [`NO_EDGE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact {
    pub edge: u32,
    /// Place on the edge, 0 to 1.
    pub t: f64,
    pub other: Other,
    /// Unit direction from the other to the edge.
    pub normal: DVec3,
    /// Where the impulse acts, m.
    pub place: DVec3,
    /// Overlap, m; negative for a gap that closes within the step.
    pub depth: f64,
    /// Overlap that may stay, m.
    pub slop: f64,
    /// Length of the rod that it stands for, m.
    pub share: f64,
}

/// Marks a contact of two bodies; `t` then is the number of the first.
pub(super) const NO_EDGE: u32 = u32::MAX;
/// Most places that are tested on an edge.
const MOST_PLACES: f64 = 8.0;
/// Speed that counts as none, m/s.
const STILL: f64 = 1e-12;
/// Overlap of two bodies that may stay, m.
const BODY_SLOP: f64 = 1e-5;
/// How far ahead of a touch two bodies are asked for, m.
const AHEAD: f64 = 1e-6;

impl Bodies {
    /// Contacts of edges with bodies: at vertices, and between them no further apart than the rod is wide. With velocities,
    /// also those that are to be within `step` s.
    pub(super) fn gather_bodies(
        &mut self,
        bundle: &Bundle,
        state: &State,
        ahead: Option<(&Vectors, f64)>,
    ) {
        for k in 0..self.near.pairs.len() {
            let (edge, number) = self.near.pairs[k];
            let j = edge as usize;
            let radius = self.radius[j];
            let body = &self.bodies[number as usize];
            let (p, e) = (body.local(state.position.get(j)), state.edge(j));
            let along = body.state.turn.conjugate() * e;
            let margin = ahead.map_or(0.0, |(velocity, step)| {
                let of = |v: usize| velocity.get(v) - body.velocity_at(state.position.get(v));
                step * of(j).length().max(of(j + 1).length())
            });
            let reach = radius + margin + 0.5 * along.length();
            if !body.solid.near(p + 0.5 * along, reach) {
                continue;
            }
            let places = (along.length() / (2.0 * radius))
                .ceil()
                .clamp(1.0, MOST_PLACES);
            let last = !bundle.is_edge(j + 1);
            for i in 0..places as usize + usize::from(last) {
                let t = i as f64 / places;
                let q = p + along * t;
                if !body.solid.near(q, radius + margin) {
                    continue;
                }
                let Some((distance, out)) = body.solid.distance(q) else {
                    continue;
                };
                if distance < radius + margin {
                    self.contacts.push(Contact {
                        edge,
                        t,
                        other: Other::Body(number),
                        normal: body.state.turn * out,
                        place: state.position.get(j) + e * t,
                        depth: radius - distance,
                        slop: SLOP * radius,
                        share: along.length() / places,
                    });
                }
            }
        }
    }

    /// Contacts between bodies of which at least one is free.
    pub(super) fn gather_between_bodies(&mut self) {
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                if let Some(m) = self.meeting(a, b, AHEAD) {
                    self.contacts.push(Contact {
                        edge: NO_EDGE,
                        t: a as f64,
                        other: Other::Body(b as u32),
                        normal: -m.normal,
                        place: m.place,
                        depth: m.depth,
                        slop: BODY_SLOP,
                        share: 0.0,
                    });
                }
            }
        }
    }

    /// Ends all contacts of a step, at whose start velocities were those of `state`. Returns the energy that this gave to
    /// rods and free bodies, J.
    pub(super) fn settle(&mut self, state: &State, velocity: &mut Vectors, step: f64) -> f64 {
        self.impulses.clear();
        self.impulses.resize(self.contacts.len(), DVec3::ZERO);
        self.wanted.clear();
        for k in 0..self.contacts.len() {
            let wanted = self.wanted(&self.contacts[k], velocity, step);
            self.wanted.push(wanted);
        }
        for _ in 0..PASSES {
            let mut acted = false;
            for k in 0..self.contacts.len() {
                acted |= self.end(k, velocity);
            }
            if !acted {
                break;
            }
        }
        self.book(state, velocity)
    }

    /// Books the energy of all impulses of the step.
    fn book(&mut self, state: &State, velocity: &Vectors) -> f64 {
        let mut given = 0.0;
        for k in 0..self.contacts.len() {
            let (contact, impulse) = (self.contacts[k], self.impulses[k]);
            if impulse == DVec3::ZERO {
                continue;
            }
            let after = self.relative(&contact, velocity);
            let before = self.relative_before(&contact, state);
            let taken = -0.5 * impulse.dot(before + after);
            let mut work = 0.0;
            if let Other::Body(b) = contact.other {
                let driver = &self.bodies[b as usize];
                if is_driven(&driver.body) {
                    work += impulse.dot(driver.velocity_at(contact.place));
                }
                if contact.edge == NO_EDGE && is_driven(&self.bodies[contact.t as usize].body) {
                    let driver = &self.bodies[contact.t as usize];
                    work -= impulse.dot(driver.velocity_at(contact.place));
                }
            }
            self.ledger.lost += taken;
            self.ledger.work += work;
            given += work - taken;
        }
        given
    }

    /// Velocity at the contact of the edge (or first body) relative to the other, m/s.
    fn relative(&self, c: &Contact, velocity: &Vectors) -> DVec3 {
        let body = |b: usize| self.bodies[b].velocity_at(c.place);
        difference(c, velocity, &body)
    }

    /// The same at the start of the step. Bodies whose motion is given have one velocity all through it.
    fn relative_before(&self, c: &Contact, state: &State) -> DVec3 {
        let body = |b: usize| {
            let moving = &self.bodies[b];
            let (velocity, angular) = self.before[b];
            velocity + angular.cross(c.place - moving.state.centre)
        };
        difference(c, &state.velocity, &body)
    }

    /// What a unit impulse along `n` changes of the relative velocity along it, 1/kg.
    fn yielding(&self, c: &Contact, n: DVec3) -> f64 {
        let of_edge = |j: u32, t: f64| {
            let j = j as usize;
            self.inverse_mass[j] * (1.0 - t) * (1.0 - t) + self.inverse_mass[j + 1] * t * t
        };
        let one = if c.edge == NO_EDGE {
            self.bodies[c.t as usize].yielding(c.place, n)
        } else {
            of_edge(c.edge, c.t)
        };
        one + match c.other {
            Other::Body(b) => self.bodies[b as usize].yielding(c.place, n),
            Other::Edge(j, t) => of_edge(j, t),
        }
    }

    /// Pushes a body, and keeps count of it.
    pub(super) fn push_body(&mut self, body: usize, place: DVec3, impulse: DVec3) {
        self.bodies[body].push(place, impulse);
        let arm = place - self.bodies[body].state.centre;
        let given = &mut self.given[body];
        given.impulse += impulse;
        given.angular += arm.cross(impulse);
    }

    fn push_edge(&self, j: u32, t: f64, impulse: DVec3, velocity: &mut Vectors) {
        let j = j as usize;
        velocity.add(j, impulse * ((1.0 - t) * self.inverse_mass[j]));
        velocity.add(j + 1, impulse * (t * self.inverse_mass[j + 1]));
    }

    /// Restitution and friction of a contact.
    pub(super) fn manner(&self, c: &Contact) -> (f64, f64) {
        let of = |b: usize| {
            let body = &self.bodies[b].body;
            (body.restitution, body.friction)
        };
        match c.other {
            Other::Edge(..) => (self.options.rods.unwrap_or(0.0), 0.0),
            Other::Body(b) if c.edge == NO_EDGE => {
                let (one, two) = (of(c.t as usize), of(b as usize));
                (one.0.min(two.0), (one.1 * two.1).sqrt())
            }
            Other::Body(b) => of(b as usize),
        }
    }

    /// The relative velocity along its normal with which a contact ends the step at least, m/s.
    fn wanted(&self, c: &Contact, velocity: &Vectors, step: f64) -> f64 {
        let approach = self.relative(c, velocity).dot(c.normal);
        let bounce = -self.manner(c).0 * approach;
        if c.depth < 0.0 {
            // A gap may close.
            bounce.max(c.depth / step)
        } else {
            let out = (c.depth - c.slop).max(0.0) / RECOVERY.max(4.0 * step);
            bounce.max(out)
        }
    }

    /// Brings one contact to what is wanted of it; false where it is there. What it has pushed in the step so far may be
    /// taken back where its neighbours push as well, but it never pulls (projected Gauss-Seidel; Catto 2005, Iterative
    /// Dynamics with Temporal Coherence).
    fn end(&mut self, k: usize, velocity: &mut Vectors) -> bool {
        let c = self.contacts[k];
        let give = self.yielding(&c, c.normal);
        if give <= 0.0 {
            return false;
        }
        let approach = self.relative(&c, velocity).dot(c.normal);
        let was = self.impulses[k].dot(c.normal).max(0.0);
        let pressed = (was + (self.wanted[k] - approach) / give).max(0.0);
        let mut acted = (pressed - was).abs() * give > STILL;
        if acted {
            self.apply(k, c.normal * (pressed - was), velocity);
        }
        let friction = self.manner(&c).1;
        if friction > 0.0 && pressed > 0.0 {
            let u = self.relative(&c, velocity);
            let slide = u - c.normal * u.dot(c.normal);
            let rubbed = self.impulses[k].reject_from_normalized(c.normal);
            let still = slide
                .try_normalize()
                .map_or(rubbed, |way| rubbed - slide / self.yielding(&c, way));
            let change = still.clamp_length_max(friction * pressed) - rubbed;
            if change.length() * give > STILL {
                acted = true;
                self.apply(k, change, velocity);
            }
        }
        acted
    }

    fn apply(&mut self, k: usize, impulse: DVec3, velocity: &mut Vectors) {
        let c = self.contacts[k];
        self.impulses[k] += impulse;
        self.ledger.impulses += 1;
        if c.edge == NO_EDGE {
            self.push_body(c.t as usize, c.place, impulse);
        } else {
            self.push_edge(c.edge, c.t, impulse, velocity);
        }
        match c.other {
            Other::Body(b) => self.push_body(b as usize, c.place, -impulse),
            Other::Edge(j, t) => self.push_edge(j, t, -impulse, velocity),
        }
    }
}

/// Velocity of the edge (or first body) of a contact relative to the other, from velocities of vertices and of bodies at
/// the contact.
fn difference(c: &Contact, velocity: &Vectors, body: &dyn Fn(usize) -> DVec3) -> DVec3 {
    let of_edge = |j: u32, t: f64| {
        let j = j as usize;
        velocity.get(j) * (1.0 - t) + velocity.get(j + 1) * t
    };
    let one = if c.edge == NO_EDGE {
        body(c.t as usize)
    } else {
        of_edge(c.edge, c.t)
    };
    one - match c.other {
        Other::Body(b) => body(b as usize),
        Other::Edge(j, t) => of_edge(j, t),
    }
}
