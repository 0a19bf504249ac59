//! Rigid bodies that rods run into, and rods that run into each other (Sutherland 2012 §4.3; model.md §3 "Rigid
//! bodies"). The thesis tests rod vertices against bodies and resolves elastic collisions after every step until none is
//! left or a limit is met; here the rods between the vertices are tested too, bodies may be free, and rods that no bond
//! joins collide.
//!
//! All contacts are impulses that act on both sides at one point: linear and angular momentum of rods and free bodies
//! are kept to rounding, and without friction and with restitution 1 energy is too. Everything is done in order of
//! edges, then bodies, on one thread, so results do not depend on how many there are.
//!
//! Rods slide on each other without friction: an impulse across the line between two axes would need the rods' spin to
//! keep the angular momentum.

mod body;
mod contact;
mod rods;
mod shape;
mod springs;

pub use body::{Body, BodyMotion, BodyState};
pub use shape::{Inertia, Shape, Surface};

use crate::bundle::Bundle;
use crate::error::SolverError;
use crate::loads::{Loads, Motion};
use crate::solver::{ContactBook, Contacts, Touch};
use crate::state::State;
use crate::vectors::Vectors;
use body::Moving;
use contact::{Contact, Other};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Why bodies cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// A number out of range.
    #[error("{what} of body {body} is {value}, but it must be {right}")]
    Value {
        /// Number of the body.
        body: usize,
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// A shape that is no solid.
    #[error("the {shape} of body {body} cannot be used: {problem}")]
    Shape {
        /// Number of the body.
        body: usize,
        /// Name of the shape.
        shape: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// Two bodies overlap at the start.
    #[error(
        "bodies {first} and {second} overlap by {depth} m at {place} at the start; move them apart by at least that"
    )]
    Overlap {
        /// Name or number of the one.
        first: String,
        /// Name or number of the other.
        second: String,
        /// How deep, m.
        depth: f64,
        /// Where, m.
        place: DVec3,
    },
    /// A rod is inside a body at the start.
    #[error(
        "rod {rod} is {depth} m deep in body {body} at {place} at the start; move the body away by at least that"
    )]
    RodInside {
        /// Number of the rod.
        rod: usize,
        /// Name or number of the body.
        body: String,
        /// How deep, m.
        depth: f64,
        /// Where, m.
        place: DVec3,
    },
    /// A checkpoint of other bodies.
    #[error("the state is that of {found} bodies, but there are {expected}")]
    Count {
        /// In the state.
        found: usize,
        /// In the scene.
        expected: usize,
    },
}

/// How bodies and rods meet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactOptions {
    /// Acceleration of gravity on free bodies, m/s².
    pub gravity: DVec3,
    /// Restitution of rods that hit each other, 0 to 1; `None` where rods go through each other.
    pub rods: Option<f64>,
}

impl Default for ContactOptions {
    fn default() -> Self {
        ContactOptions {
            gravity: DVec3::ZERO,
            rods: Some(0.0),
        }
    }
}

/// Where the energy went that contacts took or gave, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactLedger {
    /// Lost in friction and in collisions with a restitution below 1, less what driving parts out of each other gave.
    pub lost: f64,
    /// Work that moved bodies did on rods and free bodies.
    pub work: f64,
    /// Impulses applied.
    pub impulses: u64,
    /// Energy of overlaps, for solvers to which contacts are springs.
    pub stored: f64,
    /// Power of moved bodies on these springs now, W.
    pub power: f64,
}

/// What a checkpoint holds of bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodiesState {
    /// Every body's place and motion.
    pub bodies: Vec<BodyState>,
    /// The energy so far.
    pub ledger: ContactLedger,
}

/// Overlap that is left alone, in radii of a rod: it keeps resting contacts from flickering.
const SLOP: f64 = 0.02;
/// Time in which an overlap beyond that is driven out, s: slow against a step, so that it adds no energy to speak of.
const RECOVERY: f64 = 2e-3;
/// Passes over the contacts of a step: the thesis's limit. Collisions between few parts need two.
const PASSES: usize = 12;
/// Overlap at the start that is rounding, m.
const ROUNDING: f64 = 1e-9;

/// Bodies, and rods that collide: the [`Contacts`] of a scene.
#[derive(Clone)]
pub struct Bodies {
    bodies: Vec<Moving>,
    options: ContactOptions,
    ledger: ContactLedger,
    /// Per vertex: 1/mass; 0 where a clamp holds it.
    inverse_mass: Vec<f64>,
    /// Per edge: radius of its rod, m; 0 at gaps.
    radius: Vec<f64>,
    /// Per edge: stiffness of its side per length, N/m²; 0 at gaps.
    firmness: Vec<f64>,
    near: Near,
    rods: rods::RodPairs,
    contacts: Vec<Contact>,
    /// Per contact: what it has given to the edge in this step, N s.
    impulses: Vec<DVec3>,
    /// Relative velocity along the normal at which each ends the step at least, m/s.
    wanted: Vec<f64>,
    /// Per body: velocity and angular velocity at the start of the step.
    before: Vec<(DVec3, DVec3)>,
    /// Per body: what it has been given since this was last taken.
    given: Vec<Given>,
}

/// What contacts have given a body over some time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Given {
    /// Impulse, N s.
    pub impulse: DVec3,
    /// Angular impulse about the body's centre, N m s.
    pub angular: DVec3,
}

/// Edges near bodies, with where everything was when they were looked for.
#[derive(Clone, Default)]
struct Near {
    /// Edge and body, sorted.
    pairs: Vec<(u32, u32)>,
    position: Vectors,
    bodies: Vec<BodyState>,
    /// How far things may move until they are looked for again, m; 0 for at once.
    slack: f64,
}

impl Bodies {
    /// Bodies about a bundle in its present state. Vertices that the clamps of `loads` hold do not give way.
    ///
    /// # Errors
    /// [`BodyError`] for numbers out of range, bodies that overlap each other (unless neither is free), and rods inside
    /// bodies.
    pub fn new(
        bodies: Vec<Body>,
        options: ContactOptions,
        bundle: &Bundle,
        state: &State,
        loads: &Loads,
    ) -> Result<Self, BodyError> {
        let mut moving: Vec<Moving> = bodies
            .into_iter()
            .enumerate()
            .map(|(i, b)| Moving::new(i, b))
            .collect::<Result<_, _>>()?;
        for body in &mut moving {
            body.kick(state.time, 0.0, DVec3::ZERO);
            body.drift(state.time, 0.0);
        }
        let mut made = Bodies {
            bodies: moving,
            options,
            ledger: ContactLedger::default(),
            inverse_mass: Vec::new(),
            radius: Vec::new(),
            firmness: Vec::new(),
            near: Near::default(),
            rods: rods::RodPairs::default(),
            contacts: Vec::new(),
            impulses: Vec::new(),
            wanted: Vec::new(),
            before: Vec::new(),
            given: Vec::new(),
        };
        made.given = vec![Given::default(); made.bodies.len()];
        made.take(bundle);
        made.hold(loads);
        made.check_overlaps(bundle, state)?;
        Ok(made)
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// The bodies with where they are now.
    pub fn iter(&self) -> impl Iterator<Item = (&Body, BodyState)> + '_ {
        self.bodies.iter().map(|b| (&b.body, b.state))
    }

    /// The energy that contacts took and gave.
    pub fn ledger(&self) -> ContactLedger {
        self.ledger
    }

    /// What contacts have given each body since this was last asked, or since the start.
    pub fn take_given(&mut self) -> Vec<Given> {
        let none = vec![Given::default(); self.bodies.len()];
        std::mem::replace(&mut self.given, none)
    }

    /// What a checkpoint holds.
    pub fn snapshot(&self) -> BodiesState {
        BodiesState {
            bodies: self.bodies.iter().map(|b| b.state).collect(),
            ledger: self.ledger,
        }
    }

    /// Puts the bodies where a checkpoint says, about a bundle that may have broken since the start.
    ///
    /// # Errors
    /// [`BodyError::Count`] where the checkpoint is of other bodies.
    pub fn restore(
        &mut self,
        saved: &BodiesState,
        bundle: &Bundle,
        loads: &Loads,
    ) -> Result<(), BodyError> {
        if saved.bodies.len() != self.bodies.len() {
            return Err(BodyError::Count {
                found: saved.bodies.len(),
                expected: self.bodies.len(),
            });
        }
        for (body, state) in self.bodies.iter_mut().zip(&saved.bodies) {
            body.state = *state;
        }
        self.ledger = saved.ledger;
        self.given.fill(Given::default());
        self.take(bundle);
        self.hold(loads);
        Ok(())
    }

    /// Momentum of the free bodies (kg m/s) and their angular momentum about `centre` (kg m²/s).
    pub fn momenta(&self, centre: DVec3) -> (DVec3, DVec3) {
        let mut sum = (DVec3::ZERO, DVec3::ZERO);
        for body in &self.bodies {
            if let Some(i) = body.inertia {
                let p = body.state.velocity * i.mass;
                sum.0 += p;
                sum.1 += (body.state.centre - centre).cross(p) + body.state.spin;
            }
        }
        sum
    }

    fn name(&self, body: usize) -> String {
        let name = &self.bodies[body].body.name;
        if name.is_empty() {
            body.to_string()
        } else {
            format!("\"{name}\"")
        }
    }

    /// Takes over sizes and masses of a bundle.
    fn take(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        self.inverse_mass = bundle.mass.iter().map(|m| 1.0 / m).collect();
        self.radius = vec![0.0; n];
        for rod in 0..bundle.rods() {
            for j in bundle.rod(rod).filter(|&j| bundle.is_edge(j)) {
                self.radius[j] = 0.5 * bundle.diameter[rod];
            }
        }
        self.firmness = Bodies::firmness(bundle);
        self.near.slack = 0.0;
        self.near.position = Vectors::zeros(n);
        self.rods.forget(bundle);
    }

    /// Vertices in clamps give way to nothing.
    fn hold(&mut self, loads: &Loads) {
        for clamp in loads.clamps.iter().filter(|c| c.axes == [true; 3]) {
            for &v in &clamp.vertices {
                if let Some(w) = self.inverse_mass.get_mut(v as usize) {
                    *w = 0.0;
                }
            }
        }
    }

    fn check_overlaps(&mut self, bundle: &Bundle, state: &State) -> Result<(), BodyError> {
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                if let Some(m) = self.meeting(a, b, 0.0)
                    && m.depth > ROUNDING
                {
                    return Err(BodyError::Overlap {
                        first: self.name(a),
                        second: self.name(b),
                        depth: m.depth,
                        place: m.place,
                    });
                }
            }
        }
        self.look(bundle, state);
        self.contacts.clear();
        self.gather_bodies(bundle, state, None);
        for c in &self.contacts {
            if let Other::Body(body) = c.other
                && c.depth > SLOP * self.radius[c.edge as usize] + ROUNDING
            {
                return Err(BodyError::RodInside {
                    rod: bundle.rod_of(c.edge as usize),
                    body: self.name(body as usize),
                    depth: c.depth,
                    place: c.place,
                });
            }
        }
        Ok(())
    }

    /// How two bodies of which one is free meet.
    fn meeting(&self, a: usize, b: usize, ahead: f64) -> Option<shape::Meeting> {
        let (one, two) = (&self.bodies[a], &self.bodies[b]);
        if one.inertia.is_none() && two.inertia.is_none() {
            return None;
        }
        let at = |m: &Moving| shape::pose(m.origin(), m.state.turn);
        one.solid.meet(&at(one), &two.solid, &at(two), ahead)
    }

    /// Looks for edges near bodies.
    fn look(&mut self, bundle: &Bundle, state: &State) {
        let n = bundle.vertices();
        let thickest = self.radius.iter().copied().fold(0.0, f64::max);
        // Wide enough to last many steps, and not much more than what can touch.
        let slack = 3.0 * thickest;
        self.near.pairs.clear();
        for j in 0..n {
            if self.radius[j] <= 0.0 {
                continue;
            }
            let (p, e) = (state.position.get(j), state.edge(j));
            let reach = self.radius[j] + 0.5 * e.length() + 2.0 * slack;
            for (b, body) in self.bodies.iter().enumerate() {
                if body.solid.near(body.local(p + 0.5 * e), reach) {
                    self.near.pairs.push((j as u32, b as u32));
                }
            }
        }
        self.near.slack = slack;
        self.near.position.clone_from(&state.position);
        self.near.bodies.clear();
        self.near.bodies.extend(self.bodies.iter().map(|b| b.state));
    }

    /// Whether something has moved so far that contacts may be missed.
    fn stale(&self, state: &State) -> bool {
        let slack = self.near.slack;
        if slack <= 0.0 || self.near.position.len() != state.position.len() {
            return true;
        }
        for (body, before) in self.bodies.iter().zip(&self.near.bodies) {
            if body.state.centre == before.centre && body.state.turn == before.turn {
                continue;
            }
            let anchor = body.inertia.map_or(DVec3::ZERO, |i| i.centre);
            let reach = body.solid.reach(anchor);
            let turn = 1.0 - body.state.turn.dot(before.turn).abs();
            let turned = if turn > 0.0 {
                // Chord of the angle, from cos(angle/2).
                reach * (8.0 * turn).sqrt()
            } else {
                0.0
            };
            let moved = body.state.centre.distance(before.centre) + turned;
            // A half-space is near everything as it is.
            if reach.is_finite() && (moved.is_nan() || moved > slack) {
                return true;
            }
        }
        moved_squared(&state.position, &self.near.position) > slack * slack
    }
}

/// Largest squared distance between vectors of two lists, m²; NaN where there is one.
fn moved_squared(a: &Vectors, b: &Vectors) -> f64 {
    let parts =
        a.x.iter()
            .zip(&b.x)
            .zip(a.y.iter().zip(&b.y))
            .zip(a.z.iter().zip(&b.z));
    parts.fold(0.0, |most: f64, (((ax, bx), (ay, by)), (az, bz))| {
        let (x, y, z) = (ax - bx, ay - by, az - bz);
        let d = x * x + y * y + z * z;
        if d > most || d.is_nan() { d } else { most }
    })
}

impl Contacts for Bodies {
    fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.options.rods.is_none()
    }

    fn resolve(
        &mut self,
        bundle: &Bundle,
        state: &State,
        velocity: &mut Vectors,
        step: f64,
    ) -> Result<Option<f64>, SolverError> {
        let end = state.time + step;
        self.before.clear();
        for body in &mut self.bodies {
            let free = body.inertia.is_some();
            let was = (body.state.velocity, body.state.angular);
            body.kick(end, step, self.options.gravity);
            let now = (body.state.velocity, body.state.angular);
            self.before.push(if free { was } else { now });
        }
        self.contacts.clear();
        if !self.bodies.is_empty() {
            if self.stale(state) {
                self.look(bundle, state);
            }
            self.gather_bodies(bundle, state, Some((velocity, step)));
            self.gather_between_bodies();
        }
        if self.options.rods.is_some() {
            let ahead = Some((&*velocity, step));
            self.rods
                .gather(bundle, state, &self.radius, ahead, &mut self.contacts);
        }
        let count = self.ledger.impulses;
        let given = self.settle(state, velocity, step);
        for body in &mut self.bodies {
            body.drift(end, step);
        }
        Ok((self.ledger.impulses > count).then_some(given))
    }

    fn touches(
        &mut self,
        bundle: &Bundle,
        state: &State,
        from: &State,
        time: f64,
        found: &mut Vec<Touch>,
    ) {
        self.find_touches(bundle, state, from, time, found);
    }

    fn accept(&mut self, from: &State, time: f64, touches: &[Touch]) -> ContactBook {
        self.book_touches(from, time, touches)
    }

    fn stored(&self) -> f64 {
        self.ledger.stored
    }

    fn renumbered(&mut self, bundle: &Bundle, before: &[u32]) {
        let held: Vec<bool> = self.inverse_mass.iter().map(|w| *w == 0.0).collect();
        self.take(bundle);
        for (v, &b) in before.iter().enumerate() {
            if held.get(b as usize) == Some(&true) {
                self.inverse_mass[v] = 0.0;
            }
        }
    }

    fn energy(&self) -> f64 {
        self.bodies.iter().fold(0.0, |sum, b| {
            let weight = b
                .inertia
                .map_or(0.0, |i| -i.mass * self.options.gravity.dot(b.state.centre));
            sum + b.kinetic_energy() + weight
        })
    }
}

/// Whether a body's motion is given and not rest.
fn is_driven(body: &Body) -> bool {
    matches!(&body.motion, BodyMotion::Given(m) if *m != Motion::Fixed)
}

/// Distance (m) from a body at its start to the nearest rod's skin; negative where they overlap.
///
/// # Errors
/// [`BodyError`] where the body is out of range.
pub fn clearance(body: &Body, bundle: &Bundle, state: &State) -> Result<f64, BodyError> {
    let moving = Moving::new(0, body.clone())?;
    let mut least = f64::INFINITY;
    for rod in 0..bundle.rods() {
        let radius = 0.5 * bundle.diameter[rod];
        for j in bundle.rod(rod) {
            let here = moving.local(state.position.get(j));
            let middle = if bundle.is_edge(j) {
                moving.local(state.position.get(j) + 0.5 * state.edge(j))
            } else {
                here
            };
            for p in [here, middle] {
                // On the surface the direction is undefined, but the distance is not.
                let distance = moving.solid.distance(p).map_or(0.0, |(d, _)| d);
                least = least.min(distance - radius);
            }
        }
    }
    Ok(least)
}
