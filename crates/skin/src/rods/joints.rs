//! Joints: a frame at each vertex of each rod, two at a vertex that is broken, one of each part.

use super::parting::{Part, Parting};
use super::{RodSkinError, Wood};
use glam::{DMat3, DQuat, DVec3};
use greenstick_fibre::store::Frame;
use greenstick_geometry::Pose;

/// The joints of a bundle that breaks at some vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Joints {
    /// Poses at rest.
    pub rest: Vec<Pose>,
    /// For each rod of the unbroken bundle its parts, each a run of joints with their lengths along the axis (m).
    parts: Vec<Vec<Vec<(u32, f64)>>>,
    /// The joint of each vertex of the unbroken bundle, at a broken one that of the part before.
    own: Vec<u32>,
    /// The broken vertices, ascending, with the joint of the part behind.
    behind: Vec<(u32, u32)>,
    /// Whether each joint follows the edge before it, and the one behind.
    edges: Vec<[bool; 2]>,
    /// For each of `behind` the turn from the vertex's frame at rest while it is whole to that of the part before, and to
    /// that of the part behind.
    parted: Vec<[DQuat; 2]>,
}

impl Joints {
    /// The joints of `wood` with the breaks of `parting`.
    pub fn new(wood: &Wood, parting: &Parting) -> Self {
        let bundle = wood.bundle;
        let mut made = Joints {
            rest: Vec::new(),
            parts: Vec::new(),
            own: (0..bundle.vertices() as u32).collect(),
            behind: Vec::new(),
            edges: vec![[true; 2]; bundle.vertices()],
            parted: Vec::new(),
        };
        for (rod, breaks) in parting.breaks.iter().enumerate() {
            let vertices = bundle.rod(rod);
            made.edges[vertices.start][0] = false;
            made.edges[vertices.end - 1][1] = false;
            let mut parts: Vec<Vec<(u32, f64)>> = vec![Vec::new()];
            let mut breaks = breaks.iter().map(|b| b.vertex).peekable();
            for v in vertices {
                let at = wood.along[v];
                if let Some(last) = parts.last_mut() {
                    last.push((v as u32, at));
                }
                if breaks.next_if_eq(&(v as u32)).is_some() {
                    let joint = made.edges.len() as u32;
                    made.behind.push((v as u32, joint));
                    made.edges[v][1] = false;
                    made.edges.push([false, true]);
                    parts.push(vec![(joint, at)]);
                }
            }
            made.parts.push(parts);
        }
        let frame = rest_frame(wood);
        let whole = frame_poses(&made, &frame);
        made.rest = poses(&made, &frame, true);
        let both = made.behind.iter().map(|&(v, behind)| {
            let joints = [made.own[v as usize], behind];
            joints.map(|j| {
                let back = whole[j as usize].rotation.conjugate();
                (back * made.rest[j as usize].rotation).normalize()
            })
        });
        made.parted = both.collect();
        made
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.edges.len()
    }

    /// The joints between which length `s` (m) of a part of a rod lies, with their weights; one beyond its ends.
    pub fn at(&self, rod: u32, part: Part, s: f64) -> [(u32, f64); 2] {
        let parts = &self.parts[rod as usize];
        let run = &parts[usize::from(part).min(parts.len() - 1)];
        let k = run
            .partition_point(|j| j.1 <= s)
            .clamp(1, run.len().max(2) - 1);
        let (a, b) = (run[k - 1], run[k.min(run.len() - 1)]);
        let t = ((s - a.1) / (b.1 - a.1).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        [(a.0, 1.0 - t), (b.0, t)]
    }

    /// As [`Self::at`] for parts of a rod that are still one. A vertex that will break there counts with the part before.
    pub(super) fn along(
        &self,
        rod: u32,
        together: std::ops::RangeInclusive<Part>,
        s: f64,
    ) -> [(u32, f64); 2] {
        let parts = &self.parts[rod as usize];
        let (low, high) = (*together.start(), *together.end());
        let begun = |part: &Part| parts[usize::from(*part)].first().is_some_and(|j| j.1 <= s);
        let part = (low + 1..=high).rev().find(begun).unwrap_or(low);
        let mut joints = self.at(rod, part, s);
        let first = parts[usize::from(part)].first().map(|j| j.0);
        if part > low && first == Some(joints[0].0) {
            let before = parts[usize::from(part) - 1].last();
            joints[0].0 = before.map_or(joints[0].0, |j| j.0);
        }
        joints
    }

    /// The vertex of the unbroken bundle with which the first edge of a part of a rod begins.
    pub fn first_edge(&self, rod: u32, part: Part) -> u32 {
        let joint = self.parts[rod as usize][usize::from(part)][0].0 as usize;
        match joint.checked_sub(self.own.len()) {
            Some(k) => self.behind[k].0,
            None => joint as u32,
        }
    }

    /// The original vertex of each joint.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.own
            .iter()
            .copied()
            .chain(self.behind.iter().map(|b| b.0))
    }
}

/// The unbroken bundle at rest as a frame.
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

/// The poses of all joints in a frame of the same bundle. A vertex that is not broken yet moves its two joints alike.
pub fn frame_poses(joints: &Joints, frame: &Frame) -> Vec<Pose> {
    poses(joints, frame, false)
}

/// The poses of all joints in a frame; with `parted` as though every vertex were broken that will be.
fn poses(joints: &Joints, frame: &Frame, parted: bool) -> Vec<Pose> {
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
            let broken = joints.behind.binary_search_by_key(&origin, |b| b.0);
            // Of a vertex's two copies the first ends a rod, the second begins one.
            let (ends, begins) = (behind.is_none(), before.is_none());
            let mut put = |joint: u32, side: usize| {
                let wanted = joints.edges[joint as usize];
                let pick =
                    |edge: Option<(DVec3, DVec3)>, wanted: bool| edge.filter(|_| wanted || !parted);
                let (a, b) = (pick(before, wanted[0]), pick(behind, wanted[1]));
                let mut rotation = match (a, b) {
                    (Some(a), Some(b)) => turn(a.0 + b.0, a.1 + b.1),
                    (Some(a), None) | (None, Some(a)) => turn(a.0, a.1),
                    (None, None) => DQuat::IDENTITY,
                };
                // It moves as the whole vertex does, from where it is at rest by itself.
                if let Ok(k) = broken
                    && !ends
                    && !begins
                    && let Some(off) = joints.parted.get(k)
                {
                    rotation = (rotation * off[side]).normalize();
                }
                poses[joint as usize] = Pose {
                    translation: place(i),
                    rotation,
                };
            };
            if broken.is_err() || !begins {
                put(joints.own[origin as usize], 0);
            }
            if let Ok(k) = broken
                && !ends
            {
                put(joints.behind[k].1, 1);
            }
        }
    }
    poses
}

/// The turn of a frame whose third axis is `tangent` and whose first lies next to `director`.
fn turn(tangent: DVec3, director: DVec3) -> DQuat {
    let z = tangent.normalize_or(DVec3::Z);
    let x = director
        .reject_from_normalized(z)
        .normalize_or(z.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).normalize()
}

impl Joints {
    /// Whether a frame is of a bundle with as many vertices.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] where it is not.
    pub fn check(&self, frame: &Frame) -> Result<(), RodSkinError> {
        let most = frame.origin.iter().max().map_or(0, |&m| m as usize + 1);
        if most == self.own.len() {
            return Ok(());
        }
        Err(RodSkinError::OtherBundle {
            what: "the number of vertices",
            problem: format!("it has {most}, the skin {}", self.own.len()),
        })
    }
}
