//! Why there are no textures.

use greenstick_geometry::{Cancelled, ErrorKind};

/// Why there are no textures.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TextureError {
    /// The size is out of range.
    #[error(
        "a texture {size} pixels wide cannot be baked; the width must be even and {MIN_WIDTH} to {MAX_WIDTH}"
    )]
    Size {
        /// Width requested, pixels.
        size: u32,
    },
    /// The side of the squares is no length.
    #[error("the side of the texture's squares is {width} m; it must be a finite length above 0")]
    Width {
        /// Side requested, m, as text.
        width: String,
    },
    /// The PNG encoder failed.
    #[error("encoding the texture as PNG failed: {0}")]
    Encoding(String),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl TextureError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            TextureError::Cancelled(_) => ErrorKind::Cancelled,
            TextureError::Size { .. } => ErrorKind::Request,
            _ => ErrorKind::Work,
        }
    }
}

/// Least width of a texture, pixels.
pub(crate) const MIN_WIDTH: u32 = 8;
/// Greatest width of a texture, pixels.
const MAX_WIDTH: u32 = 16_384;

/// Checks the width of a texture in pixels and of what it shows in metres; returns the latter.
pub(super) fn check_size(size: u32, width: f64) -> Result<f64, TextureError> {
    if !(MIN_WIDTH..=MAX_WIDTH).contains(&size) || !size.is_multiple_of(2) {
        return Err(TextureError::Size { size });
    }
    if !(width.is_finite() && width > 0.0) {
        return Err(TextureError::Width {
            width: width.to_string(),
        });
    }
    Ok(width)
}
