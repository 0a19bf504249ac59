//! Why a stem is not found, with what would work.

use super::Place;
use greenstick_geometry::Cancelled;

/// Why there is no stem at a place.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StemError {
    /// There is nothing to break.
    #[error("the model has no triangles; a stem is found from a triangle mesh")]
    Empty,
    /// A vertex is not a number or a triangle names one that is not there.
    #[error("mesh {node}: {found}")]
    Invalid {
        /// Index of the mesh.
        node: usize,
        /// What and where.
        found: String,
    },
    /// No shell has sections.
    #[error(
        "no stem found: none of the {shells} connected parts of the model has a section that is one closed loop; \
         a stem is a tube or a solid that is longer than wide"
    )]
    NoStem {
        /// Number of connected parts.
        shells: usize,
    },
    /// A fraction or length that the stem does not have.
    #[error(
        "place {asked} is off the stem, which is {length:.4} m long; nearest place that works: {nearest}"
    )]
    OffStem {
        /// The place asked for.
        asked: Place,
        /// Length of the stem, m.
        length: f64,
        /// The nearest place that works.
        nearest: Place,
    },
    /// A point in the air.
    #[error("point {asked} is {distance:.4} m from the nearest wood, which is at {nearest}")]
    FarFromWood {
        /// The place asked for.
        asked: Place,
        /// Distance to the nearest surface, m.
        distance: f64,
        /// The nearest point of a surface.
        nearest: Place,
    },
    /// The stem cannot be broken there.
    #[error("at {asked} {found}; nearest place that works: {nearest}")]
    Unusable {
        /// The place asked for.
        asked: Place,
        /// What was found there.
        found: String,
        /// The nearest place that works.
        nearest: Place,
    },
    /// The limb has no free place at all.
    #[error("at {asked} {found}, and no other place on this limb is free for a break")]
    NowhereFree {
        /// The place asked for.
        asked: Place,
        /// What was found there.
        found: String,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
