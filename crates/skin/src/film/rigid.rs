//! Pieces whose joints move as one follow one of them: what flew off or came to rest is then no skin but a plain node.

use super::error::FilmError;
use super::poses::corners;
use super::skinned_film::SkinnedFilm;
use glam::DVec3;
use greenstick_geometry::{Binding, Context, Motion, Pose};

/// How far a vertex may be from where its skin has it, over the distance between rods.
pub(super) const TOLERANCE: f64 = 0.01;

/// A piece that has moved as a whole so far.
struct Whole {
    piece: usize,
    joints: Vec<u32>,
    /// Corners of the box about it at rest.
    corners: [DVec3; 8],
}

impl SkinnedFilm {
    /// Gives each piece that no frame bends by more than `tolerance` (m) one joint to follow, and says how many.
    pub(super) fn stiffen(
        &mut self,
        tolerance: f64,
        context: &Context,
    ) -> Result<usize, FilmError> {
        let film = &self.film;
        let whole = film.pieces.iter().enumerate().filter_map(|(piece, p)| {
            let joints = p.binding.used_joints();
            let corners = corners(p.mesh.bounds()?);
            (joints.len() > 1).then_some(Whole {
                piece,
                joints,
                corners,
            })
        });
        let mut whole: Vec<Whole> = whole.collect();
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        let mut maps = Vec::new();
        let frames = self.motion.frames();
        for frame in 0..frames {
            if whole.is_empty() {
                break;
            }
            context.report(frame as f64 / frames as f64)?;
            self.motion.poses(frame, &mut poses)?;
            film.joint_maps(&poses, &mut maps);
            whole.retain(|w| {
                let places =
                    |joint: u32| w.corners.map(|p| maps[joint as usize].transform_point3(p));
                let first = places(w.joints[0]);
                // Nothing within a box is farther off than a corner of it, and no mean of places farther than one.
                w.joints[1..].iter().all(|&joint| {
                    let both = places(joint).into_iter().zip(first);
                    both.into_iter().all(|(p, q)| p.distance(q) <= tolerance)
                })
            });
        }
        for w in &whole {
            let piece = &mut self.film.pieces[w.piece];
            piece.binding = Binding::rigid(piece.mesh.positions.len(), w.joints[0]);
        }
        Ok(whole.len())
    }
}
