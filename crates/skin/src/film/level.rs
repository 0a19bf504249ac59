//! Levels of detail of a film: the same pieces and joints with fewer triangles.

use super::error::FilmError;
use super::skinned_film::SkinnedFilm;
use greenstick_geometry::{
    Binding, Cancelled, Context, EarlierBindings, Film, Motion, Pose, Simplified, SkinnedMesh,
    simplify,
};
use rayon::prelude::*;
use serde::Serialize;

/// Frames besides rest at which the shape is looked after: the last and as many before it, evenly spread.
const LOOKS: usize = 3;

/// What was made.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct LevelReport {
    /// Share of the triangles that was asked for.
    pub share: f64,
    /// Triangles of all pieces before and after.
    pub triangles: [usize; 2],
    /// Vertices of all pieces before and after.
    pub vertices: [usize; 2],
    /// Largest distance of a vertex of a piece from its simpler surface, at rest and in the frames that were looked at, m.
    pub error_m: f64,
}

/// The film with `share` (0 to 1) of the triangles of each piece. Vertices are some of the film's, with what they follow
/// and show; closed pieces stay closed. Bodies stay as they are.
///
/// # Errors
/// [`FilmError`] where a frame cannot be had.
pub fn level(
    made: &mut SkinnedFilm,
    share: f64,
    context: &Context,
) -> Result<(Film, LevelReport), FilmError> {
    let film = &made.film;
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut maps = Vec::new();
    let mut looks: Vec<Vec<Vec<_>>> = vec![Vec::new(); film.pieces.len()];
    let count = made.motion.frames();
    let mut frames: Vec<usize> = (1..=LOOKS).map(|k| count * k / LOOKS).collect();
    frames.dedup();
    for frame in frames.into_iter().filter(|&f| f > 0) {
        made.motion.poses(frame - 1, &mut poses)?;
        film.joint_maps(&poses, &mut maps);
        for (piece, looks) in looks.iter_mut().enumerate() {
            let mut placed = Vec::new();
            film.deform_positions(piece, &maps, &mut placed);
            looks.push(placed);
        }
    }
    let simpler = (film.pieces.par_iter().zip(&looks)).map(|(piece, looks)| {
        let target = (share * piece.mesh.triangles.len() as f64) as usize;
        simplify(&piece.mesh, looks, target, &context.silenced())
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
        piece.binding = some(piece, &simpler.original_vertices);
        piece.mesh = simpler.mesh;
        // Levels are for engines, whose skins have fixed weights.
        piece.earlier = EarlierBindings::default();
    }
    Ok((out, report))
}

/// The binding of some vertices.
fn some(piece: &SkinnedMesh, kept: &[u32]) -> Binding {
    let mut binding = Binding::default();
    for &v in kept {
        binding.push(piece.binding.influences(v as usize));
    }
    binding
}
