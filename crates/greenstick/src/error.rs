//! Everything that can go wrong between a file and its broken pieces.

use greenstick_fracture::cut::CutError;
use greenstick_geometry::Cancelled;
use greenstick_skin::BreakError;
use greenstick_wood::anatomy::AnatomyError;
use greenstick_wood::stem::StemError;

/// Why a break failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The stem at the place could not be found, or cannot be broken there.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// The mesh could not be cut.
    #[error("{error}; in the world that is at {at} (m)")]
    Cut {
        /// What went wrong.
        error: CutError,
        /// Where, m.
        at: glam::DVec3,
    },
    /// The recipe asks for something that is not known.
    #[error(transparent)]
    Recipe(#[from] greenstick_fracture::recipe::ShrinkageError),
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] greenstick_wood::species::UnknownSpecies),
    /// The textures of the wood inside could not be made.
    #[error(transparent)]
    Texture(#[from] greenstick_skin::texture::TextureError),
    /// Cracks could not be made.
    #[error(transparent)]
    Crack(#[from] greenstick_fracture::cracks::CrackError),
    /// A scan gives no bark.
    #[error(transparent)]
    Scan(#[from] crate::scanning::error::ScanningError),
    /// The inside of the stem could not be made.
    #[error(transparent)]
    Anatomy(AnatomyError),
    /// A parameter is wrong.
    #[error(transparent)]
    Parameter(#[from] greenstick_schema::ParameterError),
    /// A number asked for is out of range.
    #[error("{0}")]
    Amount(String),
    /// Something does not fit the format it was to be written in.
    #[error(transparent)]
    Format(#[from] greenstick_formats::FormatError),
    /// The report could not be put into JSON.
    #[error("the report cannot be put into JSON: {0}")]
    Report(String),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<BreakError> for Error {
    fn from(error: BreakError) -> Self {
        match error {
            BreakError::Stem(error) => Error::Stem(error),
            BreakError::Cut { error, at } => Error::Cut { error, at },
            BreakError::Crack(error) => Error::Crack(error),
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
