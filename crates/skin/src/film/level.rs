//! Levels of detail of a film: the same pieces and joints with fewer triangles.

use super::error::FilmError;
use super::skinned_film::SkinnedFilm;
use greenstick_geometry::{
    Binding, Cancelled, Context, EarlierBindings, Film, Motion, Pose, Simplified, SkinnedMesh,
    simplify,
};
use rayon::prelude::*;
use serde::Serialize;

/// Frames besides rest whose shapes are preserved too: the last one, and others evenly spread before it.
const PRESERVED_FRAMES: usize = 3;

/// How much simpler a level of detail is, and how far off.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct LevelReport {
    /// Requested share of the triangles.
    pub share: f64,
    /// Triangles of all pieces before and after.
    pub triangles: [usize; 2],
    /// Vertices of all pieces before and after.
    pub vertices: [usize; 2],
    /// Largest distance of a vertex of a piece from its simpler surface, at rest and in the preserved frames, m.
    pub error_m: f64,
}

/// Simplifies a film to `share` (0 to 1) of the triangles of each piece. The vertices left keep their bindings and
/// attributes; closed pieces stay closed. Bodies stay as they are.
///
/// # Errors
/// [`FilmError`] where a frame cannot be read or the caller cancelled.
pub fn level(
    skinned: &mut SkinnedFilm,
    share: f64,
    context: &Context,
) -> Result<(Film, LevelReport), FilmError> {
    let film = &skinned.film;
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut maps = Vec::new();
    let mut shapes: Vec<Vec<Vec<_>>> = vec![Vec::new(); film.pieces.len()];
    let count = skinned.motion.frames();
    let mut frames: Vec<usize> = (1..=PRESERVED_FRAMES)
        .map(|k| count * k / PRESERVED_FRAMES)
        .collect();
    frames.dedup();
    for frame in frames.into_iter().filter(|&f| f > 0) {
        skinned.motion.poses(frame - 1, &mut poses)?;
        film.joint_maps(&poses, &mut maps);
        for (piece, shapes) in shapes.iter_mut().enumerate() {
            let mut positions = Vec::new();
            film.deform_positions(piece, &maps, &mut positions);
            shapes.push(positions);
        }
    }
    let simpler = (film.pieces.par_iter().zip(&shapes)).map(|(piece, shapes)| {
        let target = (share * piece.mesh.triangles.len() as f64) as usize;
        simplify(&piece.mesh, shapes, target, &context.silenced())
    });
    let simpler: Vec<Simplified> = simpler.collect::<Result<_, Cancelled>>()?;
    let mut report = LevelReport {
        share,
        triangles: [0; 2],
        vertices: [0; 2],
        error_m: 0.0,
    };
    let mut out = film.clone();
    for (piece, simpler) in out.pieces.iter_mut().zip(simpler) {
        for (k, mesh) in [&piece.mesh, &simpler.mesh].into_iter().enumerate() {
            report.triangles[k] += mesh.triangles.len();
            report.vertices[k] += mesh.positions.len();
        }
        report.error_m = report.error_m.max(simpler.error);
        piece.binding = vertex_bindings(piece, &simpler.original_vertices);
        piece.mesh = simpler.mesh;
        // Levels are for engines, whose skins have fixed weights.
        piece.earlier = EarlierBindings::default();
    }
    Ok((out, report))
}

/// Returns the binding of some vertices of a piece.
fn vertex_bindings(piece: &SkinnedMesh, vertices: &[u32]) -> Binding {
    let mut binding = Binding::default();
    for &v in vertices {
        binding.push(piece.binding.influences(v as usize));
    }
    binding
}
