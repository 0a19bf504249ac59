//! The frames of a film: validated, one at a time.

use super::check::check;
use super::error::FilmError;
use crate::error::{FormatError, InFile};
use greenstick_geometry::{Film, Motion, Pose};

/// Writes the poses of a frame to a list.
type Fetch<'a> = Box<dyn FnMut(usize, &mut [Pose]) -> Result<(), FilmError> + 'a>;

/// The frames of a valid film.
pub(crate) struct Frames<'a> {
    /// Time of each frame, s.
    pub times: Vec<f64>,
    /// Name of the file to write.
    pub name: &'a str,
    fetch: Fetch<'a>,
    poses: Vec<Pose>,
}

impl<'a> Frames<'a> {
    /// Validates the film and the times of its frames.
    pub fn new<M: Motion>(
        film: &Film,
        motion: &'a mut M,
        name: &'a str,
    ) -> Result<Self, FormatError> {
        let file = InFile(name);
        check(film, file)?;
        let times: Vec<f64> = (0..motion.frames()).map(|f| motion.time(f)).collect();
        if times.is_empty() {
            return Err(file.unwritable("the film has no frames", "at least one frame"));
        }
        // Files store single precision, in which times that are too close together coincide.
        let mut before = -f32::MIN_POSITIVE;
        for (frame, &time) in times.iter().enumerate() {
            let after = time as f32;
            // True for NaN, too.
            if !(after.is_finite() && after > before) {
                let found = format!("frame {frame} has the time {time} s");
                return Err(file.unwritable(found, "times that ascend from 0 s or later"));
            }
            before = after;
        }
        let fetch = move |frame: usize, poses: &mut [Pose]| {
            motion.poses(frame, poses).map_err(|e| FilmError::Motion {
                file: name.to_owned(),
                frame,
                source: Box::new(e),
            })
        };
        Ok(Frames {
            times,
            name,
            fetch: Box::new(fetch),
            poses: vec![Pose::IDENTITY; film.joints.len()],
        })
    }

    /// The file, for messages.
    pub fn file(&self) -> InFile<'a> {
        InFile(self.name)
    }

    /// Number of frames.
    pub fn count(&self) -> usize {
        self.times.len()
    }

    /// The poses in a frame.
    pub fn poses(&mut self, frame: usize) -> Result<&[Pose], FilmError> {
        (self.fetch)(frame, &mut self.poses)?;
        // Files store single precision.
        let fits = |p: &Pose| p.is_sound() && p.translation.as_vec3().is_finite();
        if let Some(joint) = self.poses.iter().position(|p| !fits(p)) {
            let found = format!(
                "joint {joint} has the pose {:?} in frame {frame}",
                self.poses[joint]
            );
            return Err(self.file().unwritable(found, "rigid poses").into());
        }
        Ok(&self.poses)
    }

    /// The error for a failure of the destination.
    pub fn write_error(&self, source: std::io::Error) -> FilmError {
        FilmError::Write {
            file: self.name.to_owned(),
            source,
        }
    }
}
