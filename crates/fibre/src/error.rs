//! Errors of bundles, loads and solvers.

/// Why a bundle of rods cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RodBundleError {
    /// No rods.
    #[error("a bundle needs at least one rod, but there is none")]
    NoRods,
    /// A rod of fewer than two vertices.
    #[error("rod {rod} has {count} vertices, but a rod needs at least 2")]
    ShortRod {
        /// Rod.
        rod: usize,
        /// Vertices found.
        count: usize,
    },
    /// More vertices or bonds than indices can number.
    #[error("{count} {what} are more than the {most} that can be numbered")]
    TooMany {
        /// Vertices or bonds.
        what: &'static str,
        /// How many.
        count: usize,
        /// The largest number possible.
        most: usize,
    },
    /// A number out of range.
    #[error("{what} of rod {rod} is {value}, but it must be {right}")]
    Rod {
        /// Rod.
        rod: usize,
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
    /// Two vertices at the same position.
    #[error("vertices {vertex} and {} of rod {rod} lie {length} m apart, but an edge needs a length above 0", vertex + 1)]
    Edge {
        /// Rod.
        rod: usize,
        /// Vertex within the rod.
        vertex: usize,
        /// Length found, m.
        length: f64,
    },
    /// A rod folds back on itself.
    #[error(
        "rod {rod} folds straight back at its vertex {vertex}; the angle between edges must be below 180°"
    )]
    Fold {
        /// Rod.
        rod: usize,
        /// Vertex within the rod.
        vertex: usize,
    },
    /// Rods without twist have no material frame that could hold a natural curvature.
    #[error(
        "rod {rod} is curved at its vertex {vertex} (by {angle} rad), so twist must be on; without twist rods must be straight"
    )]
    Curved {
        /// Rod.
        rod: usize,
        /// Vertex within the rod.
        vertex: usize,
        /// Angle between the edges, rad.
        angle: f64,
    },
    /// A bond that does not join two rods, or has a number out of range.
    #[error("bond {bond}: {what} is {value}, but it must be {right}")]
    Bond {
        /// Bond.
        bond: usize,
        /// Which quantity.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
}

/// Why a load cannot be applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// A load names a vertex that does not exist.
    #[error("{what} names vertex {vertex}, but the bundle has {count} vertices")]
    Vertex {
        /// Which load.
        what: &'static str,
        /// The vertex named.
        vertex: u32,
        /// Vertices there are.
        count: usize,
    },
    /// A load names an edge that does not exist, or the gap behind a rod's last vertex.
    #[error("{what} names edge {edge}, which is no edge of a rod")]
    Edge {
        /// Which load.
        what: &'static str,
        /// The edge named.
        edge: u32,
    },
    /// A clamp that holds no vertex.
    #[error("clamp {clamp} holds no vertex; it must hold at least one")]
    EmptyClamp {
        /// Number of the clamp.
        clamp: usize,
    },
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
}

/// Why a solver stopped.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolverError {
    /// The given step is too large.
    #[error(
        "a step of {given} s is not stable: the limit is {limit} s (twice the inverse of the highest frequency); give a smaller step, or none to have one chosen"
    )]
    UnstableStep {
        /// The step given, s.
        given: f64,
        /// The largest stable step, s.
        limit: f64,
    },
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
    /// The motion grew without bound; the state is the one before this step.
    #[error(
        "the motion blew up at {time} s: {energy} energy of rod {rod} grew from {before} J to {after} J in one step of {step} s; \
         use a smaller step, softer contacts or more damping"
    )]
    BlowUp {
        /// Time, s.
        time: f64,
        /// Step, s.
        step: f64,
        /// Rod of the largest growth.
        rod: u32,
        /// Name of that energy.
        energy: &'static str,
        /// That energy before, J.
        before: f64,
        /// That energy after, J.
        after: f64,
    },
    /// The iteration did not converge; the state is the one before this step.
    #[error(
        "no equilibrium at {time} s after {iterations} iterations: the residual is {residual} N, and must fall to {tolerance} N; use smaller load steps"
    )]
    NotConverged {
        /// Time, s.
        time: f64,
        /// Iterations done.
        iterations: usize,
        /// Largest unbalanced force, N.
        residual: f64,
        /// The residual that counts as converged, N.
        tolerance: f64,
    },
    /// A load does not fit the bundle.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The caller cancelled the work; the state is the one before this step.
    #[error(transparent)]
    Cancelled(#[from] greenstick_geometry::Cancelled),
}
