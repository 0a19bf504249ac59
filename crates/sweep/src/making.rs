//! What makers of variants have in common: what stops them, and the size of small pictures.

use crate::error::SweepError;
use crate::input::InputError;
use greenstick::files::FileError;
use greenstick::geometry::Cancelled;

/// Width and height of a small picture, pixels.
pub const CELL: [u32; 2] = [240, 180];
/// Camera rays for each of its pixels.
pub const CELL_SAMPLES: u32 = 4;

/// Why a variant was not made.
pub enum Trouble {
    /// It cannot be: its row says why.
    Variant(String),
    /// The sweep must stop.
    Stop(SweepError),
}

impl From<Cancelled> for Trouble {
    fn from(cancelled: Cancelled) -> Self {
        Trouble::Stop(cancelled.into())
    }
}

impl From<greenstick::Error> for Trouble {
    fn from(error: greenstick::Error) -> Self {
        match error {
            greenstick::Error::Cancelled(cancelled) => cancelled.into(),
            other => Trouble::Variant(other.to_string()),
        }
    }
}

impl From<FileError> for Trouble {
    fn from(error: FileError) -> Self {
        match error {
            // No other variant could be written either.
            FileError::Unwritable { .. } => Trouble::Stop(error.into()),
            other => Trouble::Variant(other.to_string()),
        }
    }
}

impl From<InputError> for Trouble {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Cancelled(cancelled) => cancelled.into(),
            other => Trouble::Variant(other.to_string()),
        }
    }
}
