//! Pictures of triangle meshes, ray-traced on the CPU: soft light, shadows and one bounce of indirect light, without
//! a driver or a window. What a surface looks like is asked of a [`Shader`], so this crate knows no material but
//! the plain ones of [`PlainShader`].
//!
//! The same scene gives the same bits on every machine and with any number of threads.
#![deny(missing_docs)]

mod bvh;
mod camera;
mod chart;
mod light;
mod parameters;
mod picture;
mod render;
mod sampling;
mod scene;
mod shader;
mod smooth;

pub use camera::{View, horizontal};
pub use chart::{Chart, Line};
pub use parameters::{PictureParameters, PictureSize, ViewDirection};
pub use picture::Picture;
pub use render::{PictureOptions, render};
pub use shader::{Appearance, Hit, PlainShader, Shader};

use greenstick_geometry::{Cancelled, Mesh};

/// A mesh placed in the picture, and what it looks like.
pub struct Item<'a> {
    /// The mesh in its own coordinates.
    pub mesh: &'a Mesh,
    /// Its coordinates to world coordinates, m.
    pub transform: glam::DAffine3,
    /// Says what the surface looks like where a ray meets it.
    pub shader: &'a (dyn Shader + Sync),
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// There is no triangle to show.
    #[error("nothing to show: none of the {items} items has a triangle")]
    Empty {
        /// Number of items given.
        items: usize,
    },
    /// A side of the picture is zero or too long.
    #[error(
        "a picture of {width} × {height} pixels cannot be made; each side must be 1 to {MAXIMUM_SIDE}"
    )]
    Size {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
    },
    /// The number of samples is zero or too large.
    #[error("{samples} samples per pixel asked for; must be 1 to {MAXIMUM_SAMPLES}")]
    Samples {
        /// Samples per pixel asked for.
        samples: u32,
    },
    /// A coordinate is not a number, or infinite.
    #[error(
        "item {item}, vertex {vertex} is at {position} in the world; coordinates must be finite numbers"
    )]
    Position {
        /// Number of the item, from 0.
        item: usize,
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Where it is.
        position: glam::DVec3,
    },
    /// A triangle names a vertex that does not exist.
    #[error(
        "item {item}, triangle {triangle} names vertex {vertex}, but there are only {vertices}"
    )]
    Vertex {
        /// Number of the item, from 0.
        item: usize,
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The vertex named.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// More triangles than can be numbered.
    #[error("{triangles} triangles are too many; at most {MAXIMUM_TRIANGLES} fit into a picture")]
    Triangles {
        /// Number of triangles in all items.
        triangles: usize,
    },
    /// A view that cannot be taken.
    #[error("the view cannot be taken: {0}")]
    View(&'static str),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Longest side of a picture, pixels.
pub const MAXIMUM_SIDE: u32 = 16_384;
/// Most samples per pixel.
pub const MAXIMUM_SAMPLES: u32 = 65_536;
/// Most triangles in a picture.
pub const MAXIMUM_TRIANGLES: usize = 1 << 30;
