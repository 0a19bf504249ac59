//! Why a scan gives no scene.

use greenstick_geometry::Cancelled;
use greenstick_geometry::cloud::CleanError;
use greenstick_wood::scan::ScanError;

/// Why a scan gives no scene.
#[derive(Debug, thiserror::Error)]
pub enum ScanningError {
    /// The cloud cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// There is no bark.
    #[error(transparent)]
    Scan(#[from] ScanError),
}

impl From<Cancelled> for ScanningError {
    fn from(cancelled: Cancelled) -> Self {
        ScanningError::Scan(cancelled.into())
    }
}
