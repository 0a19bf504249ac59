//! The options of a reconstruction, its report, and what can go wrong.

use crate::EXTENT_RANGE;
use crate::stem::StemLocation;
use greenstick_geometry::cloud::PoissonError;
use greenstick_geometry::{Cancelled, ErrorKind, Mesh};

/// How the bark of a scan is reconstructed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOptions {
    /// Share of the girth that must have been seen, 0 to 1, in the metre of the location and in those used beside it.
    pub min_coverage: f64,
    /// Remove the points of a fracture surface: those whose normals run along the axis and those inside the bark.
    pub bark_only: bool,
    /// Close the ends with flat caps.
    pub closed: bool,
}

impl ScanOptions {
    /// Share of the girth that must have been seen by default.
    pub const MIN_COVERAGE: f64 = 0.3;
}

impl Default for ScanOptions {
    fn default() -> Self {
        ScanOptions {
            min_coverage: Self::MIN_COVERAGE,
            bark_only: false,
            closed: true,
        }
    }
}

/// The share of the girth that was seen along a part of the stem.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Coverage {
    /// Where the part begins, m from the base.
    pub from_m: f64,
    /// Where it ends, m from the base.
    pub to_m: f64,
    /// Share, 0 to 1.
    pub share: f64,
}

/// What the stem measures at the requested place, over a length of a diameter. Standard errors are those of the circle
/// through the section's points, from their residual by sectors of 15 degrees and from the share of the girth that was seen,
/// and of the spread of what halves of the points give.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlaceMeasures {
    /// The place, m from the base.
    pub at_m: f64,
    /// The middle of the stem there, m.
    #[serde(default)]
    pub centre_m: [f64; 3],
    /// Diameter of the circle of the section's area, m.
    pub diameter_m: f64,
    /// Its standard error, m.
    pub diameter_error_m: f64,
    /// Girth along the section's outline, without bark relief finer than a sixth of it, m.
    pub girth_m: f64,
    /// Its standard error, m.
    pub girth_error_m: f64,
    /// Girth as a tape measures it, along the convex hull of that outline, m.
    pub tape_girth_m: f64,
    /// By how much the least calliper diameter of that outline is below the greatest, as a share of it.
    #[serde(default)]
    pub ovality: f64,
    /// Its standard error.
    #[serde(default)]
    pub ovality_error: f64,
}

/// The report of a reconstruction.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct ScanReport {
    /// Points of the bark that the surface was made from.
    pub points: usize,
    /// Points near the stem that belong to other limbs or to nothing.
    #[serde(rename = "strangers")]
    pub foreign_points: usize,
    /// Points of a fracture surface that were removed.
    pub fracture_points: usize,
    /// Length of the stem that was traced, m.
    pub stem_length_m: f64,
    /// Standard error of that length, from the spread of the lengths that random halves of the points give, m; of squared
    /// timber from the spread of its sides' ends.
    #[serde(default)]
    pub stem_length_error_m: f64,
    /// The part of it that the surface spans, m from the base.
    pub span_m: [f64; 2],
    /// Mean radius, m.
    pub radius_m: f64,
    /// Standard error of the mean radius, from the residuals and the coverage of the circles through its sections and from
    /// the spread of random halves of the points, m.
    #[serde(default)]
    pub radius_error_m: f64,
    /// Diameter and girth at the place.
    #[serde(default)]
    pub place: Option<PlaceMeasures>,
    /// The same along the part that the surface spans.
    #[serde(default)]
    pub along: Vec<PlaceMeasures>,
    /// Share of the girth that was seen, metre by metre.
    #[serde(rename = "cover")]
    pub coverage: Vec<Coverage>,
    /// Share of the girth that was seen, over the whole traced length.
    #[serde(rename = "mean_cover")]
    pub mean_coverage: f64,
    /// Share of the surface that was completed from what was seen.
    pub completed: f64,
    /// Standard deviation of the points from the surface, m.
    pub noise_m: f64,
    /// Cells around and along the stem.
    pub cells: [usize; 2],
    /// Share of the sections' patches that one ray from the pith meets more than once.
    pub folded: f64,
    /// Remarks, a sentence each.
    pub notes: Vec<String>,
}

/// Bark reconstructed from a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScannedBark {
    /// The surface, m.
    pub mesh: Mesh,
    /// Points of the stem's centreline from its base, m.
    pub centreline: Vec<glam::DVec3>,
    /// The requested location as a point on the surface, by which it is found again in the mesh.
    pub location: StemLocation,
    /// What was done.
    pub report: ScanReport,
}

impl ScannedBark {
    /// Shifts all that has a position.
    pub(super) fn shift(&mut self, by: glam::DVec3) {
        self.mesh.positions.iter_mut().for_each(|p| *p += by);
        self.centreline.iter_mut().for_each(|p| *p += by);
        if let StemLocation::Point(point) = &mut self.location {
            *point += by;
        }
        let places = self.report.place.iter_mut().chain(&mut self.report.along);
        for place in places {
            place.centre_m = (glam::DVec3::from_array(place.centre_m) + by).to_array();
        }
    }
}

/// Which extents are those of wood, for messages.
fn expected_extent() -> String {
    let (least, most) = EXTENT_RANGE;
    format!("expected {least} to {most} m, as of a stem whose unit is right")
}

/// Why bark cannot be reconstructed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScanError {
    /// Nowhere do sections look like a stem's.
    #[error(
        "no stem found among the {points} points: nowhere do they lie on a tube that is longer than wide, nor are they \
         squared timber with four flat sides; a point on the limb, as the place, would show where to look"
    )]
    NoStem {
        /// Points searched.
        points: usize,
    },
    /// The points lie farther apart, or closer together, than those of any tree.
    #[error("the {points} points lie within {extent:.3e} m; {}", expected_extent())]
    Extent {
        /// Points searched.
        points: usize,
        /// Greatest distance between two of them along an axis, m.
        extent: f64,
    },
    /// A length beyond the stem.
    #[error(
        "place {requested} is off the stem, which could be followed for {length:.3} m; expected a place on it"
    )]
    OffStem {
        /// The requested location.
        requested: StemLocation,
        /// Length of the stem, m.
        length: f64,
    },
    /// A point too far from the wood.
    #[error(
        "point {requested} is {distance:.3} m from the stem's axis, where its radius is {radius:.3} m; expected a point \
         on the limb"
    )]
    FarFromWood {
        /// The requested location.
        requested: StemLocation,
        /// Distance from the axis, m.
        distance: f64,
        /// Radius of the stem there, m.
        radius: f64,
    },
    /// Too little of the girth was seen.
    #[error(
        "from {:.2} to {:.2} m along the stem the scan shows {:.0} % of the girth; at least {:.0} % is required",
        .coverage.from_m, .coverage.to_m, .coverage.share * 100.0, .required * 100.0
    )]
    LowCoverage {
        /// What was seen.
        coverage: Coverage,
        /// Share that is required.
        required: f64,
    },
    /// A ray from the pith meets the bark more than once in too many places.
    #[error(
        "from {from:.2} to {to:.2} m along the stem a ray from the pith meets {:.0} % of the sections' patches more than \
         once (loose bark, folds, a hollow): there the bark is no surface over angle and length; expected \
         at most {:.0} %, or a place elsewhere on the stem", .share * 100.0, .max * 100.0
    )]
    NotStarShaped {
        /// Where the part begins, m from the base.
        from: f64,
        /// Where it ends, m from the base.
        to: f64,
        /// Share of the patches.
        share: f64,
        /// Share allowed.
        max: f64,
    },
    /// An option out of its range.
    #[error("the least coverage is {0}; expected a share from 0 to 1")]
    MinCoverage(f64),
    /// Folded bark could not be closed.
    #[error("the folded bark could not be closed: {0}")]
    Surface(PoissonError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ScanError {
    /// Returns the error with the location as it was requested.
    pub(super) fn with_location(mut self, location: &StemLocation) -> Self {
        if let ScanError::OffStem { requested, .. } | ScanError::FarFromWood { requested, .. } =
            &mut self
        {
            *requested = *location;
        }
        self
    }

    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            ScanError::Cancelled(_) => ErrorKind::Cancelled,
            ScanError::NoStem { .. }
            | ScanError::LowCoverage { .. }
            | ScanError::NotStarShaped { .. } => ErrorKind::Work,
            ScanError::Surface(error) => error.kind(),
            _ => ErrorKind::Request,
        }
    }
}

impl From<PoissonError> for ScanError {
    fn from(error: PoissonError) -> Self {
        match error {
            PoissonError::Cancelled(cancelled) => cancelled.into(),
            other => ScanError::Surface(other),
        }
    }
}
