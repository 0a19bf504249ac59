//! The poses of a run's joints over time, read frame by frame.

use super::drawn::SectionJoints;
use super::error::FilmError;
use super::placement::Placement;
use crate::remainder::{Follower, pose_followers};
use crate::rods::{Joints, frame_poses};
use greenstick_fibre::store::RunSource;
use greenstick_geometry::{Motion, Pose};
use std::sync::Arc;

/// The parts of a film that move, in the order of its joints.
pub(super) struct MovingParts {
    /// The joints of the rods.
    pub joints: Joints,
    /// Numbers of the bodies that have a joint.
    pub bodies: Vec<usize>,
    /// What follows the rods.
    pub behind: MovingBehind,
}

/// Joints of a film that follow those of the rods.
pub(super) enum MovingBehind {
    /// What is carried, behind the joints of the rods and those of the bodies.
    Carried(Vec<Follower>),
    /// Sections of pieces, behind the joints of the bodies. The film has none of the rods'.
    Sections(SectionJoints),
}

/// The motion of a film's joints and bodies. Holds one frame at a time.
pub struct RunMotion {
    source: Arc<dyn RunSource>,
    /// Time of each frame, s.
    times: Vec<f64>,
    /// Number of the first frame in the run.
    first: usize,
    joints: Joints,
    bodies: Vec<usize>,
    behind: MovingBehind,
    placement: Placement,
}

impl RunMotion {
    pub(super) fn new(
        source: Arc<dyn RunSource>,
        times: Vec<f64>,
        first: usize,
        moving: MovingParts,
        placement: Placement,
    ) -> Self {
        let MovingParts {
            joints,
            bodies,
            behind,
        } = moving;
        RunMotion {
            source,
            times,
            first,
            joints,
            bodies,
            behind,
            placement,
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

    fn poses(&mut self, number: usize, poses: &mut [Pose]) -> Result<(), FilmError> {
        let frame = self.source.frame(self.first + number)?;
        self.joints.check(&frame)?;
        let placed = |pose: Pose| self.placement.pose(pose);
        let rods = frame_poses(&self.joints, &frame).into_iter().map(placed);
        let bodies = self.bodies.iter().filter_map(|&b| frame.bodies.get(b));
        let bodies = bodies.map(|body| {
            placed(Pose {
                translation: body.centre,
                rotation: body.rotation,
            })
        });
        match &self.behind {
            MovingBehind::Carried(carried) => {
                for (to, from) in poses.iter_mut().zip(rods.chain(bodies)) {
                    *to = from;
                }
                pose_followers(carried, poses);
            }
            MovingBehind::Sections(sections) => {
                let rods: Vec<Pose> = rods.collect();
                let moving = bodies.chain(sections.poses(number, &rods));
                for (to, from) in poses.iter_mut().zip(moving) {
                    *to = from;
                }
            }
        }
        Ok(())
    }
}
