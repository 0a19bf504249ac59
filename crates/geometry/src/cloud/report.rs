//! What cleaning a cloud takes, and what it says of its outcome.

use crate::{Cancelled, ErrorKind};
use std::borrow::Cow;

/// The steps to take, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CleanOptions {
    /// Remove points with coordinates that are not finite; otherwise such points are an error.
    pub not_finite: bool,
    /// Remove points at the position of an earlier one.
    pub duplicates: bool,
    /// Remove points whose mean distance to their nearest neighbours exceeds the mean of the cloud by so many standard
    /// deviations (Rusu et al. 2008, Towards 3D Point Cloud Based Object Maps for Household Environments); `None` skips
    /// the step.
    pub outliers: Option<f64>,
    /// Remove points with fewer than two others within so many median spacings; `None` skips the step.
    pub isolated: Option<f64>,
    /// Keep one point in each cube of this side, m; `None` skips the step.
    pub spacing: Option<f64>,
}

impl CleanOptions {
    /// Standard deviations beyond which a point is an outlier by default.
    pub const OUTLIER_DEVIATIONS: f64 = 3.0;
    /// Median spacings within which a point has others by default.
    pub const ISOLATED_SPACINGS: f64 = 8.0;
}

impl Default for CleanOptions {
    fn default() -> Self {
        CleanOptions {
            not_finite: true,
            duplicates: true,
            outliers: Some(Self::OUTLIER_DEVIATIONS),
            isolated: Some(Self::ISOLATED_SPACINGS),
            spacing: None,
        }
    }
}

/// One step of the cleaning.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CleanStep {
    /// What kind of points it removes.
    pub name: Cow<'static, str>,
    /// Number of points removed.
    pub removed: usize,
    /// Number of points left.
    pub left: usize,
    /// Why they were removed, with the figures that decided.
    pub why: String,
}

/// The outcome of the cleaning.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct CleanReport {
    /// Number of points before.
    pub read: usize,
    /// The steps that were taken.
    pub steps: Vec<CleanStep>,
    /// Median distance from a point to the nearest other among those left, m.
    pub spacing_m: f64,
}

/// Why a cloud cannot be cleaned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CleanError {
    /// A point is not finite, and such points are not to be removed.
    #[error(
        "point {point} has the coordinate {value}; expected finite numbers, or let such points be dropped"
    )]
    NotFinite {
        /// Number of the point, from 0.
        point: usize,
        /// The coordinate.
        value: f64,
    },
    /// Too few points are left.
    #[error("{left} of {read} points are left after cleaning; expected at least {least}")]
    TooFew {
        /// Number of points before.
        read: usize,
        /// Number of points left.
        left: usize,
        /// Number of points needed.
        least: usize,
    },
    /// An option is out of its range.
    #[error("{option} is {value}; expected a finite number above 0")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// There are more points than 32 bits can number.
    #[error("{0} points; expected fewer than 4294967295")]
    TooMany(usize),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl CleanError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            CleanError::Cancelled(_) => ErrorKind::Cancelled,
            _ => ErrorKind::Request,
        }
    }
}
