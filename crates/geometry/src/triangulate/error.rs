//! Why a polygon cannot be triangulated.

/// Why a polygon cannot be triangulated. No triangles are appended then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TriangulateError {
    /// A ring has fewer than three points.
    #[error("the ring from point {start} on has {count} points; expected at least 3")]
    TooFew {
        /// First point of the ring.
        start: usize,
        /// Its number of points.
        count: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// Two edges meet elsewhere than at a common end, or two points coincide.
    #[error(
        "the edges from points {0} and {1} cross or touch; a polygon's edges may only meet at their ends"
    )]
    Crossing(usize, usize),
    /// All points of a ring with holes, or of a hole, lie on one line.
    #[error("the ring from point {0} on has no area")]
    NoArea(usize),
    /// A hole lies outside the outer ring or inside another hole.
    #[error("the hole from point {0} on lies outside the polygon or within another hole")]
    HoleOutside(usize),
    /// The starts of the holes are not ascending, or beyond the last point.
    #[error(
        "a hole starts at point {0}; expected a point after the ring before it and not beyond the last point"
    )]
    BadHoleStart(usize),
    /// No triangulation was found although the edges are valid.
    #[error("found no triangulation of the polygon of {0} points")]
    Stuck(usize),
}
