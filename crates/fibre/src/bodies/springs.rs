//! Contacts as springs, for solvers that look for equilibrium: an overlap costs energy, ½ k depth², so that contacts are a
//! potential like all others, and its stiffness is that of wood across the grain over the length that touches.
//!
//! Friction is Coulomb's on the way slid since the step began; below [`GIVE`] of a rod's radius it grows in proportion
//! to the way, so that it too has a stiffness.

use super::contact::{Contact, Other};
use super::{Bodies, is_driven};
use crate::bundle::Bundle;
use crate::solver::{ContactBook, Touch};
use crate::state::State;
use glam::DVec3;

/// Stiffness of wood across the grain over that along it: about the mean of the species' tables in the tangential
/// direction.
const ACROSS: f64 = 0.05;
/// Way of sliding at which friction is whole, in radii of the rod.
const GIVE: f64 = 2e-3;

impl Bodies {
    /// Stiffness per length (N/m²) of a rod's side against what presses on it, per edge.
    pub(super) fn firmness(bundle: &Bundle) -> Vec<f64> {
        let mut made = vec![0.0; bundle.vertices()];
        for rod in 0..bundle.rods() {
            for j in bundle.rod(rod).filter(|&j| bundle.is_edge(j)) {
                made[j] = ACROSS * bundle.stretch[j] / bundle.area[rod];
            }
        }
        made
    }

    /// Moves bodies whose motion is given to where they are at `time`, a step after `from`.
    fn place_bodies(&mut self, from: &State, time: f64) {
        for body in self.bodies.iter_mut().filter(|b| is_driven(&b.body)) {
            body.kick(time, time - from.time, DVec3::ZERO);
            body.drift(time, time - from.time);
        }
    }

    /// Springs of all overlaps of `state` at `time`, on the way from `from`.
    pub(super) fn find_touches(
        &mut self,
        bundle: &Bundle,
        state: &State,
        from: &State,
        time: f64,
        found: &mut Vec<Touch>,
    ) {
        found.clear();
        self.place_bodies(from, time);
        self.contacts.clear();
        if !self.bodies.is_empty() {
            if self.stale(state) {
                self.look(bundle, state);
            }
            self.gather_bodies(bundle, state, None);
        }
        if self.options.rods.is_some() {
            self.rods
                .gather(bundle, state, &self.radius, None, &mut self.contacts);
        }
        for k in 0..self.contacts.len() {
            let touch = self.touch(&self.contacts[k], state, from, time - from.time);
            found.push(touch);
        }
    }

    fn touch(&self, c: &Contact, state: &State, from: &State, step: f64) -> Touch {
        let (j, t) = (c.edge as usize, c.t);
        let mut stiffness = self.firmness[j] * c.share;
        let moved = |j: usize, t: f64| {
            let way = |v: usize| state.position.get(v) - from.position.get(v);
            way(j) * (1.0 - t) + way(j + 1) * t
        };
        let (mut friction, mut slide, mut body, mut other) = (0.0, DVec3::ZERO, None, None);
        match c.other {
            Other::Body(b) => {
                let moving = &self.bodies[b as usize];
                friction = moving.body.friction * stiffness * c.depth;
                slide = moved(j, t) - moving.velocity_at(c.place) * step;
                slide -= c.normal * slide.dot(c.normal);
                body = Some(b);
            }
            Other::Edge(e, s) => {
                // Two in series.
                stiffness *= self.firmness[e as usize]
                    / (self.firmness[j] + self.firmness[e as usize]).max(f64::MIN_POSITIVE);
                other = Some((e, s));
            }
        }
        let hold = friction / slide.length().max(GIVE * self.radius[j]);
        Touch {
            edge: c.edge,
            t,
            other,
            body,
            place: c.place,
            normal: c.normal,
            force: c.normal * (stiffness * c.depth) - slide * hold,
            stiffness,
            hold,
            energy: 0.5 * stiffness * c.depth * c.depth,
            rubbed: hold * slide.length_squared(),
        }
    }

    /// Ends a step from `from` to `time` at which contacts are `touches`.
    pub(super) fn book_touches(
        &mut self,
        from: &State,
        time: f64,
        touches: &[Touch],
    ) -> ContactBook {
        self.place_bodies(from, time);
        let step = time - from.time;
        let mut book = ContactBook::default();
        let mut power = 0.0;
        for touch in touches {
            book.stored += touch.energy;
            book.lost += touch.rubbed;
            if let Some(b) = touch.body.map(|b| b as usize) {
                let moving = &self.bodies[b];
                if is_driven(&moving.body) {
                    power += touch.force.dot(moving.velocity_at(touch.place));
                }
                let arm = touch.place - moving.state.centre;
                let impulse = touch.force * -step;
                self.given[b].impulse += impulse;
                self.given[b].angular += arm.cross(impulse);
            }
        }
        // The trapezium's rule over the step.
        book.work = 0.5 * step * (self.ledger.power + power);
        self.ledger.work += book.work;
        self.ledger.lost += book.lost;
        if step > 0.0 {
            self.ledger.power = power;
        }
        self.ledger.stored = book.stored;
        book
    }
}
