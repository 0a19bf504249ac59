//! Writers of films: a [`Film`] with its [`Motion`] as one glTF file with an animation, as USD with time samples, or as
//! vertex animation textures.
//!
//! Frames are requested one by one and written at once. The memory in use does not grow with their number, except for a
//! few bytes for each frame and piece that record where its samples are.

mod check;
mod error;
mod frames;
mod report;
mod vertex_texture;

pub use error::FilmError;
pub(crate) use frames::Frames;
pub use report::{FilmReport, GlbOptions, Reduction};
pub use vertex_texture::{MAX_TEXTURE_SIZE, TexturePiece, VertexTexture, write_vertex_texture};

#[cfg(feature = "usd")]
use crate::companions::Encoded;
use crate::gltf;
#[cfg(feature = "usd")]
use crate::usd::{self, UsdFormat};
use greenstick_geometry::{Context, Film, Motion};
use std::io::{Seek, Write};

/// Writes a `.glb` with one animation, from the current position of `out`.
///
/// Pieces become meshes with a skin of their own; pieces that follow a single joint, and bodies, become nodes that move.
/// `name` is the name of the file for messages.
///
/// # Errors
/// [`FilmError::Format`] if the film is invalid, has no triangles or no frames, has times that do not ascend from 0 or
/// later, or takes more than 4 GiB; the other variants if poses are not available, writing fails, or the caller asked to
/// stop.
pub fn write_glb<M: Motion, W: Write + Seek>(
    film: &Film,
    motion: &mut M,
    name: &str,
    options: &GlbOptions,
    out: &mut W,
    context: &Context,
) -> Result<FilmReport, FilmError> {
    let mut frames = Frames::new(film, motion, name)?;
    gltf::write_film(film, &mut frames, options, out, context)
}

/// Writes a `.usdc` or `.usdz` with points, normals and extents over time, from the current position of `out`. Returns
/// the texture files, unless the archive contains them. Positions are exact to single precision.
///
/// Pieces that follow a single joint, and bodies, are meshes that move rigidly. Further properties of pieces are written as
/// `userProperties:…`. `name` is the name of the file; the textures and the stage are named after it.
///
/// # Errors
/// As [`write_glb`], and [`FilmError::Format`] for [`UsdFormat::Usda`], which is for stills.
#[cfg(feature = "usd")]
pub fn write_usd<M: Motion, W: Write + Seek>(
    format: UsdFormat,
    film: &Film,
    motion: &mut M,
    name: &str,
    out: &mut W,
    context: &Context,
) -> Result<(FilmReport, Vec<Encoded>), FilmError> {
    let mut frames = Frames::new(film, motion, name)?;
    usd::write_film(format, film, &mut frames, out, context)
}
