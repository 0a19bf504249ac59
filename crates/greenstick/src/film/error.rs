//! Why there is no skin.

use crate::simulate::SimulateError;
use greenstick_fibre::scene::SceneError;
use greenstick_fibre::store::StoreError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_skin::rods::RodSkinError;
use std::io;
use std::path::PathBuf;

/// Why there is no skin.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The folder holds no run.
    #[error(
        "{}: holds no simulation: scene.toml cannot be read ({source}); expected the folder of a simulated run",
        folder.display()
    )]
    NoRun {
        /// The folder.
        folder: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The run's scene cannot be used.
    #[error("{}: {error}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: SceneError,
    },
    /// The frames cannot be used.
    #[error("{}: {error}", path.display())]
    Store {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: StoreError,
    },
    /// There is no whole frame.
    #[error("{}: holds no whole frame; run the simulation, or resume it", path.display())]
    NoFrames {
        /// The file.
        path: PathBuf,
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
    Simulate(#[from] SimulateError),
    /// The frames do not fit the wood, or an option is out of range.
    #[error(transparent)]
    Skin(#[from] RodSkinError),
    /// The textures cannot be made.
    #[error(transparent)]
    Work(#[from] crate::Error),
    /// The film cannot be written.
    #[error(transparent)]
    Write(#[from] greenstick_formats::film::FilmError),
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] crate::files::FileError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
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
            _ => ErrorKind::Request,
        }
    }
}
