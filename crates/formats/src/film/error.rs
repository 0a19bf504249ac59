//! Why a film could not be written.

use crate::error::FormatError;
use greenstick_geometry::{Cancelled, ErrorKind};
use std::error::Error;

/// Why a film could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The film cannot be represented in the format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Writing to the file failed.
    #[error("{file}: cannot be written: {source}")]
    Write {
        /// Name of the file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The poses of a frame are not available.
    #[error("{file}: the poses of frame {frame} are not available: {source}")]
    Motion {
        /// Name of the file that was being written.
        file: String,
        /// Number of the frame, from 0.
        frame: usize,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FilmError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FilmError::Cancelled(_) => ErrorKind::Cancelled,
            _ => ErrorKind::Work,
        }
    }
}
