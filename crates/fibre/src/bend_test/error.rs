//! Errors of bending tests.

use crate::error::SolverError;
use crate::placement::PlacementError;
use greenstick_geometry::Cancelled;
use greenstick_wood::stem::StemError;

/// Why a bending test has no outcome.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BendError {
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
    /// More unknowns than are sensible.
    #[error(
        "{rods:.0} rods of {sections:.0} sections need a matrix of about {gigabytes:.0} GB, but at most {most:.0} GB are \
         allowed; use fewer rods or longer edges"
    )]
    TooFine {
        /// Approximate number of rods.
        rods: f64,
        /// Approximate number of cross-sections along the specimen.
        sections: f64,
        /// Size of the matrix, GB.
        gigabytes: f64,
        /// The largest size allowed, GB.
        most: f64,
    },
    /// No stem is found in the specimen.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// The specimen cannot be filled.
    #[error(transparent)]
    Placement(PlacementError),
    /// There is no equilibrium.
    #[error(transparent)]
    Solver(SolverError),
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PlacementError> for BendError {
    fn from(error: PlacementError) -> Self {
        match error {
            PlacementError::Cancelled(cancelled) => BendError::Cancelled(cancelled),
            other => BendError::Placement(other),
        }
    }
}

impl From<SolverError> for BendError {
    fn from(error: SolverError) -> Self {
        match error {
            SolverError::Cancelled(cancelled) => BendError::Cancelled(cancelled),
            other => BendError::Solver(other),
        }
    }
}
