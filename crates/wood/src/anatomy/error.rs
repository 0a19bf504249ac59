//! What can go wrong with a stem's anatomy.

use super::limits::{MAX_PARTICLES, MAX_SEGMENTS, RESOLUTION_RANGE};
use crate::rings::{InnerCircleError, RingError};
use greenstick_geometry::{Cancelled, ErrorKind};

/// Why there is no anatomy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AnatomyError {
    /// Voxels that are too coarse or too many.
    #[error(
        "a resolution of {0} voxels; expected {least} to {most}",
        least = RESOLUTION_RANGE.start(), most = RESOLUTION_RANGE.end()
    )]
    Resolution(usize),
    /// No plane along the stem meets it.
    #[error("none of the {0} sections that were tried along the stem has an outline")]
    NoSections(usize),
    /// A stem that is too long for its width.
    #[error(
        "the stem is {length:.3} m long and {width:.5} m wide, which makes {segments} segments; expected at most {MAX_SEGMENTS}"
    )]
    TooLong {
        /// Length, m.
        length: f64,
        /// Width, m.
        width: f64,
        /// Segments it would be divided into.
        segments: usize,
    },
    /// Rings of a board by erosion.
    #[error(
        "rings of a board by erosion, which would follow its faces; expected a round stem, or rings by the field"
    )]
    BoardErosion,
    /// An erosion whose inner circle is out of range.
    #[error(transparent)]
    InnerCircle(#[from] InnerCircleError),
    /// Rings that do not fit the section.
    #[error(transparent)]
    Rings(#[from] RingError),
    /// More particles than memory holds.
    #[error("{0} particles; expected at most {MAX_PARTICLES}")]
    TooManyParticles(u64),
    /// A number of something in a request that is out of range.
    #[error("{found} {what}; expected {least} to {most}")]
    Amount {
        /// What it is the number of.
        what: &'static str,
        /// The number.
        found: u64,
        /// The least that is possible.
        least: u64,
        /// The most.
        most: u64,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl AnatomyError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            AnatomyError::Cancelled(_) => ErrorKind::Cancelled,
            AnatomyError::NoSections(_) | AnatomyError::TooLong { .. } => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}
