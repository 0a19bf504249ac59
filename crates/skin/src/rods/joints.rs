//! The joints of a skin: a frame at each vertex of each rod, and two at a broken vertex, one for each part.

use super::error::RodSkinError;
use super::fracture_state::{FractureState, RodPart};
use super::wood::Wood;
use glam::{DMat3, DQuat, DVec3};
use greenstick_fibre::store::Frame;
use greenstick_geometry::Pose;

/// The joints of a bundle that breaks at some vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Joints {
    /// Poses at rest.
    pub rest: Vec<Pose>,
    /// The parts of each rod of the unbroken bundle: runs of joints with their lengths along the axis, m.
    parts: Vec<Vec<Vec<(u32, f64)>>>,
    /// The joint of each vertex of the unbroken bundle; at a broken one that of the part before.
    joint_of_vertex: Vec<u32>,
    /// The broken vertices, ascending, each with the joint of the part behind.
    joints_behind: Vec<(u32, u32)>,
    /// Whether each joint follows the edge before it, and whether it follows the one behind.
    follows_edges: Vec<[bool; 2]>,
    /// For each of `joints_behind` the rotation from the frame of the unbroken vertex at rest to that of the part before,
    /// and to that of the part behind.
    break_rotations: Vec<[DQuat; 2]>,
}

impl Joints {
    /// Returns the joints of `wood` with the breaks of `state`.
    pub fn new(wood: &Wood, state: &FractureState) -> Self {
        let bundle = wood.bundle;
        let mut joints = Joints {
            rest: Vec::new(),
            parts: Vec::new(),
            joint_of_vertex: (0..bundle.vertices() as u32).collect(),
            joints_behind: Vec::new(),
            follows_edges: vec![[true; 2]; bundle.vertices()],
            break_rotations: Vec::new(),
        };
        for (rod, breaks) in state.breaks.iter().enumerate() {
            let vertices = bundle.rod(rod);
            joints.follows_edges[vertices.start][0] = false;
            joints.follows_edges[vertices.end - 1][1] = false;
            let mut parts: Vec<Vec<(u32, f64)>> = vec![Vec::new()];
            let mut breaks = breaks.iter().map(|b| b.vertex).peekable();
            for v in vertices {
                let at = wood.along[v];
                if let Some(last) = parts.last_mut() {
                    last.push((v as u32, at));
                }
                if breaks.next_if_eq(&(v as u32)).is_some() {
                    let joint = joints.follows_edges.len() as u32;
                    joints.joints_behind.push((v as u32, joint));
                    joints.follows_edges[v][1] = false;
                    joints.follows_edges.push([false, true]);
                    parts.push(vec![(joint, at)]);
                }
            }
            joints.parts.push(parts);
        }
        let frame = rest_frame(wood);
        let whole = frame_poses(&joints, &frame);
        joints.rest = poses(&joints, &frame, true);
        let rotations = joints.joints_behind.iter().map(|&(v, behind)| {
            [joints.joint_of_vertex[v as usize], behind].map(|j| {
                let back = whole[j as usize].rotation.conjugate();
                (back * joints.rest[j as usize].rotation).normalize()
            })
        });
        joints.break_rotations = rotations.collect();
        joints
    }

    /// Returns the number of joints.
    pub fn count(&self) -> usize {
        self.follows_edges.len()
    }

    /// Returns the joints on both sides of length `s` (m) of a part of a rod, with their weights. Beyond the part's ends the
    /// weight of one is 0.
    pub fn weights_at(&self, rod: u32, part: RodPart, s: f64) -> [(u32, f64); 2] {
        let parts = &self.parts[rod as usize];
        let run = &parts[usize::from(part).min(parts.len() - 1)];
        let k = run
            .partition_point(|j| j.1 <= s)
            .clamp(1, run.len().max(2) - 1);
        let (a, b) = (run[k - 1], run[k.min(run.len() - 1)]);
        let t = ((s - a.1) / (b.1 - a.1).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        [(a.0, 1.0 - t), (b.0, t)]
    }

    /// Adds the joints of a part of a rod that are no farther than `reach` (m) from a length along the axis (m), or else the
    /// nearest one.
    pub(crate) fn near(
        &self,
        rod: u32,
        part: RodPart,
        along: f64,
        reach: f64,
        near: &mut Vec<u32>,
    ) {
        let joints = &self.parts[rod as usize][usize::from(part)];
        let off = |joint: &(u32, f64)| (joint.1 - along).abs();
        let before = near.len();
        near.extend(joints.iter().filter(|j| off(j) <= reach).map(|j| j.0));
        if near.len() == before {
            let nearest = joints.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            near.extend(nearest.map(|j| j.0));
        }
    }

    /// As [`Self::weights_at`] for the range of parts of a rod that are `together` still. A vertex between them, which will
    /// break, counts with the part before.
    pub(super) fn weights_while_together(
        &self,
        rod: u32,
        together: std::ops::RangeInclusive<RodPart>,
        s: f64,
    ) -> [(u32, f64); 2] {
        let parts = &self.parts[rod as usize];
        let (low, high) = (*together.start(), *together.end());
        let has_begun =
            |part: &RodPart| parts[usize::from(*part)].first().is_some_and(|j| j.1 <= s);
        let part = (low + 1..=high).rev().find(has_begun).unwrap_or(low);
        let mut joints = self.weights_at(rod, part, s);
        let first = parts[usize::from(part)].first().map(|j| j.0);
        if part > low && first == Some(joints[0].0) {
            let before = parts[usize::from(part) - 1].last();
            joints[0].0 = before.map_or(joints[0].0, |j| j.0);
        }
        joints
    }

    /// Returns the vertex of the unbroken bundle with which the first edge of a part of a rod begins.
    pub fn first_edge(&self, rod: u32, part: RodPart) -> u32 {
        let joint = self.parts[rod as usize][usize::from(part)][0].0 as usize;
        match joint.checked_sub(self.joint_of_vertex.len()) {
            Some(k) => self.joints_behind[k].0,
            None => joint as u32,
        }
    }

    /// Returns the vertex of the unbroken bundle of each joint.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.joint_of_vertex
            .iter()
            .copied()
            .chain(self.joints_behind.iter().map(|b| b.0))
    }
}

/// Returns the unbroken bundle at rest as a frame.
fn rest_frame(wood: &Wood) -> Frame {
    let bundle = wood.bundle;
    let single = |v: DVec3| v.as_vec3().to_array();
    Frame {
        rod_offsets: bundle.rod_offsets.clone(),
        parent: bundle.parent.clone(),
        origin: bundle.origin.clone(),
        position: bundle.rest.iter().map(single).collect(),
        director: bundle.rest_director.iter().map(single).collect(),
        ..Frame::default()
    }
}

/// Returns the poses of all joints in a frame of the same bundle. A vertex that is not broken yet moves its two joints alike.
pub fn frame_poses(joints: &Joints, frame: &Frame) -> Vec<Pose> {
    poses(joints, frame, false)
}

/// Returns the poses of all joints in a frame. With `all_broken` every vertex counts as broken that will break.
fn poses(joints: &Joints, frame: &Frame, all_broken: bool) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; joints.count()];
    let place = |i: usize| DVec3::from_array(frame.position[i].map(f64::from));
    for ends in frame.rod_offsets.windows(2) {
        let (from, to) = (ends[0] as usize, ends[1] as usize);
        let edge = |i: usize| {
            let tangent = (place(i + 1) - place(i)).normalize_or(DVec3::X);
            (tangent, DVec3::from_array(frame.director[i].map(f64::from)))
        };
        for i in from..to {
            let origin = frame.origin[i];
            let before = (i > from).then(|| edge(i - 1));
            let behind = (i + 1 < to).then(|| edge(i));
            let broken = joints.joints_behind.binary_search_by_key(&origin, |b| b.0);
            // Of a vertex's two copies the first ends a rod, the second begins one.
            let (ends, begins) = (behind.is_none(), before.is_none());
            let mut set_pose = |joint: u32, side: usize| {
                let followed = joints.follows_edges[joint as usize];
                let pick = |edge: Option<(DVec3, DVec3)>, followed: bool| {
                    edge.filter(|_| followed || !all_broken)
                };
                let (a, b) = (pick(before, followed[0]), pick(behind, followed[1]));
                let mut rotation = match (a, b) {
                    (Some(a), Some(b)) => frame_rotation(a.0 + b.0, a.1 + b.1),
                    (Some(a), None) | (None, Some(a)) => frame_rotation(a.0, a.1),
                    (None, None) => DQuat::IDENTITY,
                };
                // It moves as the whole vertex does, from where it is at rest by itself.
                if let Ok(k) = broken
                    && !ends
                    && !begins
                    && let Some(off) = joints.break_rotations.get(k)
                {
                    rotation = (rotation * off[side]).normalize();
                }
                poses[joint as usize] = Pose {
                    translation: place(i),
                    rotation,
                };
            };
            if broken.is_err() || !begins {
                set_pose(joints.joint_of_vertex[origin as usize], 0);
            }
            if let Ok(k) = broken
                && !ends
            {
                set_pose(joints.joints_behind[k].1, 1);
            }
        }
    }
    poses
}

/// Returns the rotation of a frame whose third axis is `tangent` and whose first axis is nearest to `director`.
fn frame_rotation(tangent: DVec3, director: DVec3) -> DQuat {
    let z = tangent.normalize_or(DVec3::Z);
    let x = director
        .reject_from_normalized(z)
        .normalize_or(z.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).normalize()
}

impl Joints {
    /// Checks that a frame is of a bundle with as many vertices.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] where it is not.
    pub fn check(&self, frame: &Frame) -> Result<(), RodSkinError> {
        let count = frame.origin.iter().max().map_or(0, |&m| m as usize + 1);
        if count == self.joint_of_vertex.len() {
            return Ok(());
        }
        Err(RodSkinError::OtherBundle {
            what: "the number of vertices",
            problem: format!("it has {count}, the skin {}", self.joint_of_vertex.len()),
        })
    }
}
