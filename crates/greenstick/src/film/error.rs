//! Why there is no skin.

use crate::simulate::SimulateError;
use greenstick_fibre::store::RunError;
use greenstick_geometry::Cancelled;
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
