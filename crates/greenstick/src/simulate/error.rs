//! Why a simulation stops.

use crate::files::FileError;
use greenstick_fibre::SolverError;
use greenstick_fibre::bodies::BodyError;
use greenstick_fibre::placement::PlacementError;
use greenstick_fibre::scene::SceneError;
use greenstick_fibre::store::StoreError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::species::{StrengthError, UnknownSpecies};
use greenstick_wood::stem::{StemError, StemLocationError};
use std::io;
use std::path::PathBuf;

/// Why a simulation stopped.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The scene is wrong, or does not fit the stem.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The place on the input is wrong.
    #[error("stem.at: {0}")]
    Place(#[from] StemLocationError),
    /// No stem was found.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// A scene of an input without one.
    #[error(
        "the scene is of a mesh, and none was given; name one behind the scene, or choose another stem.kind"
    )]
    NoInput,
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// The species' strength is not known.
    #[error(transparent)]
    Strength(#[from] StrengthError),
    /// No rods.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The motion cannot go on.
    #[error("{error}; the checkpoint at {checkpoint} s is kept")]
    Solver {
        /// Why.
        error: SolverError,
        /// Time of the last checkpoint, s.
        checkpoint: f64,
    },
    /// A body's mesh file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something stored is of another run, or damaged.
    #[error("{}: {error}", path.display())]
    Store {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: StoreError,
    },
    /// A checkpoint of bodies that are others.
    #[error(transparent)]
    Bodies(#[from] BodyError),
    /// The folder already holds a run.
    #[error("{}: already holds a simulation; resume it, or choose another folder", folder.display())]
    Taken {
        /// The folder.
        folder: PathBuf,
    },
    /// There is nothing to resume.
    #[error("{}: holds no checkpoint to resume from", folder.display())]
    NothingToResume {
        /// The folder.
        folder: PathBuf,
    },
    /// The checkpoint is of another simulation.
    #[error(
        "{}: is the checkpoint of another simulation: scene, input or seed differ; resume with those it was begun with",
        path.display()
    )]
    OtherRun {
        /// The checkpoint.
        path: PathBuf,
    },
    /// A file is shorter than the checkpoint says.
    #[error("{}: has {found} bytes, but the checkpoint was written when it had {expected}; it was changed since", path.display())]
    Short {
        /// The file.
        path: PathBuf,
        /// Its length.
        found: u64,
        /// What it must have at least.
        expected: u64,
    },
    /// The disk is full, or the like.
    #[error("{}: cannot be written: {source}; what the checkpoint holds is kept, and the run can be resumed", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The caller stopped the work; the checkpoint is there.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SimulateError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SimulateError::Cancelled(_) => ErrorKind::Cancelled,
            SimulateError::File(error) => error.kind(),
            SimulateError::Stem(error) => error.kind(),
            SimulateError::Solver { .. }
            | SimulateError::Placement(_)
            | SimulateError::Unwritable { .. } => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}
