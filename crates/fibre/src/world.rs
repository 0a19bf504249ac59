//! The world that solvers move: a bundle with its state, loads, failure criteria and history.

use crate::error::LoadError;
use crate::event::Event;
use crate::failure::criteria::FailureCriteria;
use crate::loads::{ClampForce, Loads};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use serde::{Deserialize, Serialize};

/// A bundle, its state, its loads, when it fails, and what has happened to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// The rods and bonds.
    pub bundle: RodBundle,
    /// Their positions and velocities.
    pub state: State,
    /// The loads on them.
    pub loads: Loads,
    /// When they fail.
    pub failure: FailureCriteria,
    /// What has happened, in order.
    pub events: Vec<Event>,
    /// Energy that breaking and yielding have taken, J.
    pub fracture_loss: f64,
    /// Work of forces that solvers left unbalanced, J: by so much the energy is in error. It is part of the world so that the sum
    /// of all steps stays small.
    pub unbalanced_work: f64,
    /// The stability limit as last computed. It is part of the world so that a resumed run takes the same steps.
    pub limit: Option<StabilityLimit>,
    /// The step with which a solver that adapts its steps goes on, s; `None` for the whole. It is part of the world for the same
    /// reason.
    pub next_step: Option<f64>,
    /// The loads under which cracks began to run, in order, until somebody takes them: a load is greatest then, which the end
    /// of a step does not show.
    #[serde(skip)]
    pub onsets: Vec<Onset>,
}

/// The loads under which a crack begins to run.
#[derive(Debug, Clone, PartialEq)]
pub struct Onset {
    /// Time, s.
    pub time: f64,
    /// The force of each clamp.
    pub clamps: Vec<ClampForce>,
}

/// A stability limit of explicit steps, and the world for which it was computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StabilityLimit {
    /// Largest stable step, s.
    pub limit: f64,
    /// The bundle's generation at that time.
    pub generation: u64,
    /// Number of steps taken by that time.
    pub step: u64,
}

impl World {
    /// Whether the wood has been elastic so far: nothing has broken, softened or yielded, so that the path of equilibria has no gaps
    /// and the forces have a potential.
    pub(crate) fn is_elastic(&self) -> bool {
        self.fracture_loss == 0.0
    }

    /// Returns a world with the bundle at rest, without loads and without failure.
    pub fn new(bundle: RodBundle) -> Self {
        let state = State::at_rest(&bundle);
        World {
            bundle,
            state,
            loads: Loads::default(),
            failure: FailureCriteria::default(),
            events: Vec::new(),
            fracture_loss: 0.0,
            unbalanced_work: 0.0,
            limit: None,
            next_step: None,
            onsets: Vec::new(),
        }
    }

    /// Checks loads and failure criteria against the bundle.
    ///
    /// # Errors
    /// [`LoadError`] for the first value that does not fit.
    pub fn check(&self) -> Result<(), LoadError> {
        self.loads.check(&self.bundle)?;
        self.failure.check()
    }
}
