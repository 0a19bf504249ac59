//! Errors between a recorded run and the files of its skin.

use crate::simulate::SimulateError;
use greenstick_fibre::store::RunError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_skin::film;

/// Why there is no skin.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The run cannot be read, or no still or film can be made of it.
    #[error(transparent)]
    Skin(film::FilmError),
    /// The wood of the scene cannot be grown again.
    #[error(transparent)]
    Simulate(SimulateError),
    /// The textures cannot be made, or a format cannot represent the result.
    #[error(transparent)]
    Work(crate::Error),
    /// The film cannot be written.
    #[error(transparent)]
    Write(greenstick_formats::film::FilmError),
    /// The file cannot be written.
    #[cfg(feature = "files")]
    #[error(transparent)]
    File(#[from] crate::files::FileError),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<film::FilmError> for FilmError {
    fn from(error: film::FilmError) -> Self {
        match error {
            film::FilmError::Cancelled(cancelled) => FilmError::Cancelled(cancelled),
            film::FilmError::Texture(error) => FilmError::Work(error.into()),
            other => FilmError::Skin(other),
        }
    }
}

impl From<RunError> for FilmError {
    fn from(error: RunError) -> Self {
        FilmError::Skin(error.into())
    }
}

impl From<SimulateError> for FilmError {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Cancelled(cancelled) => FilmError::Cancelled(cancelled),
            other => FilmError::Simulate(other),
        }
    }
}

impl From<crate::Error> for FilmError {
    fn from(error: crate::Error) -> Self {
        match error {
            crate::Error::Cancelled(cancelled) => FilmError::Cancelled(cancelled),
            other => FilmError::Work(other),
        }
    }
}

impl From<greenstick_formats::film::FilmError> for FilmError {
    fn from(error: greenstick_formats::film::FilmError) -> Self {
        match error {
            greenstick_formats::film::FilmError::Cancelled(cancelled) => {
                FilmError::Cancelled(cancelled)
            }
            other => FilmError::Write(other),
        }
    }
}

impl FilmError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FilmError::Cancelled(_) => ErrorKind::Cancelled,
            FilmError::Write(error) => error.kind(),
            FilmError::Work(error) => error.kind(),
            FilmError::Simulate(error) => error.kind(),
            FilmError::Skin(error) => error.kind(),
            #[cfg(feature = "files")]
            FilmError::File(error) => error.kind(),
        }
    }
}
