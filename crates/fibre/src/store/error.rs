//! Errors of stored runs.

use crate::scene::SceneError;
use greenstick_geometry::ErrorKind;
use std::io;

/// Why stored bytes cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Bytes of something else.
    #[error("these are no {expected}: they begin with {found:?}")]
    Foreign {
        /// What was expected.
        expected: &'static str,
        /// The first bytes found.
        found: String,
    },
    /// Written by another version of the program whose format cannot be read.
    #[error(
        "the {what} is of version {found}, and this program reads version {known}; use the program that wrote it"
    )]
    Newer {
        /// Which file.
        what: &'static str,
        /// Its version.
        found: u32,
        /// The version that can be read.
        known: u32,
    },
    /// Changed or truncated since it was written.
    #[error("the {what} is damaged: {problem}")]
    Damaged {
        /// Which file.
        what: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Why a run cannot be recorded, or a recorded one not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// There is no run.
    #[error("{location}: holds no simulation: {problem}")]
    NoRun {
        /// Where it should be.
        location: String,
        /// What was found.
        problem: String,
    },
    /// A record cannot be read.
    #[error("{location}: cannot be read: {source}")]
    Unreadable {
        /// The record.
        location: String,
        /// Why.
        source: io::Error,
    },
    /// A record cannot be written: the disk is full, or the like.
    #[error(
        "{location}: cannot be written: {source}; the run can be resumed from its last checkpoint"
    )]
    Unwritable {
        /// The record.
        location: String,
        /// Why.
        source: io::Error,
    },
    /// Another program records the run.
    #[error(
        "{location}: another program writes into it; wait until that ends, or choose another folder"
    )]
    Busy {
        /// The run.
        location: String,
    },
    /// A record is of another kind, or damaged.
    #[error("{location}: {error}")]
    Store {
        /// The record.
        location: String,
        /// What is wrong.
        error: StoreError,
    },
    /// The scene of the run cannot be used.
    #[error("{location}: {error}")]
    Scene {
        /// The record.
        location: String,
        /// What is wrong.
        error: SceneError,
    },
    /// A record is shorter than it was at the checkpoint.
    #[error(
        "{location}: has {found} {unit}, but the checkpoint was written when it had {expected}; it was changed since"
    )]
    Short {
        /// The record.
        location: String,
        /// The unit of its length.
        unit: &'static str,
        /// Its length.
        found: u64,
        /// The length that it must have at least.
        expected: u64,
    },
    /// A frame beyond the last.
    #[error("there is no frame {number}: the run has {count}, counted from 0")]
    NoSuchFrame {
        /// The frame asked for.
        number: usize,
        /// Number of frames.
        count: usize,
    },
    /// Another error of a sink or a source.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
}

impl RunError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            RunError::Unwritable { .. } => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}
