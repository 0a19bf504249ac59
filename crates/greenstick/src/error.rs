//! Errors of breaks, scans and the inside of stems.

use greenstick_fracture::cut::CutError;
use greenstick_geometry::{Cancelled, ErrorKind};
use greenstick_skin::BreakError;
use greenstick_wood::anatomy::AnatomyError;
use greenstick_wood::stem::StemError;

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no stem at the location, or it cannot be broken there.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// The mesh cannot be cut.
    #[error("{error}; in the world that is at {at:.5} (m)")]
    Cut {
        /// What went wrong.
        error: CutError,
        /// Where, m.
        at: glam::DVec3,
    },
    /// The shrinkage of the recipe's wood is not known.
    #[error(transparent)]
    Recipe(#[from] greenstick_fracture::recipe::ShrinkageError),
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] greenstick_wood::species::UnknownSpecies),
    /// The wood is not known at a moisture content.
    #[error(transparent)]
    Moisture(#[from] greenstick_wood::moisture::MoistureError),
    /// The textures of the wood inside cannot be made.
    #[error(transparent)]
    Texture(#[from] greenstick_skin::texture::TextureError),
    /// Cracks cannot be made.
    #[error(transparent)]
    Crack(#[from] greenstick_fracture::cracks::CrackError),
    /// No bark can be reconstructed from a scan.
    #[error(transparent)]
    Scan(#[from] greenstick_wood::scan::ScanningError),
    /// The inside of the stem cannot be made.
    #[error(transparent)]
    Anatomy(AnatomyError),
    /// A parameter is wrong.
    #[error(transparent)]
    Parameter(#[from] greenstick_schema::ParameterError),
    /// The number of something in the request is out of range.
    #[error("{0}")]
    Amount(String),
    /// A stem cannot be broken at these places.
    #[error(transparent)]
    Places(#[from] greenstick_skin::stages::PlacesError),
    /// A format cannot represent the result.
    #[error(transparent)]
    Format(#[from] greenstick_formats::FormatError),
    /// The report cannot be converted to JSON.
    #[error("the report cannot be converted to JSON: {0}")]
    Report(String),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl Error {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::Cancelled(_) => ErrorKind::Cancelled,
            Error::Stem(error) => error.kind(),
            Error::Texture(error) => error.kind(),
            Error::Scan(error) => error.kind(),
            Error::Anatomy(error) => error.kind(),
            Error::Recipe(_)
            | Error::Species(_)
            | Error::Moisture(_)
            | Error::Parameter(_)
            | Error::Places(_)
            | Error::Amount(_) => ErrorKind::Request,
            Error::Cut { .. } | Error::Crack(_) | Error::Format(_) | Error::Report(_) => {
                ErrorKind::Work
            }
        }
    }
}

impl From<BreakError> for Error {
    fn from(error: BreakError) -> Self {
        match error {
            BreakError::Stem(error) => Error::Stem(error),
            BreakError::Cut { error, at } => Error::Cut { error, at },
            BreakError::Crack(error) => Error::Crack(error),
            BreakError::TooFewTriangles { .. } => Error::Amount(error.to_string()),
            BreakError::Cancelled(cancelled) => Error::Cancelled(cancelled),
        }
    }
}

impl From<AnatomyError> for Error {
    fn from(error: AnatomyError) -> Self {
        match error {
            AnatomyError::Cancelled(cancelled) => Error::Cancelled(cancelled),
            other => Error::Anatomy(other),
        }
    }
}
