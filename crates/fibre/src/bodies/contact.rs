//! Contacts of a step and the impulses that end them (Sutherland 2012 §4.3: elastic collisions, rechecked until none is
//! left or a limit is met).

use super::{Bodies, PASSES, RECOVERY, SLOP, is_driven};
use crate::bundle::Bundle;
use crate::state::State;
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
    /// Overlap, m.
    pub depth: f64,
    /// Overlap that may stay, m.
    pub slop: f64,
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
    /// Contacts of edges with bodies: at vertices, and between them no further apart than the rod is wide.
    pub(super) fn gather_bodies(&mut self, bundle: &Bundle, state: &State) {
        for k in 0..self.near.pairs.len() {
            let (edge, number) = self.near.pairs[k];
            let j = edge as usize;
            let radius = self.radius[j];
            let body = &self.bodies[number as usize];
            let (p, e) = (body.local(state.position.get(j)), state.edge(j));
            let along = body.state.turn.conjugate() * e;
            let reach = radius + 0.5 * along.length();
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
                if !body.solid.near(q, radius) {
                    continue;
                }
                let Some((distance, out)) = body.solid.distance(q) else {
                    continue;
                };
                if distance < radius {
                    self.contacts.push(Contact {
                        edge,
                        t,
                        other: Other::Body(number),
                        normal: body.state.turn * out,
                        place: state.position.get(j) + e * t,
                        depth: radius - distance,
                        slop: SLOP * radius,
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
                    });
                }
            }
        }
    }

    /// Ends all contacts of this step.
    pub(super) fn settle(&mut self, state: &mut State, step: f64) {
        for _ in 0..PASSES {
            let mut acted = false;
            for k in 0..self.contacts.len() {
                let contact = self.contacts[k];
                acted |= self.end(&contact, state, step);
            }
            if !acted {
                break;
            }
        }
    }

    /// Velocity at the contact of the edge (or first body) relative to the other, m/s.
    fn relative(&self, c: &Contact, state: &State) -> DVec3 {
        let (one, _) = self.velocities(c, state);
        one - self.velocities(c, state).1
    }

    fn velocities(&self, c: &Contact, state: &State) -> (DVec3, DVec3) {
        let of_edge = |j: u32, t: f64| {
            let j = j as usize;
            state.velocity.get(j) * (1.0 - t) + state.velocity.get(j + 1) * t
        };
        let one = if c.edge == NO_EDGE {
            self.bodies[c.t as usize].velocity_at(c.place)
        } else {
            of_edge(c.edge, c.t)
        };
        let two = match c.other {
            Other::Body(b) => self.bodies[b as usize].velocity_at(c.place),
            Other::Edge(j, t) => of_edge(j, t),
        };
        (one, two)
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
    fn push_body(&mut self, body: usize, place: DVec3, impulse: DVec3) {
        self.bodies[body].push(place, impulse);
        let arm = place - self.bodies[body].state.centre;
        let given = &mut self.given[body];
        given.impulse += impulse;
        given.angular += arm.cross(impulse);
    }

    fn push(&mut self, c: &Contact, impulse: DVec3, state: &mut State) {
        if c.edge == NO_EDGE {
            self.push_body(c.t as usize, c.place, impulse);
        } else {
            self.push_edge(c.edge, c.t, impulse, state);
        }
        match c.other {
            Other::Body(b) => self.push_body(b as usize, c.place, -impulse),
            Other::Edge(j, t) => self.push_edge(j, t, -impulse, state),
        }
    }

    fn push_edge(&self, j: u32, t: f64, impulse: DVec3, state: &mut State) {
        let j = j as usize;
        state
            .velocity
            .add(j, impulse * ((1.0 - t) * self.inverse_mass[j]));
        state
            .velocity
            .add(j + 1, impulse * (t * self.inverse_mass[j + 1]));
    }

    /// Restitution and friction of a contact.
    fn manner(&self, c: &Contact) -> (f64, f64) {
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

    /// Applies the impulse of one contact; false where it needs none.
    fn end(&mut self, c: &Contact, state: &mut State, step: f64) -> bool {
        let u = self.relative(c, state);
        let approach = u.dot(c.normal);
        let (restitution, friction) = self.manner(c);
        let out = (c.depth - c.slop).max(0.0) / RECOVERY.max(4.0 * step);
        let wanted = (-restitution * approach).max(out);
        if approach >= wanted - STILL || (approach >= 0.0 && out <= 0.0) || c.depth < 0.0 {
            return false;
        }
        let give = self.yielding(c, c.normal);
        if give <= 0.0 {
            return false;
        }
        let strength = (wanted - approach) / give;
        self.apply(c, c.normal * strength, u, state);
        if friction > 0.0 {
            let u = self.relative(c, state);
            let slide = u - c.normal * u.dot(c.normal);
            if let Some(way) = slide.try_normalize() {
                let stop = slide.length() / self.yielding(c, way);
                self.apply(c, way * -stop.min(friction * strength), u, state);
            }
        }
        true
    }

    /// Applies an impulse at relative velocity `u` and books its energy.
    fn apply(&mut self, c: &Contact, impulse: DVec3, u: DVec3, state: &mut State) {
        if let Other::Body(b) = c.other {
            let driver = &self.bodies[b as usize];
            if is_driven(&driver.body) {
                self.ledger.work += impulse.dot(driver.velocity_at(c.place));
            }
            if c.edge == NO_EDGE && is_driven(&self.bodies[c.t as usize].body) {
                let driver = &self.bodies[c.t as usize];
                self.ledger.work -= impulse.dot(driver.velocity_at(c.place));
            }
        }
        self.push(c, impulse, state);
        let after = self.relative(c, state);
        self.ledger.lost -= 0.5 * impulse.dot(u + after);
        self.ledger.impulses += 1;
    }
}
