//! A film: meshes that follow joints, and the poses of the joints over time. What moves is linear blend skinning,
//! `v = Σ w_j T_j T̄_j⁻¹ v̄`, with `T̄` the poses at rest, so that a writer need not know what made the motion.

use crate::{Image, Material, Mesh, Node, Texture};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::BTreeMap;

/// A rigid pose: a joint's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Origin, m.
    pub translation: DVec3,
    /// Turn, a unit quaternion.
    pub rotation: DQuat,
}

impl Pose {
    /// The frame of the world.
    pub const IDENTITY: Pose = Pose {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
    };

    /// The map from the frame to the world.
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.translation)
    }

    /// The map from the world to the frame.
    pub fn inverse(&self) -> DAffine3 {
        let back = self.rotation.conjugate();
        DAffine3::from_rotation_translation(back, back * -self.translation)
    }

    /// Whether all numbers are finite and the rotation has length 1 to 1e-6.
    pub fn is_sound(&self) -> bool {
        self.translation.is_finite()
            && self.rotation.is_finite()
            && (self.rotation.length_squared() - 1.0).abs() < 2e-6
    }
}

impl Default for Pose {
    fn default() -> Self {
        Pose::IDENTITY
    }
}

/// Which joints a vertex follows, for all vertices: vertex v has the entries `starts[v]..starts[v + 1]`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Binding {
    /// First entry of each vertex, and the number of entries at the end.
    pub starts: Vec<u32>,
    /// Joints, indices into [`Film::joints`].
    pub joints: Vec<u32>,
    /// Their weights; those of a vertex add up to 1.
    pub weights: Vec<f64>,
}

impl Binding {
    /// Every one of `vertices` vertices on one joint.
    pub fn rigid(vertices: usize, joint: u32) -> Self {
        Binding {
            starts: (0..=vertices as u32).collect(),
            joints: vec![joint; vertices],
            weights: vec![1.0; vertices],
        }
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Adds a vertex.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (u32, f64)>) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        for (joint, weight) in entries {
            self.joints.push(joint);
            self.weights.push(weight);
        }
        self.starts.push(self.joints.len() as u32);
    }

    /// Joints and weights of a vertex.
    pub fn of(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        range.map(|k| (self.joints[k], self.weights[k]))
    }

    /// The joints that are used with a weight other than 0, ascending.
    pub fn used(&self) -> Vec<u32> {
        let entries = self.joints.iter().zip(&self.weights);
        let mut used: Vec<u32> = entries
            .filter(|(_, w)| **w != 0.0)
            .map(|(&j, _)| j)
            .collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// What is wrong for a mesh of `vertices` vertices and a film of `joints` joints, if anything.
    fn fault(&self, vertices: usize, joints: usize) -> Option<String> {
        if self.vertices() != vertices {
            return Some(format!(
                "{} vertices are bound of {vertices}",
                self.vertices()
            ));
        }
        let entries = self.joints.len();
        let ends = (
            self.starts.first().copied(),
            self.starts.last().map(|&s| s as usize),
        );
        let ordered = self.starts.is_sorted() && ends.0.is_none_or(|s| s == 0);
        if !ordered || ends.1.unwrap_or(0) != entries || self.weights.len() != entries {
            return Some(format!(
                "{entries} joints and {} weights do not lie where the vertices' ranges say",
                self.weights.len()
            ));
        }
        if let Some(joint) = self.joints.iter().find(|&&j| j as usize >= joints) {
            return Some(format!(
                "a vertex follows joint {joint} of a film of {joints}"
            ));
        }
        (0..vertices).find_map(|v| {
            let sum: f64 = self.of(v).map(|(_, w)| w).sum();
            let least = self.of(v).map(|(_, w)| w).fold(0.0, f64::min);
            // NaN fails too.
            let right = (sum - 1.0).abs() <= 1e-6 && least >= 0.0;
            (!right)
                .then(|| format!("the weights of vertex {v} add up to {sum}, the least is {least}"))
        })
    }
}

/// What is said of a piece besides its shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Extra {
    /// Yes or no.
    Flag(bool),
    /// A count or a number of something.
    Integer(i64),
    /// A measure; the key names the unit.
    Number(f64),
    /// Several of them.
    Numbers(Vec<f64>),
    /// Words.
    Text(String),
}

/// A mesh that follows joints.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skinned {
    /// Name.
    pub name: String,
    /// The mesh at rest (with the joints in their rest poses), in the world, m.
    pub mesh: Mesh,
    /// What each vertex follows; from the last change on where that changes.
    pub binding: Binding,
    /// What vertices follow before.
    pub earlier: Earlier,
    /// What else is known of it.
    pub extras: BTreeMap<String, Extra>,
}

/// What some vertices of a piece follow before a frame, where a crack beside them opens then: formats with points over time
/// show it, those of a skin with fixed weights cannot. Changes are listed by vertex, those of one vertex by frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Earlier {
    /// The vertex of each change, ascending.
    pub vertices: Vec<u32>,
    /// The first frame in which it holds no longer, ascending for each vertex.
    pub until: Vec<u32>,
    /// Where the vertex rests before, m.
    pub rest: Vec<DVec3>,
    /// What it follows before: the change's own number in place of the vertex's.
    pub binding: Binding,
}

impl Earlier {
    /// Adds a change of a vertex, behind those of vertices and frames before it.
    pub fn push(
        &mut self,
        vertex: u32,
        until: u32,
        rest: DVec3,
        entries: impl IntoIterator<Item = (u32, f64)>,
    ) {
        self.vertices.push(vertex);
        self.until.push(until);
        self.rest.push(rest);
        self.binding.push(entries);
    }

    /// How many changes there are.
    pub fn count(&self) -> usize {
        self.vertices.len()
    }

    /// The changes that say what their vertices follow in a frame, with these vertices.
    pub fn at(&self, frame: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let mut last = u32::MAX;
        (0..self.count()).filter_map(move |change| {
            let vertex = self.vertices[change];
            let holds = vertex != last && frame < self.until[change] as usize;
            if holds {
                last = vertex;
            }
            holds.then_some((change, vertex as usize))
        })
    }

    /// What is wrong for a mesh of `vertices` vertices and a film of `joints` joints, if anything.
    fn fault(&self, vertices: usize, joints: usize) -> Option<String> {
        let count = self.count();
        if self.until.len() != count || self.rest.len() != count {
            return Some(format!(
                "{count} changes hold until {} frames at {} places",
                self.until.len(),
                self.rest.len()
            ));
        }
        let order = self.vertices.iter().zip(&self.until);
        if !order.is_sorted() {
            return Some("changes are not in the order of vertices and frames".into());
        }
        if let Some(v) = self.vertices.iter().find(|&&v| v as usize >= vertices) {
            return Some(format!("a change is of vertex {v} of {vertices}"));
        }
        let fault = self.binding.fault(count, joints)?;
        Some(format!("what vertices follow before: {fault}"))
    }
}

/// A frame that moves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Joint {
    /// Name, may be empty.
    pub name: String,
    /// Where it lies when the meshes lie at rest.
    pub rest: Pose,
}

/// Everything of a film that does not change over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Film {
    /// Frames that move.
    pub joints: Vec<Joint>,
    /// Meshes that follow them.
    pub pieces: Vec<Skinned>,
    /// Bodies that stand still.
    pub fixed: Vec<Node>,
    /// Rigid bodies that follow one joint each. The node's transform places the mesh in the world while the joint is at
    /// rest; its parent is not looked at.
    pub bodies: Vec<(Node, u32)>,
    /// Materials of all meshes; [`Mesh::materials`] indexes them.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Texture>,
    /// Images of the textures.
    pub images: Vec<Image>,
    /// Frames shown in a second, 1/s.
    pub frames_per_second: f64,
}

/// The poses over time, asked for frame by frame so that no writer holds them all. A writer may ask for a frame more than
/// once, and in any order; the same frame gives the same poses.
pub trait Motion {
    /// Why poses could not be had.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Number of frames.
    fn frames(&self) -> usize;

    /// When a frame is shown, s; ascending.
    fn time(&self, frame: usize) -> f64;

    /// Puts the poses of all joints at a frame into `poses`, one for each of [`Film::joints`].
    ///
    /// # Errors
    /// Where the poses cannot be had, such as from a file that was cut short.
    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Self::Error>;
}

impl Film {
    /// What breaks the rules of a film, if anything: a binding that does not fit its mesh, a joint that does not exist, a
    /// pose that is not rigid, a rate of frames that is not positive. Meshes themselves are for the writers to check.
    pub fn fault(&self) -> Option<String> {
        let rate = self.frames_per_second;
        if !(rate.is_finite() && rate > 0.0) {
            return Some(format!("{rate} frames per second"));
        }
        if let Some(j) = self.joints.iter().position(|j| !j.rest.is_sound()) {
            return Some(format!(
                "joint {j} ({}) rests at {:?}, which is no rigid pose",
                self.joints[j].name, self.joints[j].rest
            ));
        }
        for (p, piece) in self.pieces.iter().enumerate() {
            let vertices = piece.mesh.positions.len();
            if let Some(fault) = piece.binding.fault(vertices, self.joints.len()) {
                return Some(format!("piece {p} ({}): {fault}", piece.name));
            }
            if let Some(fault) = piece.earlier.fault(vertices, self.joints.len()) {
                return Some(format!("piece {p} ({}): {fault}", piece.name));
            }
        }
        let joints = self.joints.len();
        let lost = self.bodies.iter().find(|(_, j)| *j as usize >= joints);
        lost.map(|(node, j)| format!("body {} follows joint {j} of a film of {joints}", node.name))
    }

    /// For each joint the map that takes a point that follows it from rest to where it is, `T_j T̄_j⁻¹`.
    pub fn maps(&self, poses: &[Pose], out: &mut Vec<DAffine3>) {
        out.clear();
        let both = self.joints.iter().zip(poses);
        out.extend(both.map(|(joint, pose)| pose.affine() * joint.rest.inverse()));
    }

    /// The positions of a piece's vertices (m) where the joints have the maps of [`Self::maps`].
    pub fn place_piece(&self, piece: usize, maps: &[DAffine3], out: &mut Vec<DVec3>) {
        let piece = &self.pieces[piece];
        out.clear();
        out.extend(piece.mesh.positions.iter().enumerate().map(|(v, &p)| {
            // Blending what each joint says keeps more digits than blending matrices does.
            piece.binding.of(v).fold(DVec3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].transform_point3(p) * w
            })
        }));
    }

    /// As [`Self::place_piece`] in a frame, with what vertices follow then.
    pub fn place_piece_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        out: &mut Vec<DVec3>,
    ) {
        self.place_piece(piece, maps, out);
        let earlier = &self.pieces[piece].earlier;
        for (change, vertex) in earlier.at(frame) {
            let p = earlier.rest[change];
            out[vertex] = (earlier.binding.of(change)).fold(DVec3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].transform_point3(p) * w
            });
        }
    }

    /// The unit normals of a piece's vertices where the joints have the maps of [`Self::maps`]; empty for a mesh without
    /// the attribute `NORMAL`.
    pub fn place_normals(&self, piece: usize, maps: &[DAffine3], out: &mut Vec<DVec3>) {
        let attributes = &self.pieces[piece].mesh.attributes;
        let normals = attributes.get("NORMAL").filter(|a| a.width == 3);
        let normals = normals.map_or(&[][..], |a| a.data.as_chunks::<3>().0);
        self.turn_directions(piece, maps, normals, out);
    }

    /// Unit vectors at a piece's vertices, given as they are at rest, where the joints have the maps of [`Self::maps`]. The
    /// blended turn is applied, as viewers do.
    pub fn turn_directions(
        &self,
        piece: usize,
        maps: &[DAffine3],
        at_rest: &[[f32; 3]],
        out: &mut Vec<DVec3>,
    ) {
        let binding = &self.pieces[piece].binding;
        out.clear();
        out.extend(at_rest.iter().enumerate().map(|(v, &n)| {
            let n = DVec3::from_array(n.map(f64::from));
            let blended = binding.of(v).fold(DMat3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].matrix3 * w
            });
            (blended * n).normalize_or(n)
        }));
    }

    /// As [`Self::place_normals`] in a frame, with what vertices follow then.
    pub fn place_normals_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        out: &mut Vec<DVec3>,
    ) {
        let attributes = &self.pieces[piece].mesh.attributes;
        let normals = attributes.get("NORMAL").filter(|a| a.width == 3);
        let normals = normals.map_or(&[][..], |a| a.data.as_chunks::<3>().0);
        self.turn_directions_at(frame, piece, maps, normals, out);
    }

    /// As [`Self::turn_directions`] in a frame, with what vertices follow then.
    pub fn turn_directions_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        at_rest: &[[f32; 3]],
        out: &mut Vec<DVec3>,
    ) {
        self.turn_directions(piece, maps, at_rest, out);
        let earlier = &self.pieces[piece].earlier;
        for (change, vertex) in earlier.at(frame) {
            let Some(n) = at_rest.get(vertex) else {
                continue;
            };
            let n = DVec3::from_array(n.map(f64::from));
            let blended = (earlier.binding.of(change)).fold(DMat3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].matrix3 * w
            });
            out[vertex] = (blended * n).normalize_or(n);
        }
    }

    /// Linear blend skinning, exact: the positions (m) of all vertices of a piece. For many pieces at once,
    /// [`Self::maps`] and [`Self::place_piece`] do less.
    pub fn pose_piece(&self, piece: usize, poses: &[Pose], out: &mut Vec<DVec3>) {
        let mut maps = Vec::with_capacity(self.joints.len());
        self.maps(poses, &mut maps);
        self.place_piece(piece, &maps, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        let joint = |x: f64| Joint {
            name: String::new(),
            rest: Pose {
                translation: DVec3::new(x, 0.0, 0.0),
                rotation: DQuat::from_rotation_y(0.3 * x),
            },
        };
        let mut binding = Binding::default();
        binding.push([(0, 1.0)]);
        binding.push([(0, 0.25), (1, 0.75)]);
        Film {
            joints: vec![joint(0.0), joint(1.0)],
            pieces: vec![Skinned {
                mesh: Mesh {
                    positions: vec![DVec3::new(0.0, 1.0, 0.0), DVec3::new(2.0, 0.0, 0.0)],
                    ..Mesh::default()
                },
                binding,
                ..Skinned::default()
            }],
            frames_per_second: 30.0,
            ..Film::default()
        }
    }

    #[test]
    fn rest_stays_and_joints_share_by_weight() {
        let film = film();
        assert_eq!(film.fault(), None);
        let mut poses: Vec<Pose> = film.joints.iter().map(|j| j.rest).collect();
        let mut out = Vec::new();
        film.pose_piece(0, &poses, &mut out);
        let rest = &film.pieces[0].mesh.positions;
        assert!(out.iter().zip(rest).all(|(a, b)| a.distance(*b) < 1e-15));
        // Joint 1 turns a quarter about its own origin (1, 0, 0): (2, 0, 0) would go to (1, 1, 0), and takes 3/4 of it.
        poses[1].rotation = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * poses[1].rotation;
        film.pose_piece(0, &poses, &mut out);
        assert!(out[0].distance(rest[0]) < 1e-15);
        assert!(out[1].distance(DVec3::new(1.25, 0.75, 0.0)) < 1e-15);
    }

    #[test]
    fn a_vertex_follows_what_it_followed_in_the_frame() {
        let mut film = film();
        let earlier = &mut film.pieces[0].earlier;
        earlier.push(1, 2, DVec3::X, [(0, 1.0)]);
        earlier.push(1, 5, DVec3::Y, [(1, 1.0)]);
        assert_eq!(film.fault(), None);
        let mut poses: Vec<Pose> = film.joints.iter().map(|j| j.rest).collect();
        poses[0].translation.z += 4.0;
        let (mut maps, mut out) = (Vec::new(), Vec::new());
        film.maps(&poses, &mut maps);
        let far = DVec3::new(2.0, 0.0, 0.0);
        let wanted = [
            (1, DVec3::new(1.0, 0.0, 4.0)),
            (2, DVec3::Y),
            (4, DVec3::Y),
            (5, far + DVec3::Z),
        ];
        for (frame, place) in wanted {
            film.place_piece_at(frame, 0, &maps, &mut out);
            assert!(out[1].distance(place) < 1e-15, "{frame}: {}", out[1]);
            assert!(out[0].distance(DVec3::new(0.0, 1.0, 4.0)) < 1e-15);
        }
    }

    #[test]
    fn faults_are_found() {
        type Change = fn(&mut Film);
        let broken: [(&str, Change); 9] = [
            ("frames per second", |f| f.frames_per_second = f64::NAN),
            ("no rigid pose", |f| f.joints[1].rest.rotation.x = 3.0),
            ("bound of 1", |f| f.pieces[0].mesh.positions.truncate(1)),
            ("follows joint 7", |f| f.pieces[0].binding.joints[2] = 7),
            ("add up to", |f| f.pieces[0].binding.weights[1] = f64::NAN),
            ("ranges say", |f| f.pieces[0].binding.starts[1] = 9),
            ("of vertex 2 of 2", |f| {
                f.pieces[0].earlier.push(2, 1, DVec3::ZERO, [(0, 1.0)]);
            }),
            ("order", |f| {
                for until in [2, 1] {
                    (f.pieces[0].earlier).push(0, until, DVec3::ZERO, [(0, 1.0)]);
                }
            }),
            ("before: a vertex follows joint 9", |f| {
                f.pieces[0].earlier.push(0, 1, DVec3::ZERO, [(9, 1.0)]);
            }),
        ];
        for (says, change) in broken {
            let mut film = film();
            change(&mut film);
            let fault = film.fault().unwrap_or_default();
            assert!(fault.contains(says), "{says}: {fault}");
        }
    }
}
