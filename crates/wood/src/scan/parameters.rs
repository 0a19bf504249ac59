//! Parameters of the reconstruction of bark from a scan.

use super::cleaned::ScanRequest;
use super::report::ScanOptions;
use greenstick_geometry::cloud::CleanOptions;
use greenstick_schema::{Unit, flag, length, number, parameters};

/// Greatest multiple of a cloud's spread that a step of the cleaning takes.
const MAX_MULTIPLE: f64 = 1e6;
/// Greatest spacing of a cloud, m.
const MAX_SPACING: f64 = 1000.0;

parameters! {
    /// How a point cloud becomes the bark of a stem.
    pub struct ScanParameters {
        "Point clouds", "input" {
            /// Treat a mesh as a scan: its bark is reconstructed and its holes are closed.
            as_scan: bool = false, flag();
            /// Keep points farther from their neighbours than the others are from theirs.
            no_outliers: bool = false, flag();
            /// Drop points whose mean distance to their neighbours exceeds the cloud's by this many standard deviations.
            outliers: f64 = CleanOptions::OUTLIER_DEVIATIONS, number(Unit::One, 0.0, MAX_MULTIPLE).above().logarithmic();
            /// Keep points without others near them.
            no_isolated: bool = false, flag();
            /// Drop points without two others within this many spacings of the cloud.
            isolated: f64 = CleanOptions::ISOLATED_SPACINGS, number(Unit::One, 0.0, MAX_MULTIPLE).above().logarithmic();
            /// Keep points at equal positions.
            no_duplicates: bool = false, flag();
            /// Refuse points whose coordinates are not finite instead of dropping them.
            all_finite: bool = false, flag();
            /// Thin the cloud to this spacing; 0 leaves it as it is.
            spacing: f64 = 0.0, length(0.0, MAX_SPACING);
            /// Cut off the points of a fracture surface and keep the bark.
            bark_only: bool = false, flag();
            /// Share of the girth that must have been seen, along the metre of the location and those used beside it.
            min_coverage as "least_cover": f64 = ScanOptions::MIN_COVERAGE, number(Unit::Fraction, 0.0, 1.0);
        }
    }
}

impl ScanParameters {
    /// Returns the request.
    pub fn request(&self) -> ScanRequest {
        ScanRequest {
            clean: CleanOptions {
                not_finite: !self.all_finite,
                duplicates: !self.no_duplicates,
                outliers: (!self.no_outliers).then_some(self.outliers),
                isolated: (!self.no_isolated).then_some(self.isolated),
                spacing: Some(self.spacing).filter(|s| *s > 0.0),
            },
            scan: ScanOptions {
                bark_only: self.bark_only,
                min_coverage: self.min_coverage,
                ..ScanOptions::default()
            },
        }
    }
}
