//! Films of a run's skin.

use super::error::FilmError;
use super::motion::RunMotion;
use super::poses::posed_pieces;
use super::report::SkinReport;
use glam::DAffine3;
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

    /// Returns a frame in the coordinates of the mesh that was simulated, from which `film_from_stem` leads to those of the film, with
    /// the base of the stem where it was at rest. The first piece of the film is that at the base.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read.
    pub fn on_its_base(
        &mut self,
        number: usize,
        film_from_stem: &DAffine3,
    ) -> Result<Vec<Node>, FilmError> {
        let mut poses = vec![Pose::IDENTITY; self.film.joints.len()];
        self.motion.poses(number, &mut poses)?;
        let base = self.film.pieces.first();
        let base = base.and_then(|piece| piece.binding.used_joints().first().copied());
        let moved = base.map_or(DAffine3::IDENTITY, |joint| {
            let joint = joint as usize;
            poses[joint].affine() * self.film.joints[joint].rest.inverse()
        });
        let back = (moved * *film_from_stem).inverse();
        let mut nodes = self.at(number)?.nodes;
        for node in &mut nodes {
            let mesh = node.mesh.transformed(&(back * node.transform));
            (node.mesh, node.transform) = (mesh.into(), DAffine3::IDENTITY);
        }
        Ok(nodes)
    }
}
