//! Why there is no skin.

use crate::simulate::SimulateError;
use greenstick_fibre::store::RunError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_skin::rods::RodSkinError;

/// Why there is no skin.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The run cannot be read.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no complete frame.
    #[error("{run}: holds no complete frame; run the simulation, or resume it")]
    NoFrames {
        /// The run.
        run: String,
    },
    /// A frame beyond the last.
    #[error("there is no frame {number}: the run has {count}, counted from 0")]
    NoSuchFrame {
        /// The frame asked for.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// The wood of the scene cannot be grown again.
    #[error(transparent)]
    Simulate(SimulateError),
    /// The frames do not fit the wood, or an option is out of range.
    #[error(transparent)]
    Skin(#[from] RodSkinError),
    /// The textures cannot be made.
    #[error(transparent)]
    Work(crate::Error),
    /// The film cannot be written.
    #[error(transparent)]
    Write(greenstick_formats::film::FilmError),
    /// The file cannot be written.
    #[cfg(feature = "files")]
    #[error(transparent)]
    File(#[from] crate::files::FileError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SimulateError> for FilmError {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Cancelled(stop) => FilmError::Cancelled(stop),
            other => FilmError::Simulate(other),
        }
    }
}

impl From<crate::Error> for FilmError {
    fn from(error: crate::Error) -> Self {
        match error {
            crate::Error::Cancelled(stop) => FilmError::Cancelled(stop),
            other => FilmError::Work(other),
        }
    }
}

impl From<greenstick_formats::film::FilmError> for FilmError {
    fn from(error: greenstick_formats::film::FilmError) -> Self {
        match error {
            greenstick_formats::film::FilmError::Cancelled(stop) => FilmError::Cancelled(stop),
            other => FilmError::Write(other),
        }
    }
}

impl FilmError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FilmError::Cancelled(_) => ErrorKind::Cancelled,
            FilmError::File(error) => error.kind(),
            FilmError::Write(error) => error.kind(),
            FilmError::Work(error) => error.kind(),
            FilmError::Simulate(error) => error.kind(),
            FilmError::Run(error) => error.kind(),
            _ => ErrorKind::Request,
        }
    }
}
