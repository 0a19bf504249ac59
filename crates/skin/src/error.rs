//! Why a stem cannot be broken.

use glam::DVec3;
use greenstick_fracture::cracks::CrackError;
use greenstick_fracture::cut::CutError;
use greenstick_geometry::Cancelled;
use greenstick_wood::stem::StemError;

/// Why a stem cannot be broken.
#[derive(Debug, thiserror::Error)]
pub enum BreakError {
    /// There is no stem at the location.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// The mesh cannot be cut.
    #[error("{error}; in the world that is at {at:.5} (m)")]
    Cut {
        /// What went wrong.
        error: CutError,
        /// Where, m.
        at: DVec3,
    },
    /// Cracks cannot be made.
    #[error(transparent)]
    Crack(CrackError),
    /// The pieces may not have as few triangles.
    #[error("{most} triangles are too few for this break: even the coarsest face adds {least}")]
    TooFewTriangles {
        /// How many they may add to those of the stem.
        most: usize,
        /// How many they add at least.
        least: usize,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<CrackError> for BreakError {
    fn from(error: CrackError) -> Self {
        match error {
            CrackError::Cancelled(cancelled) => BreakError::Cancelled(cancelled),
            error => BreakError::Crack(error),
        }
    }
}
