//! What can be wrong with compressed data.

use thiserror::Error;

/// Why compressed points cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub(in crate::cloud) enum Damage {
    /// The data ends too early.
    #[error("the end of the data")]
    Truncated,
    /// No compressor writes such data.
    #[error("data that contradict themselves")]
    Contradictory,
}
