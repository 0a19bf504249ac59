//! Errors of stills and films.

use crate::rods::RodSkinError;
use crate::texture::TextureError;
use greenstick_fibre::store::RunError;
use greenstick_geometry::{Cancelled, ErrorKind};

/// Why there is no still or film.
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
        /// The number of the frame.
        number: usize,
        /// How many frames there are.
        count: usize,
    },
    /// Pieces that have no rods.
    #[error("no rod belongs to the pieces that the wood was cut into; show its rods instead")]
    NoRods,
    /// The frames do not fit the wood, or an option is out of range.
    #[error(transparent)]
    Skin(#[from] RodSkinError),
    /// The textures cannot be made.
    #[error(transparent)]
    Texture(TextureError),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<TextureError> for FilmError {
    fn from(error: TextureError) -> Self {
        match error {
            TextureError::Cancelled(cancelled) => FilmError::Cancelled(cancelled),
            other => FilmError::Texture(other),
        }
    }
}

impl FilmError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FilmError::Cancelled(_) => ErrorKind::Cancelled,
            FilmError::Run(error) => error.kind(),
            FilmError::Texture(error) => error.kind(),
            _ => ErrorKind::Request,
        }
    }
}
