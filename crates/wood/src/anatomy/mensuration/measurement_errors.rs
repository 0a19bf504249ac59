//! Standard errors of what is measured on a stem that was reconstructed from a scan.

use crate::scan::{PlaceMeasures, ScanReport};
use glam::DVec3;

/// What a scan's report says about errors and coverage along the stem.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasurementErrors {
    /// Measures with their errors along the stem, not empty.
    places: Vec<PlaceMeasures>,
    /// The share of the girth that was seen at each of them.
    seen: Vec<f64>,
    /// Standard error of the stem's length, m.
    pub length: f64,
}

/// Standard errors at a place of the stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ErrorsAt {
    /// Of the diameter by area, m.
    pub diameter: f64,
    /// The same as a share of the diameter.
    pub relative: f64,
    /// Of the girth, m.
    pub girth: f64,
    /// Of the ovality.
    pub ovality: f64,
    /// The share of the girth that was seen, 0 to 1.
    pub seen: f64,
}

impl MeasurementErrors {
    /// Returns the errors of a scan; `None` where nothing could be measured along it.
    pub fn from_scan(report: &ScanReport) -> Option<Self> {
        let seen = |place: &PlaceMeasures| {
            let part = report.coverage.iter().find(|c| place.at_m <= c.to_m);
            part.map_or(report.mean_coverage, |c| c.share)
        };
        (!report.along.is_empty()).then(|| MeasurementErrors {
            seen: report.along.iter().map(seen).collect(),
            places: report.along.clone(),
            length: report.stem_length_error_m,
        })
    }

    /// The errors where the stem's middle is at `centre`, m: those of the nearest place that was measured.
    pub(super) fn at(&self, centre: DVec3) -> Option<ErrorsAt> {
        let distance = |k: usize| DVec3::from(self.places[k].centre_m).distance_squared(centre);
        let nearest =
            (0..self.places.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        let place = &self.places[nearest];
        Some(ErrorsAt {
            diameter: place.diameter_error_m,
            relative: place.diameter_error_m / place.diameter_m,
            girth: place.girth_error_m,
            ovality: place.ovality_error,
            seen: self.seen[nearest],
        })
    }
}
