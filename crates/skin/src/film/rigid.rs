//! Rigid pieces: those whose joints move as one are bound to one of them. What flew off or came to rest is then a plain
//! node and not a skin.

use super::error::FilmError;
use super::poses::corners;
use super::skinned_film::SkinnedFilm;
use glam::DVec3;
use greenstick_geometry::{Binding, Context, Motion, Pose};

/// Largest deviation of a rigid piece's vertex from its skin, over the distance between rods.
pub(super) const RIGID_TOLERANCE: f64 = 0.01;

/// A piece that has moved rigidly so far.
struct RigidCandidate {
    piece: usize,
    joints: Vec<u32>,
    /// Corners of the box about it at rest.
    corners: [DVec3; 8],
}

impl SkinnedFilm {
    /// Binds each piece that no frame bends by more than `tolerance` (m) to one joint. Returns their number.
    pub(super) fn bind_rigid_pieces(
        &mut self,
        tolerance: f64,
        context: &Context,
    ) -> Result<usize, FilmError> {
        let film = &self.film;
        let candidates = film.pieces.iter().enumerate().filter_map(|(piece, p)| {
            let joints = p.binding.used_joints();
            let corners = corners(p.mesh.bounds()?);
            (joints.len() > 1).then_some(RigidCandidate {
                piece,
                joints,
                corners,
            })
        });
        let mut candidates: Vec<RigidCandidate> = candidates.collect();
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        let mut maps = Vec::new();
        let frames = self.motion.frames();
        for frame in 0..frames {
            if candidates.is_empty() {
                break;
            }
            context.report(frame as f64 / frames as f64)?;
            self.motion.poses(frame, &mut poses)?;
            film.joint_maps(&poses, &mut maps);
            candidates.retain(|w| {
                let corners_at =
                    |joint: u32| w.corners.map(|p| maps[joint as usize].transform_point3(p));
                let first = corners_at(w.joints[0]);
                // No point of a box deviates more than one of its corners, and no mean of points more than one of them.
                w.joints[1..].iter().all(|&joint| {
                    let both = corners_at(joint).into_iter().zip(first);
                    both.into_iter().all(|(p, q)| p.distance(q) <= tolerance)
                })
            });
        }
        for w in &candidates {
            let piece = &mut self.film.pieces[w.piece];
            piece.binding = Binding::rigid(piece.mesh.positions.len(), w.joints[0]);
        }
        Ok(candidates.len())
    }
}
