//! Contacts with bodies.

use super::contact_point::{ContactPoint, SLOP, Side, StepMotion, points_on_edge};
use super::system::Bodies;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use greenstick_geometry::{Cancelled, Context};

/// Overlap of two bodies that is tolerated, m.
const BODY_SLOP: f64 = 1e-5;
/// Distance at which two bodies count as in contact, m.
const BODY_CONTACT_DISTANCE: f64 = 1e-6;

/// Pairs of edges and bodies that are tested between two checks for cancellation.
const PAIRS_PER_CHECK: usize = 1 << 10;

impl Bodies {
    /// Adds the contacts of edges with bodies: at vertices, and between them no further apart than the rod is wide. With a
    /// `motion` also those that occur within its step.
    pub(super) fn gather_bodies(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        motion: Option<StepMotion>,
        context: &Context,
    ) -> Result<(), Cancelled> {
        for k in 0..self.near.pairs.len() {
            if k.is_multiple_of(PAIRS_PER_CHECK) {
                context.check()?;
            }
            let (edge, number) = self.near.pairs[k];
            let j = edge as usize;
            let radius = self.radius[j];
            let body = &self.bodies[number as usize];
            let (p, e) = (body.local(state.position.get(j)), state.edge(j));
            let along = body.state.rotation.conjugate() * e;
            let margin = motion.map_or(0.0, |motion| {
                let relative =
                    |v: usize| motion.velocity.get(v) - body.velocity_at(state.position.get(v));
                motion.step * relative(j).length().max(relative(j + 1).length())
            });
            let reach = radius + margin + 0.5 * along.length();
            if !body.solid.is_near(p + 0.5 * along, reach) {
                continue;
            }
            let points = points_on_edge(along.length(), radius);
            let last = !bundle.is_edge(j + 1);
            for i in 0..points as usize + usize::from(last) {
                let t = i as f64 / points;
                let q = p + along * t;
                if !body.solid.is_near(q, radius + margin) {
                    continue;
                }
                let Some((distance, out)) = body.solid.distance(q) else {
                    continue;
                };
                if distance < radius + margin {
                    self.contacts.push(ContactPoint {
                        first: Side::Edge { edge, t },
                        second: Side::Body(number),
                        normal: body.state.rotation * out,
                        point: state.position.get(j) + e * t,
                        depth: radius - distance,
                        slop: SLOP * radius,
                        length: along.length() / points,
                    });
                }
            }
        }
        Ok(())
    }

    /// Adds the contacts between bodies of which at least one is free.
    pub(super) fn gather_between_bodies(&mut self) {
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                if let Some(found) = self.closest_points(a, b, BODY_CONTACT_DISTANCE) {
                    self.contacts.push(ContactPoint {
                        first: Side::Body(a as u32),
                        second: Side::Body(b as u32),
                        normal: -found.normal,
                        point: found.point,
                        depth: found.depth,
                        slop: BODY_SLOP,
                        length: 0.0,
                    });
                }
            }
        }
    }
}
