//! The poses of a run's joints over time, read frame by frame.

use super::error::FilmError;
use super::poses::rotated;
use crate::remainder::{Follower, pose_followers};
use crate::rods::{Joints, frame_poses};
use glam::DQuat;
use greenstick_fibre::store::RunSource;
use greenstick_geometry::{Motion, Pose};
use std::sync::Arc;

/// The parts of a film that move, in the order of its joints.
pub(super) struct MovingParts {
    /// The joints of the rods.
    pub joints: Joints,
    /// Numbers of the bodies that have a joint.
    pub bodies: Vec<usize>,
    /// Carried parts that have a joint.
    pub carried: Vec<Follower>,
}

/// The motion of a film's joints and bodies. Holds one frame at a time.
pub struct RunMotion {
    source: Arc<dyn RunSource>,
    /// Time of each frame, s.
    times: Vec<f64>,
    /// Number of the first frame in the run.
    first: usize,
    joints: Joints,
    /// Bodies that have a joint, behind those of the rods.
    bodies: Vec<usize>,
    /// What is carried, behind all others.
    carried: Vec<Follower>,
    up: DQuat,
}

impl RunMotion {
    pub(super) fn new(
        source: Arc<dyn RunSource>,
        times: Vec<f64>,
        first: usize,
        moving: MovingParts,
        up: DQuat,
    ) -> Self {
        let MovingParts {
            joints,
            bodies,
            carried,
        } = moving;
        RunMotion {
            source,
            times,
            first,
            joints,
            bodies,
            carried,
            up,
        }
    }
}

impl Motion for RunMotion {
    type Error = FilmError;

    fn frames(&self) -> usize {
        self.times.len()
    }

    fn time(&self, frame: usize) -> f64 {
        self.times[frame] - self.times[0]
    }

    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), FilmError> {
        let frame = self.source.frame(self.first + frame)?;
        self.joints.check(&frame)?;
        let rods = frame_poses(&self.joints, &frame);
        let bodies = self.bodies.iter().filter_map(|&b| frame.bodies.get(b));
        let bodies = bodies.map(|body| Pose {
            translation: body.centre,
            rotation: body.rotation,
        });
        for (to, from) in poses.iter_mut().zip(rods.into_iter().chain(bodies)) {
            *to = rotated(from, self.up);
        }
        pose_followers(&self.carried, poses);
        Ok(())
    }
}
