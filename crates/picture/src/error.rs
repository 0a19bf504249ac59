//! Why a picture cannot be rendered, and the limits.

use greenstick_geometry::{Cancelled, ErrorKind};

/// Largest width and height of a picture, pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Most samples per pixel.
pub const MAX_SAMPLES: u32 = 65_536;
/// Most triangles of all items.
pub const MAX_TRIANGLES: usize = 1 << 30;

/// Why a picture cannot be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// There are no triangles.
    #[error("none of the {items} items has a triangle; expected at least one triangle")]
    Empty {
        /// Number of items given.
        items: usize,
    },
    /// A side of the picture is zero or too long.
    #[error(
        "a picture of {width} × {height} pixels; expected 1 to {MAX_SIDE} pixels for each side"
    )]
    Size {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
    },
    /// The number of samples is zero or too large.
    #[error("{samples} samples per pixel; expected 1 to {MAX_SAMPLES}")]
    Samples {
        /// Samples per pixel.
        samples: u32,
    },
    /// A coordinate is not finite, or too large.
    #[error(
        "item {item}, vertex {vertex} lies at {position} in the world; expected finite coordinates"
    )]
    Position {
        /// Number of the item, from 0.
        item: usize,
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Its position.
        position: glam::DVec3,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error(
        "item {item}, triangle {triangle} refers to vertex {vertex}; expected an index below {vertices}"
    )]
    Vertex {
        /// Number of the item, from 0.
        item: usize,
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// There are too many triangles.
    #[error("{triangles} triangles; expected at most {MAX_TRIANGLES}")]
    Triangles {
        /// Number of triangles in all items.
        triangles: usize,
    },
    /// The view is invalid.
    #[error("invalid view: {0}")]
    View(&'static str),
    /// An image of a texture cannot be read.
    #[error("image {image} \"{name}\" of a texture: {problem}; expected PNG, JPEG or WebP")]
    Image {
        /// Number of the image, from 0.
        image: usize,
        /// Its name, may be empty.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PictureError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            PictureError::Cancelled(_) => ErrorKind::Cancelled,
            PictureError::Size { .. } | PictureError::Samples { .. } | PictureError::View(_) => {
                ErrorKind::Request
            }
            _ => ErrorKind::Work,
        }
    }
}
