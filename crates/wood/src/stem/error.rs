//! Why a stem is not found, and what would work instead.

use super::StemLocation;
use crate::EXTENT_RANGE;
use greenstick_geometry::{Cancelled, ErrorKind};

/// Why there is no stem at a location.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StemError {
    /// The model is empty.
    #[error("the model has no triangles; a stem is found from a triangle mesh")]
    Empty,
    /// A vertex is not finite, or a triangle refers to one that does not exist.
    #[error("mesh {node}: {found}")]
    Invalid {
        /// Index of the mesh.
        node: usize,
        /// What is wrong, and where.
        found: String,
    },
    /// The model is larger, or smaller, than any tree.
    #[error(
        "the model is {extent:.3e} m long; expected {} to {} m, as of a stem whose unit is right (its farthest vertex is \
         {vertex} of mesh {node})", EXTENT_RANGE.0, EXTENT_RANGE.1
    )]
    Extent {
        /// Greatest size of the model along an axis, m.
        extent: f64,
        /// Index of the mesh with the vertex farthest from the origin.
        node: usize,
        /// That vertex.
        vertex: usize,
    },
    /// No shell has plain sections, and borders run along the model: part of its girth is missing.
    #[error(
        "no stem found: {borders} edges have a triangle on one side only, so that sections are open lines; a stem is \
         a tube or a solid; one of which part of the girth is missing can be completed as a scan is"
    )]
    Open {
        /// Number of edges at borders.
        borders: usize,
    },
    /// No shell has plain sections.
    #[error(
        "no stem found: none of the {shells} connected parts of the model has a section that is one closed loop; \
         a stem is a tube or a solid that is longer than wide"
    )]
    NoStem {
        /// Number of connected parts.
        shells: usize,
    },
    /// A fraction or length beyond the stem's.
    #[error(
        "place {requested} is off the stem, which is {length:.4} m long; nearest place that works: {nearest}"
    )]
    OffStem {
        /// The location that was requested.
        requested: StemLocation,
        /// Length of the stem, m.
        length: f64,
        /// The nearest location that works.
        nearest: StemLocation,
    },
    /// A point too far from the wood.
    #[error("point {requested} is {distance:.4} m from the nearest wood, which is at {nearest}")]
    FarFromWood {
        /// The location that was requested.
        requested: StemLocation,
        /// Distance to the nearest surface, m.
        distance: f64,
        /// The nearest point of a surface.
        nearest: StemLocation,
    },
    /// The stem cannot be broken there.
    #[error("at {requested} {found}; nearest place that works: {nearest}")]
    Unusable {
        /// The location that was requested.
        requested: StemLocation,
        /// What was found there.
        found: String,
        /// The nearest location that works.
        nearest: StemLocation,
    },
    /// The limb is not free for a break anywhere.
    #[error("at {requested} {found}, and no other place on this limb is free for a break")]
    NowhereFree {
        /// The location that was requested.
        requested: StemLocation,
        /// What was found there.
        found: String,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl StemError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            StemError::Cancelled(_) => ErrorKind::Cancelled,
            StemError::NoStem { .. } | StemError::Open { .. } | StemError::NowhereFree { .. } => {
                ErrorKind::Work
            }
            _ => ErrorKind::Request,
        }
    }
}
