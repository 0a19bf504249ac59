//! The frames of a film as writers ask for them: checked, one at a time.

use super::{FilmError, check};
use crate::error::{FormatError, InFile};
use greenstick_geometry::{Film, Motion, Pose};

type Fetch<'a> = Box<dyn FnMut(usize, &mut [Pose]) -> Result<(), FilmError> + 'a>;

/// The frames of a film that was found sound.
pub(crate) struct Reel<'a> {
    /// When each frame is shown, s.
    pub times: Vec<f64>,
    /// Name of the file that is written.
    pub name: &'a str,
    fetch: Fetch<'a>,
    poses: Vec<Pose>,
}

impl<'a> Reel<'a> {
    /// Checks the film and the times of its frames.
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
        // Files keep 32 bits, so that times too near each other become one there.
        let mut before = -f32::MIN_POSITIVE;
        for (frame, &time) in times.iter().enumerate() {
            let after = time as f32;
            // NaN fails too.
            if !(after.is_finite() && after > before) {
                let found = format!("frame {frame} is shown at {time} s");
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
        Ok(Reel {
            times,
            name,
            fetch: Box::new(fetch),
            poses: vec![Pose::IDENTITY; film.joints.len()],
        })
    }

    /// The file for messages.
    pub fn file(&self) -> InFile<'a> {
        InFile(self.name)
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// The poses at a frame.
    pub fn at(&mut self, frame: usize) -> Result<&[Pose], FilmError> {
        (self.fetch)(frame, &mut self.poses)?;
        // Files keep 32 bits.
        let fits = |p: &Pose| p.is_sound() && p.translation.as_vec3().is_finite();
        if let Some(joint) = self.poses.iter().position(|p| !fits(p)) {
            let found = format!(
                "joint {joint} lies at {:?} in frame {frame}",
                self.poses[joint]
            );
            return Err(self.file().unwritable(found, "rigid poses").into());
        }
        Ok(&self.poses)
    }

    /// An error of the file that is written to.
    pub fn failed(&self, source: std::io::Error) -> FilmError {
        FilmError::Write {
            file: self.name.to_owned(),
            source,
        }
    }
}
