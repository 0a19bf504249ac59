//! What can go wrong with the rings of a section.

use super::super::InnerCircleError;
use super::super::series::RingError;
use greenstick_geometry::{Cancelled, ErrorKind};

/// Why a section has no rings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectionRingError {
    /// The outline, pith or rings do not fit each other.
    #[error(transparent)]
    Rings(#[from] RingError),
    /// The circle that an erosion starts from does not lie in the section.
    #[error(transparent)]
    InnerCircle(#[from] InnerCircleError),
    /// The section is too small for its pixels.
    #[error(
        "no pass takes anything off the section at {resolution} × {resolution} pixels; expected a wider outline or more pixels"
    )]
    NotEroded {
        /// Pixels along a side.
        resolution: usize,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SectionRingError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SectionRingError::Cancelled(_) => ErrorKind::Cancelled,
            _ => ErrorKind::Request,
        }
    }
}
