//! The poses of a run's joints over time, read frame by frame.

use super::carry;
use super::follow::Follower;
use super::{FilmError, turned};
use glam::DQuat;
use greenstick_fibre::store::IndexedFrames;
use greenstick_geometry::{Motion, Pose};
use greenstick_skin::rods::{Joints, frame_poses};
use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::PathBuf;

/// How the joints of a film move, and its bodies. Holds one frame at a time.
pub struct RunMotion {
    frames: IndexedFrames<BufReader<File>>,
    path: PathBuf,
    range: Range<usize>,
    joints: Joints,
    /// Bodies that have a joint, behind those of the rods.
    bodies: Vec<usize>,
    /// What is carried, behind all others.
    carried: Vec<Follower>,
    up: DQuat,
}

impl RunMotion {
    pub(super) fn new(
        frames: IndexedFrames<BufReader<File>>,
        path: PathBuf,
        range: Range<usize>,
        (joints, bodies, carried): (Joints, Vec<usize>, Vec<Follower>),
        up: DQuat,
    ) -> Self {
        RunMotion {
            frames,
            path,
            range,
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
        self.range.len()
    }

    fn time(&self, frame: usize) -> f64 {
        self.frames.time(self.range.start + frame) - self.frames.time(self.range.start)
    }

    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), FilmError> {
        let number = self.range.start + frame;
        let read = self.frames.read(number).map_err(|error| FilmError::Store {
            path: self.path.clone(),
            error,
        })?;
        let frame = read.ok_or(FilmError::NoSuchFrame {
            number,
            count: self.frames.count(),
        })?;
        self.joints.check(&frame)?;
        let rods = frame_poses(&self.joints, &frame);
        let bodies = self.bodies.iter().filter_map(|&b| frame.bodies.get(b));
        let bodies = bodies.map(|body| Pose {
            translation: body.centre,
            rotation: body.rotation,
        });
        for (to, from) in poses.iter_mut().zip(rods.into_iter().chain(bodies)) {
            *to = turned(from, self.up);
        }
        carry::put(&self.carried, poses);
        Ok(())
    }
}
