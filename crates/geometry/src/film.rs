//! Films: meshes that follow joints, and the poses of the joints over time. Vertices move by linear blend skinning,
//! `v = Σ w_j T_j T̄_j⁻¹ v̄`, with the rest poses `T̄`, so that a writer need not know where the motion comes from.

use crate::{Image, Material, Mesh, Metadata, Node, Texture};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::BTreeMap;

/// A rigid pose: the frame of a joint in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Origin, m.
    pub translation: DVec3,
    /// Rotation, a unit quaternion.
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

    /// Whether all numbers are finite and the rotation has length 1 to within 1e-6.
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

/// The joints that vertices follow, with weights: vertex `v` has the entries `starts[v]..starts[v + 1]`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Binding {
    /// First entry of each vertex, followed by the number of entries.
    pub starts: Vec<u32>,
    /// Joints, indices into [`Film::joints`].
    pub joints: Vec<u32>,
    /// Weights of the joints; those of a vertex add up to 1.
    pub weights: Vec<f64>,
}

impl Binding {
    /// Binds each of `vertices` vertices to one joint.
    pub fn rigid(vertices: usize, joint: u32) -> Self {
        Binding {
            starts: (0..=vertices as u32).collect(),
            joints: vec![joint; vertices],
            weights: vec![1.0; vertices],
        }
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Appends a vertex.
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
    pub fn influences(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        range.map(|k| (self.joints[k], self.weights[k]))
    }

    /// The joints that occur with a weight other than 0, ascending.
    pub fn used_joints(&self) -> Vec<u32> {
        let entries = self.joints.iter().zip(&self.weights);
        let mut used: Vec<u32> = entries
            .filter(|(_, w)| **w != 0.0)
            .map(|(&j, _)| j)
            .collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// Describes the first fault for a mesh of `vertices` vertices in a film of `joints` joints.
    fn fault(&self, vertices: usize, joints: usize) -> Option<String> {
        if self.vertices() != vertices {
            return Some(format!(
                "{} of {vertices} vertices are bound",
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
                "the ranges of the vertices do not match {entries} joints and {} weights",
                self.weights.len()
            ));
        }
        if let Some(joint) = self.joints.iter().find(|&&j| j as usize >= joints) {
            return Some(format!(
                "a vertex follows joint {joint}, but the film has {joints}"
            ));
        }
        (0..vertices).find_map(|v| {
            let sum: f64 = self.influences(v).map(|(_, w)| w).sum();
            let least = self.influences(v).map(|(_, w)| w).fold(0.0, f64::min);
            // False for NaN, too.
            let valid = (sum - 1.0).abs() <= 1e-6 && least >= 0.0;
            (!valid)
                .then(|| format!("the weights of vertex {v} add up to {sum} and the least is {least}; expected 1, and none below 0"))
        })
    }
}

/// A property of a piece besides its shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Extra {
    /// Yes or no.
    Flag(bool),
    /// A count or a number of something.
    Integer(i64),
    /// A quantity; the key names the unit.
    Number(f64),
    /// Several quantities.
    Numbers(Vec<f64>),
    /// Text.
    Text(String),
}

/// A mesh that follows joints.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SkinnedMesh {
    /// Name, may be empty.
    pub name: String,
    /// The mesh with the joints in their rest poses, in world coordinates, m.
    pub mesh: Mesh,
    /// What each vertex follows; for vertices with changes, what they follow after the last.
    pub binding: Binding,
    /// What vertices follow before changes.
    pub earlier: EarlierBindings,
    /// Whether it only adds to the looks of another piece and encloses none of its wood ([`Node::is_detail`]).
    pub is_detail: bool,
    /// Further properties by name.
    pub extras: BTreeMap<String, Extra>,
}

/// What some vertices of a piece follow before a frame in which that changes, because a crack opens beside them. Formats
/// that store positions over time show it, those with fixed skin weights cannot. Changes are sorted by vertex, those of one
/// vertex by frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EarlierBindings {
    /// The vertex of each change, ascending.
    pub vertices: Vec<u32>,
    /// The frame of each change, ascending for each vertex: the binding holds before it.
    pub until: Vec<u32>,
    /// Rest position of the vertex before the change, m.
    pub rest: Vec<DVec3>,
    /// What the vertex follows before the change, by the number of the change.
    pub binding: Binding,
}

impl EarlierBindings {
    /// Appends a change of a vertex. Changes must be added in order.
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

    /// Number of changes.
    pub fn count(&self) -> usize {
        self.vertices.len()
    }

    /// The changes that determine what vertices follow in a frame, with these vertices.
    pub fn active_at(&self, frame: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
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

    /// Describes the first fault for a mesh of `vertices` vertices in a film of `joints` joints.
    fn fault(&self, vertices: usize, joints: usize) -> Option<String> {
        let count = self.count();
        if self.until.len() != count || self.rest.len() != count {
            return Some(format!(
                "{count} changes have {} frames and {} rest positions",
                self.until.len(),
                self.rest.len()
            ));
        }
        let order = self.vertices.iter().zip(&self.until);
        if !order.is_sorted() {
            return Some("changes are not sorted by vertex and frame".into());
        }
        if let Some(v) = self.vertices.iter().find(|&&v| v as usize >= vertices) {
            return Some(format!(
                "a change is of vertex {v}, but there are {vertices}"
            ));
        }
        let fault = self.binding.fault(count, joints)?;
        Some(format!("before a change, {fault}"))
    }
}

/// A moving frame that vertices follow.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Joint {
    /// Name, may be empty.
    pub name: String,
    /// Its pose when the meshes are at rest.
    pub rest: Pose,
}

/// A rigid body that follows a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidBody {
    /// The body. Its transform is that to the world while the joint is at rest; its parent is ignored.
    pub node: Node,
    /// Index into [`Film::joints`].
    pub joint: u32,
}

/// Everything in a film that does not change over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Film {
    /// The moving frames.
    pub joints: Vec<Joint>,
    /// Meshes that follow them.
    pub pieces: Vec<SkinnedMesh>,
    /// Bodies that do not move.
    pub fixed: Vec<Node>,
    /// Rigid bodies that follow one joint each.
    pub bodies: Vec<RigidBody>,
    /// Materials of all meshes; [`Mesh::materials`] indexes them.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Texture>,
    /// Images of the textures.
    pub images: Vec<Image>,
    /// Frame rate, 1/s.
    pub frames_per_second: f64,
    /// Where it comes from and how it was made.
    pub metadata: Metadata,
}

/// The poses over time, requested frame by frame so that no writer holds them all. A writer may request frames repeatedly
/// and in any order; a frame always has the same poses.
pub trait Motion {
    /// Why poses are not available.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Number of frames.
    fn frames(&self) -> usize;

    /// Time of a frame, s; ascending.
    fn time(&self, frame: usize) -> f64;

    /// Writes the poses of all joints in a frame to `poses`, one for each of [`Film::joints`].
    ///
    /// # Errors
    /// If the poses are not available, for example because a file is truncated.
    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Self::Error>;
}

impl Film {
    /// Describes the first fault of a film: a binding that does not match its mesh, a joint that does not exist, a pose that
    /// is not rigid, or a frame rate that is not positive. The meshes themselves are checked by the writers.
    pub fn fault(&self) -> Option<String> {
        let rate = self.frames_per_second;
        if !(rate.is_finite() && rate > 0.0) {
            return Some(format!(
                "the frame rate is {rate} per second; expected a finite number above 0"
            ));
        }
        if let Some(j) = self.joints.iter().position(|j| !j.rest.is_sound()) {
            return Some(format!(
                "joint {j} ({}) rests at {:?}, which is not a rigid pose",
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
        let lost = self.bodies.iter().find(|b| b.joint as usize >= joints);
        lost.map(|RigidBody { node, joint }| {
            format!(
                "body {} follows joint {joint}, but the film has {joints}",
                node.name
            )
        })
    }

    /// Computes for each joint the map `T_j T̄_j⁻¹` that takes points that follow it from rest to their positions.
    pub fn joint_maps(&self, poses: &[Pose], out: &mut Vec<DAffine3>) {
        out.clear();
        let both = self.joints.iter().zip(poses);
        out.extend(both.map(|(joint, pose)| pose.affine() * joint.rest.inverse()));
    }

    /// Computes the positions of a piece's vertices, m, for the maps of [`Self::joint_maps`].
    pub fn deform_positions(&self, piece: usize, maps: &[DAffine3], out: &mut Vec<DVec3>) {
        let piece = &self.pieces[piece];
        out.clear();
        out.extend(piece.mesh.positions.iter().enumerate().map(|(v, &p)| {
            // Blending positions keeps more digits than blending matrices.
            piece
                .binding
                .influences(v)
                .fold(DVec3::ZERO, |sum, (j, w)| {
                    sum + maps[j as usize].transform_point3(p) * w
                })
        }));
    }

    /// Computes what [`Self::deform_positions`] does, with the bindings that hold in a frame.
    pub fn deform_positions_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        out: &mut Vec<DVec3>,
    ) {
        self.deform_positions(piece, maps, out);
        let earlier = &self.pieces[piece].earlier;
        for (change, vertex) in earlier.active_at(frame) {
            let p = earlier.rest[change];
            out[vertex] = (earlier.binding.influences(change)).fold(DVec3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].transform_point3(p) * w
            });
        }
    }

    /// Computes the unit normals of a piece's vertices for the maps of [`Self::joint_maps`]; none for a mesh without the
    /// attribute `NORMAL`.
    pub fn deform_normals(&self, piece: usize, maps: &[DAffine3], out: &mut Vec<DVec3>) {
        let attributes = &self.pieces[piece].mesh.attributes;
        let normals = attributes.get("NORMAL").filter(|a| a.width == 3);
        let normals = normals.map_or(&[][..], |a| a.data.as_chunks::<3>().0);
        self.deform_directions(piece, maps, normals, out);
    }

    /// Rotates unit vectors at a piece's vertices, given at rest, by the maps of [`Self::joint_maps`]. The blended matrix is
    /// applied, as in viewers.
    pub fn deform_directions(
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
            let blended = binding.influences(v).fold(DMat3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].matrix3 * w
            });
            (blended * n).normalize_or(n)
        }));
    }

    /// Computes what [`Self::deform_normals`] does, with the bindings that hold in a frame.
    pub fn deform_normals_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        out: &mut Vec<DVec3>,
    ) {
        let attributes = &self.pieces[piece].mesh.attributes;
        let normals = attributes.get("NORMAL").filter(|a| a.width == 3);
        let normals = normals.map_or(&[][..], |a| a.data.as_chunks::<3>().0);
        self.deform_directions_at(frame, piece, maps, normals, out);
    }

    /// Computes what [`Self::deform_directions`] does, with the bindings that hold in a frame.
    pub fn deform_directions_at(
        &self,
        frame: usize,
        piece: usize,
        maps: &[DAffine3],
        at_rest: &[[f32; 3]],
        out: &mut Vec<DVec3>,
    ) {
        self.deform_directions(piece, maps, at_rest, out);
        let earlier = &self.pieces[piece].earlier;
        for (change, vertex) in earlier.active_at(frame) {
            let Some(n) = at_rest.get(vertex) else {
                continue;
            };
            let n = DVec3::from_array(n.map(f64::from));
            let blended = (earlier.binding.influences(change)).fold(DMat3::ZERO, |sum, (j, w)| {
                sum + maps[j as usize].matrix3 * w
            });
            out[vertex] = (blended * n).normalize_or(n);
        }
    }

    /// Computes the positions of all vertices of a piece, m, for the poses of the joints. For many pieces at once,
    /// [`Self::joint_maps`] and [`Self::deform_positions`] do less work.
    pub fn pose_piece(&self, piece: usize, poses: &[Pose], out: &mut Vec<DVec3>) {
        let mut maps = Vec::with_capacity(self.joints.len());
        self.joint_maps(poses, &mut maps);
        self.deform_positions(piece, &maps, out);
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
            pieces: vec![SkinnedMesh {
                mesh: Mesh {
                    positions: vec![DVec3::new(0.0, 1.0, 0.0), DVec3::new(2.0, 0.0, 0.0)],
                    ..Mesh::default()
                },
                binding,
                ..SkinnedMesh::default()
            }],
            frames_per_second: 30.0,
            ..Film::default()
        }
    }

    #[test]
    fn joints_move_vertices_by_their_weights() {
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
    fn earlier_bindings_hold_before_their_frames() {
        let mut film = film();
        let earlier = &mut film.pieces[0].earlier;
        earlier.push(1, 2, DVec3::X, [(0, 1.0)]);
        earlier.push(1, 5, DVec3::Y, [(1, 1.0)]);
        assert_eq!(film.fault(), None);
        let mut poses: Vec<Pose> = film.joints.iter().map(|j| j.rest).collect();
        poses[0].translation.z += 4.0;
        let (mut maps, mut out) = (Vec::new(), Vec::new());
        film.joint_maps(&poses, &mut maps);
        let far = DVec3::new(2.0, 0.0, 0.0);
        let wanted = [
            (1, DVec3::new(1.0, 0.0, 4.0)),
            (2, DVec3::Y),
            (4, DVec3::Y),
            (5, far + DVec3::Z),
        ];
        for (frame, place) in wanted {
            film.deform_positions_at(frame, 0, &maps, &mut out);
            assert!(out[1].distance(place) < 1e-15, "{frame}: {}", out[1]);
            assert!(out[0].distance(DVec3::new(0.0, 1.0, 4.0)) < 1e-15);
        }
    }

    #[test]
    fn faults_are_found() {
        type Change = fn(&mut Film);
        let broken: [(&str, Change); 9] = [
            ("frame rate", |f| f.frames_per_second = f64::NAN),
            ("not a rigid pose", |f| f.joints[1].rest.rotation.x = 3.0),
            ("2 of 1 vertices", |f| {
                f.pieces[0].mesh.positions.truncate(1)
            }),
            ("follows joint 7", |f| f.pieces[0].binding.joints[2] = 7),
            ("add up to", |f| f.pieces[0].binding.weights[1] = f64::NAN),
            ("the ranges", |f| f.pieces[0].binding.starts[1] = 9),
            ("of vertex 2,", |f| {
                f.pieces[0].earlier.push(2, 1, DVec3::ZERO, [(0, 1.0)]);
            }),
            ("sorted", |f| {
                for until in [2, 1] {
                    (f.pieces[0].earlier).push(0, until, DVec3::ZERO, [(0, 1.0)]);
                }
            }),
            ("before a change, a vertex follows joint 9", |f| {
                f.pieces[0].earlier.push(0, 1, DVec3::ZERO, [(9, 1.0)]);
            }),
        ];
        for (message, change) in broken {
            let mut film = film();
            change(&mut film);
            let fault = film.fault().unwrap_or_default();
            assert!(fault.contains(message), "{message}: {fault}");
        }
    }
}
