//! Errors of bending tests.

use crate::error::SolverError;
use crate::placement::PlacementError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::moisture::MoistureError;
use greenstick_wood::species::{StrengthError, UnknownSpecies, UnknownVariation};
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
    /// The scatter of the species' wood is unknown.
    #[error(transparent)]
    Variation(#[from] UnknownVariation),
    /// No specimens, or too many.
    #[error("the number of specimens is {found}, but it must be 1 to {most}")]
    Specimens {
        /// The number found.
        found: u32,
        /// The most that are tested.
        most: u32,
    },
    /// A Weibull modulus of flaws that is no such number.
    #[error("the Weibull modulus of flaws is {0}, but it must be 1 or more, infinite for none")]
    Weibull(f64),
    /// Flaws scatter more than all of the wood.
    #[error(
        "flaws with a Weibull modulus of {modulus} scatter the modulus of rupture by {scatter:.1} %, but Wood Handbook Table \
         5-6 leaves at most {most:.1} % of its scatter besides that of density; give a greater modulus"
    )]
    Flaws {
        /// Weibull modulus.
        modulus: f64,
        /// Coefficient of variation by flaws, percent.
        scatter: f64,
        /// The most that is left, percent.
        most: f64,
    },
    /// A test with scatter of its own.
    #[error(
        "the strength of rods and bonds has a scatter of its own, but specimens differ already by flaws; give one of both"
    )]
    TwoScatters,
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
            BendingError::Species(_)
            | BendingError::Moisture(_)
            | BendingError::Strength(_)
            | BendingError::Variation(_)
            | BendingError::Specimens { .. }
            | BendingError::Weibull(_)
            | BendingError::Flaws { .. }
            | BendingError::TwoScatters => ErrorKind::Request,
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
