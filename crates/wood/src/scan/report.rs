//! What is asked of a scan, what was found, and what can go wrong.

use crate::stem::Place;
use greenstick_geometry::cloud::PoissonError;
use greenstick_geometry::{Cancelled, Mesh};

/// How the bark of a scan is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOptions {
    /// Share of the girth that must have been seen, in the metre of the place and in those kept beside it, 0 to 1.
    pub least_cover: f64,
    /// Cut off the points of a fracture surface: those whose normals run along the axis and those inside the bark.
    pub bark_only: bool,
    /// Close the ends with flat caps.
    pub closed: bool,
}

impl Default for ScanOptions {
    fn default() -> Self {
        ScanOptions {
            least_cover: 0.3,
            bark_only: false,
            closed: true,
        }
    }
}

/// The share of the girth that was seen along a part of the stem.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Cover {
    /// Where the part begins, m from the base.
    pub from_m: f64,
    /// Where it ends, m from the base.
    pub to_m: f64,
    /// Share, 0 to 1.
    pub share: f64,
}

/// What was made of a scan.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct ScanReport {
    /// Points of the bark that the surface was made from.
    pub points: usize,
    /// Points near the stem that belong to other limbs or to nothing.
    pub strangers: usize,
    /// Points of a fracture surface that were cut off.
    pub fracture_points: usize,
    /// Length of the stem that was followed, m.
    pub stem_length_m: f64,
    /// Part of it that the surface spans, m from the base.
    pub span_m: [f64; 2],
    /// Mean radius, m.
    pub radius_m: f64,
    /// Share of the girth that was seen, metre by metre.
    pub cover: Vec<Cover>,
    /// Share of the girth that was seen, of all that was followed.
    pub mean_cover: f64,
    /// Share of the surface that was completed from what was seen.
    pub completed: f64,
    /// Standard deviation of the points from the surface, m.
    pub noise_m: f64,
    /// Cells around and along the stem.
    pub cells: [usize; 2],
    /// Share of the sections' parts that one ray from the pith meets more than once.
    pub folded: f64,
    /// What else is worth knowing, a sentence each.
    pub notes: Vec<String>,
}

/// Bark from a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScannedBark {
    /// The surface, m.
    pub mesh: Mesh,
    /// Points of the stem's centreline from its base, m.
    pub centreline: Vec<glam::DVec3>,
    /// The place asked for as a point on the surface: what finds it again in the mesh.
    pub place: Place,
    /// What was done.
    pub report: ScanReport,
}

/// Why there is no bark.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScanError {
    /// Nowhere do sections look like a stem's.
    #[error(
        "no stem found among the {points} points: nowhere do they lie on a tube that is longer than wide, nor are they \
         squared timber with four flat sides; a point of the limb, as a place, tells where to look"
    )]
    NoStem {
        /// Points searched.
        points: usize,
    },
    /// A length beyond the stem.
    #[error(
        "place {asked} is off the stem, which could be followed for {length:.3} m; expected a place on it"
    )]
    OffStem {
        /// The place asked for.
        asked: Place,
        /// Length of the stem, m.
        length: f64,
    },
    /// A point in the air.
    #[error(
        "point {asked} is {distance:.3} m from the stem's axis, where its radius is {radius:.3} m; expected a point of the limb"
    )]
    FarFromWood {
        /// The place asked for.
        asked: Place,
        /// Distance from the axis, m.
        distance: f64,
        /// Radius of the stem there, m.
        radius: f64,
    },
    /// Too little of the girth was seen.
    #[error(
        "from {:.2} to {:.2} m along the stem the scan shows {:.0} % of the girth; at least {:.0} % are asked for",
        .cover.from_m, .cover.to_m, .cover.share * 100.0, .least * 100.0
    )]
    LittleCover {
        /// What was seen.
        cover: Cover,
        /// Share asked for.
        least: f64,
    },
    /// A ray from the pith meets the bark more than once in too many places.
    #[error(
        "from {from:.2} to {to:.2} m along the stem a ray from the pith meets {:.0} % of the sections' parts more than once \
         (loose bark, folds, a hollow): there the bark is no surface over angle and length; expected \
         at most {:.0} %, or a place elsewhere on the stem", .share * 100.0, .most * 100.0
    )]
    NotStarShaped {
        /// Where the part begins, m from the base.
        from: f64,
        /// Where it ends, m from the base.
        to: f64,
        /// Share of the parts.
        share: f64,
        /// Share allowed.
        most: f64,
    },
    /// An option out of its range.
    #[error("the least cover is {0}; expected a share from 0 to 1")]
    LeastCover(f64),
    /// Folded bark could not be closed.
    #[error("the folded bark could not be closed: {0}")]
    Surface(PoissonError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PoissonError> for ScanError {
    fn from(error: PoissonError) -> Self {
        match error {
            PoissonError::Cancelled(cancelled) => cancelled.into(),
            other => ScanError::Surface(other),
        }
    }
}
