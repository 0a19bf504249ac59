//! Moving files: a [`Film`] with its [`Motion`] as one glTF with an animation, or as USD with samples over time.
//!
//! Frames are asked for one by one and written at once: what is held in memory does not grow with their number, but for
//! some bytes for each frame and piece that say where its samples lie.

mod reel;
mod vertex_texture;

pub(crate) use reel::Reel;
pub use vertex_texture::{LARGEST_TEXTURE, TexturePiece, VertexTexture, write_vertex_texture};

use crate::error::{FormatError, InFile};
use crate::usd::{self, UsdFormat};
use crate::{Encoded, gltf};
use greenstick_geometry::{Cancelled, Context, Film, Motion};
use std::error::Error;
use std::io::{Seek, Write};

/// Why a film could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The film does not fit the format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The file could not be written to.
    #[error("{file}: cannot be written to: {source}")]
    Write {
        /// Name of the file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The poses of a frame could not be had.
    #[error("{file}: the poses of frame {frame} are not to be had: {source}")]
    Motion {
        /// Name of the file that was being written.
        file: String,
        /// Number of the frame, from 0.
        frame: usize,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A place to write to.
pub(crate) trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// How to write a glTF film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GlbOptions {
    /// Most joints of a skin; `None` for as many as there are. In skins with more those that move least in their own way
    /// go, and what followed them follows a blend of two others.
    pub max_joints: Option<usize>,
    /// Most joints that a vertex follows, 1 to 8. Many viewers know no more than 4.
    pub max_influences: usize,
}

impl Default for GlbOptions {
    fn default() -> Self {
        GlbOptions {
            max_joints: None,
            max_influences: 8,
        }
    }
}

/// A piece that was written with fewer joints or influences than it has.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Index of the piece in [`Film::pieces`].
    pub piece: usize,
    /// Its name.
    pub name: String,
    /// Joints it follows, and how many of them were written.
    pub joints: [usize; 2],
    /// Vertices that follow more joints than may be, after joints became fewer.
    pub capped: usize,
    /// Largest distance of a vertex from where it should be, over all frames, m.
    pub error: f64,
    /// The frame in which that is.
    pub frame: usize,
}

/// What was written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilmReport {
    /// Length of the file, bytes.
    pub bytes: u64,
    /// Frames.
    pub frames: usize,
    /// Pieces that follow several joints.
    pub skinned: usize,
    /// Pieces and bodies that move as a whole.
    pub rigid: usize,
    /// Joints of the skins, all in all.
    pub joints: usize,
    /// Values over time (translation or rotation of a node, points of a mesh).
    pub channels: usize,
    /// Those of them that never change.
    pub constant: usize,
    /// Pieces that are not as exact as the film. Only glTF needs any.
    pub reductions: Vec<Reduction>,
}

impl FilmReport {
    /// Largest distance of a vertex from where it should be, m.
    pub fn error(&self) -> f64 {
        self.reductions.iter().map(|r| r.error).fold(0.0, f64::max)
    }
}

/// Writes a `.glb` with one animation, from where `out` stands.
///
/// Pieces become meshes with a skin of their own; those that follow one joint alone, and bodies, become nodes that move.
/// `name` is the file's name for messages.
///
/// # Errors
/// [`FilmError::Format`] where the film breaks its own rules, holds no triangles or no frames, has times that do not
/// ascend from 0 or later, or is larger than 4 GiB; the others where poses or the file fail.
pub fn write_glb<M: Motion, W: Write + Seek>(
    film: &Film,
    motion: &mut M,
    name: &str,
    options: &GlbOptions,
    out: &mut W,
    context: &Context,
) -> Result<FilmReport, FilmError> {
    let mut reel = Reel::new(film, motion, name)?;
    gltf::write_film(film, &mut reel, options, out, context)
}

/// Writes a `.usdc` or `.usdz` with points, normals and extents over time, from where `out` stands; gives the files of the
/// textures too, where they are not in it. Exact but for the 32 bits of its numbers.
///
/// Pieces that follow one joint alone, and bodies, are meshes that move as a whole. What is said of pieces is in
/// properties named `userProperties:…`. `name` is the file's name, after which the textures and the stage are named.
///
/// # Errors
/// As [`write_glb`]; [`FilmError::Format`] for [`UsdFormat::Usda`], which is for stills.
pub fn write_usd<M: Motion, W: Write + Seek>(
    format: UsdFormat,
    film: &Film,
    motion: &mut M,
    name: &str,
    out: &mut W,
    context: &Context,
) -> Result<(FilmReport, Vec<Encoded>), FilmError> {
    let mut reel = Reel::new(film, motion, name)?;
    usd::write_film(format, film, &mut reel, out, context)
}

/// Refuses films that break their own rules, so that writers can index freely.
fn check(film: &Film, file: InFile) -> Result<(), FormatError> {
    use crate::assemble::{Surfaces, check_mesh, check_transform};
    if let Some(fault) = film.fault() {
        return Err(file.unwritable(fault, "a film that is sound"));
    }
    for (p, piece) in film.pieces.iter().enumerate() {
        check_mesh(&piece.mesh, &|| format!("piece {p} ({})", piece.name), file)?;
    }
    let bodies = film.bodies.iter().map(|body| &body.node);
    for (b, node) in bodies.chain(&film.fixed).enumerate() {
        let place = || format!("body {b} ({})", node.name);
        check_mesh(&node.mesh, &place, file)?;
        check_transform(node, &place, file)?;
    }
    let bodies = film.bodies.iter().map(|body| &body.node);
    let nodes = bodies.chain(&film.fixed).map(|n| &*n.mesh);
    let meshes = nodes.chain(film.pieces.iter().map(|p| &p.mesh));
    Surfaces::of_film(film).check(meshes.clone(), file)?;
    if meshes.into_iter().all(|m| m.triangles.is_empty()) {
        return Err(file.unwritable("the film has no triangles", "at least one triangle"));
    }
    Ok(())
}
