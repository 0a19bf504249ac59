//! Errors of bodies.

use glam::DVec3;

/// Why bodies cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// A number out of range.
    #[error("{what} of body {body} is {value}, but it must be {right}")]
    Value {
        /// Number of the body.
        body: usize,
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
    /// A shape that is no solid.
    #[error("the {shape} of body {body} cannot be used: {problem}")]
    Shape {
        /// Number of the body.
        body: usize,
        /// Name of the shape.
        shape: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// Two bodies overlap at the start.
    #[error(
        "bodies {first} and {second} overlap by {depth} m at {place} at the start; move them apart by at least that"
    )]
    Overlap {
        /// Name or number of one body.
        first: String,
        /// Name or number of the other.
        second: String,
        /// Depth of the overlap, m.
        depth: f64,
        /// Its position, m.
        place: DVec3,
    },
    /// A rod is inside a body at the start.
    #[error(
        "rod {rod} is {depth} m deep in body {body} at {place} at the start; move the body away by at least that"
    )]
    RodInside {
        /// Number of the rod.
        rod: usize,
        /// Name or number of the body.
        body: String,
        /// Depth of the overlap, m.
        depth: f64,
        /// Its position, m.
        place: DVec3,
    },
    /// A checkpoint of other bodies.
    #[error("the state is that of {found} bodies, but there are {expected}")]
    Count {
        /// In the state.
        found: usize,
        /// In the scene.
        expected: usize,
    },
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] greenstick_geometry::Cancelled),
}
