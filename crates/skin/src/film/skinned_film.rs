//! Films of a run's skin.

use super::error::FilmError;
use super::motion::RunMotion;
use super::poses::{corners, posed_pieces};
use super::report::SkinReport;
use glam::DVec3;
use greenstick_geometry::{Film, Motion, Node, Pose, RigidBody, Scene};

/// A film with skin.
pub struct SkinnedFilm {
    /// Joints, pieces and bodies.
    pub film: Film,
    /// How the joints move.
    pub motion: RunMotion,
    /// The report.
    pub report: SkinReport,
    /// Index of the material of the wood inside.
    pub inner: u32,
}

impl SkinnedFilm {
    /// Returns the film's frame `number`, counted from its first, as a scene.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read.
    pub fn at(&mut self, number: usize) -> Result<Scene, FilmError> {
        let film = &self.film;
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        self.motion.poses(number, &mut poses)?;
        let mut nodes = posed_pieces(film, number, &poses);
        nodes.extend(film.fixed.iter().cloned());
        let mut maps = Vec::new();
        film.joint_maps(&poses, &mut maps);
        nodes.extend(film.bodies.iter().map(|RigidBody { node, joint }| Node {
            transform: maps[*joint as usize] * node.transform,
            ..node.clone()
        }));
        Ok(Scene {
            nodes,
            materials: film.materials.clone(),
            textures: film.textures.clone(),
            images: film.images.clone(),
            ..Scene::default()
        })
    }

    /// Returns the corners of the box about all joints and rigid pieces in all frames, m.
    ///
    /// # Errors
    /// [`FilmError`] where a frame cannot be read.
    pub fn bounds(&mut self) -> Result<Vec<DVec3>, FilmError> {
        let mut poses = vec![Pose::IDENTITY; self.film.joints.len()];
        let mut maps = Vec::new();
        let rigid: Vec<(usize, [DVec3; 8])> = (self.film.pieces.iter())
            .filter_map(|piece| match piece.binding.used_joints()[..] {
                [joint] => Some((joint as usize, corners(piece.mesh.bounds()?))),
                _ => None,
            })
            .collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for frame in 0..self.motion.frames() {
            self.motion.poses(frame, &mut poses)?;
            for pose in &poses {
                low = low.min(pose.translation);
                high = high.max(pose.translation);
            }
            self.film.joint_maps(&poses, &mut maps);
            for p in rigid.iter().flat_map(|(joint, corners)| {
                let map = maps[*joint];
                corners.map(move |p| map.transform_point3(p))
            }) {
                (low, high) = (low.min(p), high.max(p));
            }
        }
        Ok(corners((low, high)).to_vec())
    }
}
