//! Bark from a point cloud that is cleaned first.

use super::reconstruct_bark;
use super::report::{ScanError, ScanOptions, ScannedBark};
use crate::stem::StemLocation;
use greenstick_geometry::cloud::{CleanError, CleanOptions, CleanReport, clean};
use greenstick_geometry::{Cancelled, Context, ErrorKind, PointCloud, Stage};

/// Everything that determines the bark of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScanRequest {
    /// Steps of the cleaning.
    pub clean: CleanOptions,
    /// How the bark is reconstructed.
    pub scan: ScanOptions,
}

/// Why there is no bark of a scan.
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

/// Cleans a cloud and reconstructs the bark of the stem at a location of it. Returns the points that were left as well.
///
/// # Errors
/// [`ScanningError`] where the cloud cannot be cleaned or has no stem there.
pub fn clean_and_reconstruct(
    cloud: &PointCloud,
    location: &StemLocation,
    request: &ScanRequest,
    context: &Context,
) -> Result<(CleanReport, ScannedBark, PointCloud), ScanningError> {
    let [cleaning, finding] =
        context.split([(Stage::new("clean"), 1.0), (Stage::new("bark"), 2.0)]);
    let (cloud, cleaned) = clean(cloud, &request.clean, &cleaning)?;
    let bark = reconstruct_bark(&cloud, location, &request.scan, &finding)?;
    Ok((cleaned, bark, cloud))
}
