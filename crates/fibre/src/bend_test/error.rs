//! Errors of bending tests.

use crate::error::SolverError;
use crate::placement::PlacementError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::moisture::MoistureError;
use greenstick_wood::species::{StrengthError, UnknownSpecies};
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

/// Why a species cannot be tested.
#[derive(Debug, thiserror::Error)]
pub enum BendingError {
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// A table value is missing.
    #[error(transparent)]
    Moisture(#[from] MoistureError),
    /// Strength along the grain is unknown.
    #[error(transparent)]
    Strength(#[from] StrengthError),
    /// Specimen or solver.
    #[error(transparent)]
    Test(BendError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl BendingError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            BendingError::Cancelled(_) => ErrorKind::Cancelled,
            BendingError::Species(_) | BendingError::Moisture(_) | BendingError::Strength(_) => {
                ErrorKind::Request
            }
            BendingError::Test(
                BendError::Value { .. }
                | BendError::TooFine { .. }
                | BendError::Placement(PlacementError::Value { .. } | PlacementError::NoRods { .. }),
            ) => ErrorKind::Request,
            BendingError::Test(_) => ErrorKind::Work,
        }
    }
}

impl From<BendError> for BendingError {
    fn from(error: BendError) -> Self {
        match error {
            BendError::Cancelled(stop) => BendingError::Cancelled(stop),
            other => BendingError::Test(other),
        }
    }
}
