//! The interface of all solvers, and the world that they move.

use crate::bundle::Bundle;
use crate::error::{LoadError, SolverError};
use crate::event::Event;
use crate::failure::Failure;
use crate::loads::Loads;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A bundle, its state, what acts on it, when it fails, and what has happened to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// The rods and bonds.
    pub bundle: Bundle,
    /// Where they are.
    pub state: State,
    /// What acts on them.
    pub loads: Loads,
    /// When they fail.
    pub failure: Failure,
    /// What has happened, in order.
    pub events: Vec<Event>,
    /// Energy that breaking and yielding have taken, J.
    pub fracture_loss: f64,
    /// The stability limit as last found; kept here so that a run that is resumed takes the same steps.
    pub limit: Option<KnownLimit>,
}

/// A stability limit and what it was found for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KnownLimit {
    /// Largest stable step, s.
    pub limit: f64,
    /// The bundle's generation then.
    pub generation: u64,
    /// Steps done by then.
    pub step: u64,
}

impl World {
    /// A bundle at rest, with nothing acting on it, that does not fail.
    pub fn new(bundle: Bundle) -> Self {
        let state = State::at_rest(&bundle);
        World {
            bundle,
            state,
            loads: Loads::default(),
            failure: Failure::default(),
            events: Vec::new(),
            fracture_loss: 0.0,
            limit: None,
        }
    }

    /// Checks loads and failure criteria against the bundle.
    ///
    /// # Errors
    /// [`LoadError`] for the first that does not fit.
    pub fn check(&self) -> Result<(), LoadError> {
        self.loads.check(&self.bundle)?;
        self.failure.check()
    }
}

/// What a solver did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Advance {
    /// Steps taken.
    pub steps: u64,
    /// Length of the last full step, s.
    pub step: f64,
    /// Largest stable step, s; infinite where there is no limit.
    pub limit: f64,
    /// Energy taken by damping, J (known exactly from its work).
    pub damped: f64,
    /// Energy that the method itself took from the motion, J, as far as it can tell; 0 for methods that keep it.
    pub dissipated: f64,
    /// Work done by clamps and forces, J.
    pub work: f64,
}

/// A contact as a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The edge that touches.
    pub edge: u32,
    /// Place on it, 0 to 1.
    pub t: f64,
    /// The other edge and the place on it; `None` for a body.
    pub other: Option<(u32, f64)>,
    /// The body.
    pub body: Option<u32>,
    /// Where it touches, m.
    pub place: DVec3,
    /// Unit direction from the other to the edge.
    pub normal: DVec3,
    /// Force on the edge, N.
    pub force: DVec3,
    /// Stiffness along the normal, N/m.
    pub stiffness: f64,
    /// Friction over the way slid, N/m.
    pub hold: f64,
    /// Energy of the overlap, J.
    pub energy: f64,
    /// Energy that friction takes in the step, J.
    pub rubbed: f64,
}

impl Touch {
    /// The vertices that it acts on, with their parts of the force.
    pub fn shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let own = [(self.edge, 1.0 - self.t), (self.edge + 1, self.t)];
        let other = self.other.map(|(e, s)| [(e, s - 1.0), (e + 1, -s)]);
        own.into_iter()
            .chain(other.into_iter().flatten())
            .map(|(v, w)| (v as usize, w))
    }
}

/// What contacts took and gave in a step, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactBook {
    /// Work of moved bodies.
    pub work: f64,
    /// Taken by friction.
    pub lost: f64,
    /// Stored in overlaps now.
    pub stored: f64,
}

/// Bodies and contacts between rods, which solvers ask to act once a step.
pub trait Contacts: Send {
    /// Whether there is nothing to touch, so that nothing has to be asked.
    fn is_empty(&self) -> bool {
        false
    }

    /// Ends contacts in a step of `step` seconds from `state`, at whose end velocities are to be `velocity` where nothing
    /// touches: changes them, before places move on with them, and moves bodies to the end of the step. Returns the energy
    /// that this gives to rods and free bodies, J, or nothing where nothing touches.
    ///
    /// # Errors
    /// [`SolverError`] where that is impossible.
    fn resolve(
        &mut self,
        bundle: &Bundle,
        state: &State,
        velocity: &mut Vectors,
        step: f64,
    ) -> Result<Option<f64>, SolverError>;

    /// For solvers that look for equilibrium: puts into `found` the springs of all overlaps of `state` at `time` (s), on the
    /// way from `from`.
    fn touches(
        &mut self,
        bundle: &Bundle,
        state: &State,
        from: &State,
        time: f64,
        found: &mut Vec<Touch>,
    );

    /// For these solvers: ends a step from `from` to `time` (s), at which contacts are `touches`.
    fn accept(&mut self, from: &State, time: f64, touches: &[Touch]) -> ContactBook;

    /// Energy stored in overlaps, J.
    fn stored(&self) -> f64 {
        0.0
    }

    /// Something broke: vertex `i` of the bundle now was vertex `before[i]` until now.
    fn renumbered(&mut self, bundle: &Bundle, before: &[u32]);

    /// Energy of bodies, J.
    fn energy(&self) -> f64;
}

/// No bodies and no contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NoContacts;

impl Contacts for NoContacts {
    fn is_empty(&self) -> bool {
        true
    }

    fn resolve(
        &mut self,
        _: &Bundle,
        _: &State,
        _: &mut Vectors,
        _: f64,
    ) -> Result<Option<f64>, SolverError> {
        Ok(None)
    }

    fn touches(&mut self, _: &Bundle, _: &State, _: &State, _: f64, found: &mut Vec<Touch>) {
        found.clear();
    }

    fn accept(&mut self, _: &State, _: f64, _: &[Touch]) -> ContactBook {
        ContactBook::default()
    }

    fn renumbered(&mut self, _: &Bundle, _: &[u32]) {}

    fn energy(&self) -> f64 {
        0.0
    }
}

/// A way to move a world through time.
///
/// All solvers pass the suite in `tests/solvers.rs`.
pub trait Solver {
    /// Its name in files and messages.
    fn name(&self) -> &'static str;

    /// The step that it would take now, s.
    ///
    /// # Errors
    /// [`SolverError::UnstableStep`] where a given step is too large.
    fn step(&mut self, world: &World) -> Result<f64, SolverError>;

    /// Moves the world by `duration` seconds, in whole steps of equal length that are no longer than
    /// [`Solver::step`], and appends what breaks to [`World::events`].
    ///
    /// # Errors
    /// [`SolverError`]; the world is then as it was after the last good step.
    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
    ) -> Result<Advance, SolverError>;
}
