//! The interface of all solvers, and the world that they move.

use crate::bundle::Bundle;
use crate::error::{LoadError, SolverError};
use crate::event::Event;
use crate::failure::Failure;
use crate::loads::Loads;
use crate::state::State;
use crate::vectors::Vectors;
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

/// Bodies and contacts between rods, which solvers ask to act once a step.
pub trait Contacts {
    /// Whether there is nothing to touch, so that nothing has to be asked.
    fn is_empty(&self) -> bool {
        false
    }

    /// Adds contact forces (N) that depend on positions and velocities at `time` (s), for solvers that take forces.
    fn add_forces(&mut self, bundle: &Bundle, state: &State, time: f64, forces: &mut Vectors);

    /// Ends a step of `step` seconds: moves bodies and changes positions and velocities of vertices in contact.
    ///
    /// # Errors
    /// [`SolverError`] where that is impossible.
    fn resolve(&mut self, bundle: &Bundle, state: &mut State, step: f64)
    -> Result<(), SolverError>;

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

    fn add_forces(&mut self, _: &Bundle, _: &State, _: f64, _: &mut Vectors) {}

    fn resolve(&mut self, _: &Bundle, _: &mut State, _: f64) -> Result<(), SolverError> {
        Ok(())
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
