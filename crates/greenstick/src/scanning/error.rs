//! Errors of scans.

use greenstick_geometry::cloud::CleanError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::scan::ScanError;

/// Why there is no scene of a scan.
#[derive(Debug, thiserror::Error)]
pub enum ScanningError {
    /// The cloud cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// No bark can be reconstructed.
    #[error(transparent)]
    Scan(#[from] ScanError),
}

impl ScanningError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            ScanningError::Clean(error) => error.kind(),
            ScanningError::Scan(error) => error.kind(),
        }
    }
}

impl From<Cancelled> for ScanningError {
    fn from(cancelled: Cancelled) -> Self {
        ScanningError::Scan(cancelled.into())
    }
}
