//! A film's pieces where they are at one time, as a scene.

use super::{FilmError, SkinnedFilm};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Film, Motion, Node, Pose, Scene};

impl SkinnedFilm {
    /// The film's frame `number`, counted from its first, as a scene.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read.
    pub fn at(&mut self, number: usize) -> Result<Scene, FilmError> {
        let film = &self.film;
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        self.motion.poses(number, &mut poses)?;
        let mut nodes = posed(film, &poses);
        nodes.extend(film.fixed.iter().cloned());
        let mut maps = Vec::new();
        film.maps(&poses, &mut maps);
        nodes.extend(film.bodies.iter().map(|(node, joint)| Node {
            transform: maps[*joint as usize] * node.transform,
            ..node.clone()
        }));
        Ok(Scene {
            nodes,
            materials: film.materials.clone(),
            textures: film.textures.clone(),
            images: film.images.clone(),
            notes: Vec::new(),
        })
    }

    /// The corners of the box that holds all joints, and pieces that move as a whole, in all frames, m.
    ///
    /// # Errors
    /// [`FilmError`] where a frame cannot be read.
    pub fn bounds(&mut self) -> Result<Vec<DVec3>, FilmError> {
        let mut poses = vec![Pose::IDENTITY; self.film.joints.len()];
        let mut maps = Vec::new();
        let rigid: Vec<(usize, [DVec3; 8])> = (self.film.pieces.iter())
            .filter_map(|piece| match piece.binding.used()[..] {
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
            self.film.maps(&poses, &mut maps);
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

/// The corners of a box.
fn corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |axis: usize| [low, high][k >> axis & 1][axis];
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// The pieces of a film where its joints have these poses.
pub(super) fn posed(film: &Film, poses: &[Pose]) -> Vec<Node> {
    let (mut maps, mut normals) = (Vec::new(), Vec::new());
    film.maps(poses, &mut maps);
    let piece = |(number, piece): (usize, &greenstick_geometry::Skinned)| {
        let mut mesh = piece.mesh.clone();
        film.place_piece(number, &maps, &mut mesh.positions);
        film.place_normals(number, &maps, &mut normals);
        if let Some(attribute) = mesh.attributes.get_mut("TANGENT") {
            let at_rest: Vec<[f32; 3]> = (attribute.data.as_chunks::<4>().0.iter())
                .map(|&[x, y, z, _]| [x, y, z])
                .collect();
            let mut turned = Vec::new();
            film.turn_directions(number, &maps, &at_rest, &mut turned);
            for (to, t) in attribute.data.chunks_exact_mut(4).zip(turned) {
                to[..3].copy_from_slice(&t.as_vec3().to_array());
            }
        }
        if let Some(attribute) = mesh.attributes.get_mut("NORMAL") {
            attribute.data = normals
                .iter()
                .flat_map(|n| n.as_vec3().to_array())
                .collect();
        }
        Node {
            name: piece.name.clone(),
            transform: DAffine3::IDENTITY,
            mesh,
            parent: None,
        }
    };
    film.pieces.iter().enumerate().map(piece).collect()
}
