//! Errors of fracture tests.

use crate::error::{RodBundleError, SolverError};
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_wood::species::{StrengthError, UnknownSpecies};

/// Why a fracture test has no outcome.
#[derive(Debug, thiserror::Error)]
pub enum FractureError {
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// Its strength is unknown.
    #[error(transparent)]
    Strength(#[from] StrengthError),
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
         allowed; use rods farther apart or longer edges"
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
    /// The crack grew too little or too suddenly to be evaluated.
    #[error(
        "the crack grew from {from} m to {to} m in {points} steps with its process zone clear of the end, but an energy of \
         fracture needs {needed} m and four steps; use a longer specimen, more growth or shorter edges"
    )]
    LittleGrowth {
        /// Length of the crack where it counts from, m.
        from: f64,
        /// Length at the end, m.
        to: f64,
        /// Points between them.
        points: usize,
        /// The growth that is needed, m.
        needed: f64,
    },
    /// A beam that is to break through does not.
    #[error(
        "the ligament still bears {load} N of {maximum} N at a deflection of {deflection} m, but an energy of fracture needs a \
         beam that is broken through; use a shorter span or a deeper notch"
    )]
    Whole {
        /// Load at the end, N.
        load: f64,
        /// Largest load, N.
        maximum: f64,
        /// Deflection at the end, m.
        deflection: f64,
    },
    /// The specimen cannot be built of rods.
    #[error(transparent)]
    Bundle(#[from] RodBundleError),
    /// There is no equilibrium.
    #[error(transparent)]
    Solver(SolverError),
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FractureError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FractureError::Cancelled(_) => ErrorKind::Cancelled,
            FractureError::Species(_)
            | FractureError::Strength(_)
            | FractureError::Value { .. }
            | FractureError::TooFine { .. } => ErrorKind::Request,
            FractureError::LittleGrowth { .. }
            | FractureError::Whole { .. }
            | FractureError::Bundle(_)
            | FractureError::Solver(_) => ErrorKind::Work,
        }
    }
}

impl From<SolverError> for FractureError {
    fn from(error: SolverError) -> Self {
        match error {
            SolverError::Cancelled(cancelled) => FractureError::Cancelled(cancelled),
            other => FractureError::Solver(other),
        }
    }
}
