//! Errors of simulations.

use crate::bodies::BodyError;
use crate::error::SolverError;
use crate::placement::PlacementError;
use crate::scene::SceneError;
use crate::store::RunError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::anatomy::AnatomyError;
use greenstick_wood::species::{StrengthError, UnknownSpecies};
use greenstick_wood::stem::StemError;

/// Why a simulation stopped.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The scene is wrong, or does not fit the stem.
    #[error(transparent)]
    Scene(SceneError),
    /// No stem was found.
    #[error(transparent)]
    Stem(StemError),
    /// The scene is of a mesh that was not given.
    #[error("the scene is of a mesh, and none was given; give one, or choose another stem.kind")]
    NoInput,
    /// The scene names a body's mesh that was not given.
    #[error("body {body} has the shape of the mesh {file}, which was not given")]
    NoBodyMesh {
        /// Number of the body.
        body: usize,
        /// The name in the scene.
        file: String,
    },
    /// The part of the stem that is simulated is too short or too long.
    #[error(
        "{length:.3e} m of the stem would be simulated; scenes are for stems from {least} to {greatest} m: is the unit of the mesh right?"
    )]
    Length {
        /// Length of the part, m.
        length: f64,
        /// Least length of a scene's stem, m.
        least: f64,
        /// Greatest length of a scene's stem, m.
        greatest: f64,
    },
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// The species' strength is not known.
    #[error(transparent)]
    Strength(#[from] StrengthError),
    /// The annual rings do not fit the stem.
    #[error(transparent)]
    Rings(AnatomyError),
    /// The stem cannot be filled with rods.
    #[error(transparent)]
    Placement(PlacementError),
    /// The motion cannot continue.
    #[error("{error}; the checkpoint at {checkpoint} s is kept")]
    Solver {
        /// Why.
        error: SolverError,
        /// Time of the last checkpoint, s.
        checkpoint: f64,
    },
    /// The run cannot be recorded or read.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The checkpoint has other bodies than the scene.
    #[error(transparent)]
    Bodies(BodyError),
    /// There is a run already.
    #[error("{run}: already holds a simulation; resume it, or choose another folder")]
    Taken {
        /// The run.
        run: String,
    },
    /// There is nothing to resume.
    #[error("{run}: holds no checkpoint to resume from")]
    NothingToResume {
        /// The run.
        run: String,
    },
    /// The checkpoint is of another simulation.
    #[error(
        "{run}: its checkpoint is of another simulation: scene, input or seed differ; resume it with those that it was begun with"
    )]
    OtherRun {
        /// The run.
        run: String,
    },
    /// The caller stopped the work. The last checkpoint is kept.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Converts errors, of which those of cancelling are the caller's stop.
macro_rules! from_cancellable {
    ($($error:ident => $variant:ident),*) => {
        $(impl From<$error> for SimulateError {
            fn from(error: $error) -> Self {
                match error {
                    $error::Cancelled(stop) => SimulateError::Cancelled(stop),
                    other => SimulateError::$variant(other),
                }
            }
        })*
    };
}

from_cancellable!(SceneError => Scene, StemError => Stem, AnatomyError => Rings,
    PlacementError => Placement, BodyError => Bodies);

impl SimulateError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SimulateError::Cancelled(_) => ErrorKind::Cancelled,
            SimulateError::Stem(error) => error.kind(),
            SimulateError::Rings(error) => error.kind(),
            SimulateError::Run(error) => error.kind(),
            SimulateError::Solver { .. } | SimulateError::Placement(_) => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}
