//! Errors of the file of a section.

use super::error::SectionRingError;
use greenstick_geometry::Cancelled;

/// Why a section has no rings.
#[derive(Debug, thiserror::Error)]
pub enum SectionFileError {
    /// No JSON.
    #[error("the section is no JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A field is missing or has the wrong type.
    #[error("`{field}` {found}; it must be {expected}")]
    Field {
        /// Which, as a path.
        field: String,
        /// What is there.
        found: &'static str,
        /// What would be right.
        expected: &'static str,
    },
    /// The outline, pith or rings do not fit each other.
    #[error(transparent)]
    Rings(#[from] SectionRingError),
    /// Nothing to compare with.
    #[error("there are no annotated `rings` in the section, or none lies within its outline")]
    NotAnnotated,
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
