//! All bodies of a world, and which edges are near them.

use super::body::{Body, MovingBody};
use super::contact_point::{ContactPoint, SLOP, Side, points_on_edge};
use super::crushing::TRANSVERSE_STRENGTH_RATIO;
use super::displacement::moved_squared;
use super::error::BodyError;
use super::rod_pairs::RodPairs;
use super::shape::{self, ClosestPoints};
use super::state::{BodiesState, BodyImpulse, BodyState, ContactLedger, ContactsState};
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use serde::{Deserialize, Serialize};

/// How bodies and rods make contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactOptions {
    /// Acceleration of gravity on free bodies, m/s².
    pub gravity: DVec3,
    /// Restitution of rods that hit each other, 0 to 1; `None` where rods pass through each other.
    pub rod_restitution: Option<f64>,
}

impl Default for ContactOptions {
    fn default() -> Self {
        ContactOptions {
            gravity: DVec3::ZERO,
            rod_restitution: Some(0.0),
        }
    }
}

/// Overlap at the start that is rounding, m.
const ROUNDING: f64 = 1e-9;
/// Stiffness of wood across the grain over that along it: about the mean of the species' tables in the tangential
/// direction.
const TRANSVERSE_STIFFNESS_RATIO: f64 = 0.05;
/// Margin of the search for edges near bodies, in the thickest rod's radii: wide enough to last many steps, and little more
/// than what can touch.
const SEARCH_MARGIN: f64 = 3.0;
/// Edges that are tested between two checks for cancellation.
const EDGES_PER_CHECK: usize = 1 << 14;

/// Bodies, and rods that collide: the [`crate::Contacts`] of a scene.
#[derive(Clone)]
pub struct Bodies {
    pub(super) bodies: Vec<MovingBody>,
    pub(super) options: ContactOptions,
    pub(super) ledger: ContactLedger,
    /// Per vertex: 1/mass; 0 where a clamp holds it.
    pub(super) inverse_mass: Vec<f64>,
    /// Per edge: radius of its rod, m; 0 at gaps.
    pub(super) radius: Vec<f64>,
    /// Per edge: stiffness of its side per length, N/m²; 0 at gaps.
    pub(super) side_stiffness: Vec<f64>,
    /// Per edge: force per length at which its side is crushed, N/m; 0 at gaps.
    pub(super) side_strength: Vec<f64>,
    pub(super) near: NearEdges,
    pub(super) rods: RodPairs,
    pub(super) contacts: Vec<ContactPoint>,
    /// Per contact: the impulse on its first side in this step, N s.
    pub(super) impulses: Vec<DVec3>,
    /// Per contact: the least relative velocity along the normal at the end of the step, m/s.
    pub(super) target_velocity: Vec<f64>,
    /// Per body: its velocities at the start of the step.
    pub(super) before: Vec<BodyVelocity>,
    /// Per body: what it was given since this was last taken.
    pub(super) given: Vec<BodyImpulse>,
}

/// Velocity and angular velocity of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyVelocity {
    pub linear: DVec3,
    pub angular: DVec3,
}

/// Edges near bodies, and where everything was when they were found.
#[derive(Clone, Default)]
pub(super) struct NearEdges {
    /// Edge and body, sorted.
    pub pairs: Vec<(u32, u32)>,
    position: Vectors,
    bodies: Vec<BodyState>,
    /// How far things may move until a new search, m; 0 for at once.
    margin: f64,
}

impl Bodies {
    /// Sets up bodies about a bundle in its present state. Vertices that the clamps of `loads` hold do not give way.
    ///
    /// # Errors
    /// [`BodyError`] for numbers out of range, bodies that overlap each other (unless neither is free), and rods inside
    /// bodies.
    pub fn new(
        bodies: Vec<Body>,
        options: ContactOptions,
        bundle: &RodBundle,
        state: &State,
        loads: &Loads,
        context: &Context,
    ) -> Result<Self, BodyError> {
        let mut moving: Vec<MovingBody> = bodies
            .into_iter()
            .enumerate()
            .map(|(i, b)| MovingBody::new(i, b))
            .collect::<Result<_, _>>()?;
        for body in &mut moving {
            body.update_velocity(state.time, 0.0, DVec3::ZERO);
            body.update_position(state.time, 0.0);
        }
        let mut system = Bodies {
            given: vec![BodyImpulse::default(); moving.len()],
            bodies: moving,
            options,
            ledger: ContactLedger::default(),
            inverse_mass: Vec::new(),
            radius: Vec::new(),
            side_stiffness: Vec::new(),
            side_strength: Vec::new(),
            near: NearEdges::default(),
            rods: RodPairs::default(),
            contacts: Vec::new(),
            impulses: Vec::new(),
            target_velocity: Vec::new(),
            before: Vec::new(),
        };
        system.take_bundle(bundle);
        system.hold_clamped(loads);
        system.check_overlaps(bundle, state, context)?;
        Ok(system)
    }

    /// Returns the number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Iterates over the bodies with their present states.
    pub fn iter(&self) -> impl Iterator<Item = (&Body, BodyState)> + '_ {
        self.bodies.iter().map(|b| (&b.body, b.state))
    }

    /// Returns the energy that contacts took and gave.
    pub fn ledger(&self) -> ContactLedger {
        self.ledger
    }

    /// Takes what contacts have given each body since this was last called, or since the start.
    pub(crate) fn take_impulses(&mut self) -> Vec<BodyImpulse> {
        let none = vec![BodyImpulse::default(); self.bodies.len()];
        std::mem::replace(&mut self.given, none)
    }

    /// Returns what a checkpoint holds.
    pub fn checkpoint(&self) -> BodiesState {
        BodiesState {
            bodies: self.bodies.iter().map(|b| b.state).collect(),
            ledger: self.ledger,
        }
    }

    /// Puts the bodies where a checkpoint has them, about a bundle that may have broken since the start.
    ///
    /// # Errors
    /// [`BodyError::Count`] where the checkpoint is of other bodies.
    pub fn resume(
        &mut self,
        saved: &BodiesState,
        bundle: &RodBundle,
        loads: &Loads,
    ) -> Result<(), BodyError> {
        if saved.bodies.len() != self.bodies.len() {
            return Err(BodyError::Count {
                found: saved.bodies.len(),
                expected: self.bodies.len(),
            });
        }
        self.restore_state(
            &ContactsState {
                bodies: saved.clone(),
                impulses: vec![BodyImpulse::default(); self.bodies.len()],
            },
            bundle,
            loads,
        );
        Ok(())
    }

    /// Returns to an earlier state of the same bodies.
    pub(super) fn restore_state(
        &mut self,
        saved: &ContactsState,
        bundle: &RodBundle,
        loads: &Loads,
    ) {
        for (body, state) in self.bodies.iter_mut().zip(&saved.bodies.bodies) {
            body.state = *state;
        }
        self.ledger = saved.bodies.ledger;
        self.given.clone_from(&saved.impulses);
        self.take_bundle(bundle);
        self.hold_clamped(loads);
    }

    /// Returns the momentum of the free bodies (kg m/s) and their angular momentum about `centre` (kg m²/s).
    pub fn momenta(&self, centre: DVec3) -> (DVec3, DVec3) {
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for body in &self.bodies {
            if let Some(i) = body.inertia {
                let p = body.state.velocity * i.mass;
                linear += p;
                angular += (body.state.centre - centre).cross(p) + body.state.angular_momentum;
            }
        }
        (linear, angular)
    }

    /// Returns the energy of free bodies: of motion, and of their weight, J.
    pub fn energy(&self) -> f64 {
        self.bodies.iter().fold(0.0, |sum, b| {
            let weight = b
                .inertia
                .map_or(0.0, |i| -i.mass * self.options.gravity.dot(b.state.centre));
            sum + b.kinetic_energy() + weight
        })
    }

    fn name(&self, body: usize) -> String {
        let name = &self.bodies[body].body.name;
        if name.is_empty() {
            body.to_string()
        } else {
            format!("\"{name}\"")
        }
    }

    /// Takes over the sizes, stiffness and masses of a bundle.
    pub(super) fn take_bundle(&mut self, bundle: &RodBundle) {
        let n = bundle.vertices();
        self.inverse_mass = bundle.mass.iter().map(|m| 1.0 / m).collect();
        self.radius = vec![0.0; n];
        self.side_stiffness = vec![0.0; n];
        self.side_strength = vec![0.0; n];
        for rod in 0..bundle.rods() {
            for j in bundle.rod(rod).filter(|&j| bundle.is_edge(j)) {
                self.radius[j] = 0.5 * bundle.diameter[rod];
                let modulus = bundle.stretch[j] / bundle.area[rod];
                self.side_stiffness[j] = TRANSVERSE_STIFFNESS_RATIO * modulus;
                let crushing = modulus * bundle.yield_strain[j];
                self.side_strength[j] = TRANSVERSE_STRENGTH_RATIO * crushing * bundle.diameter[rod];
            }
        }
        self.near.margin = 0.0;
        self.near.position = Vectors::zeros(n);
        self.rods.bundle_changed(bundle);
    }

    /// Makes clamped vertices immovable.
    fn hold_clamped(&mut self, loads: &Loads) {
        for clamp in loads.clamps.iter().filter(|c| c.axes == [true; 3]) {
            for &v in &clamp.vertices {
                if let Some(w) = self.inverse_mass.get_mut(v as usize) {
                    *w = 0.0;
                }
            }
        }
    }

    fn check_overlaps(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        context: &Context,
    ) -> Result<(), BodyError> {
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                if let Some(found) = self.closest_points(a, b, 0.0)
                    && found.depth > ROUNDING
                {
                    return Err(BodyError::Overlap {
                        first: self.name(a),
                        second: self.name(b),
                        depth: found.depth,
                        place: found.point,
                    });
                }
            }
        }
        self.find_near_edges(bundle, state, context)?;
        self.contacts.clear();
        self.gather_bodies(bundle, state, None, context)?;
        for c in &self.contacts {
            if let (Side::Edge { edge, .. }, Side::Body(body)) = (c.first, c.second)
                && c.depth > SLOP * self.radius[edge as usize] + ROUNDING
            {
                return Err(BodyError::RodInside {
                    rod: bundle.rod_of(edge as usize),
                    body: self.name(body as usize),
                    depth: c.depth,
                    place: c.point,
                });
            }
        }
        Ok(())
    }

    /// Returns the closest points of two bodies of which one is free, where they are closer than `distance` (m).
    pub(super) fn closest_points(
        &self,
        a: usize,
        b: usize,
        distance: f64,
    ) -> Option<ClosestPoints> {
        let (one, two) = (&self.bodies[a], &self.bodies[b]);
        if one.inertia.is_none() && two.inertia.is_none() {
            return None;
        }
        let pose = |m: &MovingBody| shape::pose(m.origin(), m.state.rotation);
        one.solid
            .closest_points(&pose(one), &two.solid, &pose(two), distance)
    }

    /// Finds the edges near bodies anew, where something has moved so far that contacts could be missed.
    pub(super) fn update_near_edges(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        context: &Context,
    ) -> Result<(), Cancelled> {
        if self.near_edges_are_stale(state) {
            self.find_near_edges(bundle, state, context)?;
        }
        Ok(())
    }

    fn find_near_edges(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let thickest = self.radius.iter().copied().fold(0.0, f64::max);
        let margin = SEARCH_MARGIN * thickest;
        self.near.pairs.clear();
        self.near.margin = 0.0;
        for j in 0..bundle.vertices() {
            if j.is_multiple_of(EDGES_PER_CHECK) {
                context.check()?;
            }
            if self.radius[j] <= 0.0 {
                continue;
            }
            let (p, e) = (state.position.get(j), state.edge(j));
            let reach = self.radius[j] + 0.5 * e.length() + 2.0 * margin;
            for (b, body) in self.bodies.iter().enumerate() {
                if body.solid.is_near(body.local(p + 0.5 * e), reach) {
                    self.near.pairs.push((j as u32, b as u32));
                }
            }
        }
        self.near.margin = margin;
        self.near.position.clone_from(&state.position);
        self.near.bodies.clear();
        self.near.bodies.extend(self.bodies.iter().map(|b| b.state));
        Ok(())
    }

    fn near_edges_are_stale(&self, state: &State) -> bool {
        let margin = self.near.margin;
        if margin <= 0.0 || self.near.position.len() != state.position.len() {
            return true;
        }
        for (body, before) in self.bodies.iter().zip(&self.near.bodies) {
            if body.state.centre == before.centre && body.state.rotation == before.rotation {
                continue;
            }
            let anchor = body.inertia.map_or(DVec3::ZERO, |i| i.centre);
            let extent = body.solid.extent(anchor);
            let turn = 1.0 - body.state.rotation.dot(before.rotation).abs();
            let turned = if turn > 0.0 {
                // The chord of the angle, from cos(angle/2).
                extent * (8.0 * turn).sqrt()
            } else {
                0.0
            };
            let moved = body.state.centre.distance(before.centre) + turned;
            // Every edge is near a half-space.
            if extent.is_finite() && (moved.is_nan() || moved > margin) {
                return true;
            }
        }
        moved_squared(&state.position, &self.near.position) > margin * margin
    }
}

/// Returns the distance (m) from a body at its start to the nearest rod's surface; negative where they overlap.
///
/// # Errors
/// [`BodyError`] where the body is out of range.
pub(crate) fn clearance(
    body: &Body,
    bundle: &RodBundle,
    state: &State,
    context: &Context,
) -> Result<f64, BodyError> {
    let moving = MovingBody::new(0, body.clone())?;
    let mut least = f64::INFINITY;
    for rod in 0..bundle.rods() {
        context.check()?;
        let radius = 0.5 * bundle.diameter[rod];
        for j in bundle.rod(rod) {
            let here = state.position.get(j);
            let (edge, points) = if bundle.is_edge(j) {
                let edge = state.edge(j);
                (edge, points_on_edge(edge.length(), radius))
            } else {
                (DVec3::ZERO, 1.0)
            };
            for i in 0..points as usize {
                let p = moving.local(here + edge * (i as f64 / points));
                // On the surface the direction is undefined, but the distance is not.
                let distance = moving.solid.distance(p).map_or(0.0, |(d, _)| d);
                least = least.min(distance - radius);
            }
        }
    }
    Ok(least)
}
