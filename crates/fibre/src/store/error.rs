//! Errors of stored runs.

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
