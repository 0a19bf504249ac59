//! Where a run is recorded, and where a recorded run is read from.

use super::checkpoint::{Checkpoint, Progress};
use super::error::RunError;
use super::forces::ForceRow;
use super::frames::Frame;
use super::tables::EnergyRow;
use crate::event::Event;
use crate::scene::Scene;
use std::sync::Arc;

/// Takes what a run records, in the order of time. [`super::MemoryRun`] keeps it in memory.
///
/// All but the checkpoint only grows. Whatever happens, the last checkpoint remains usable: a run is resumed by cutting the
/// records back to the lengths that they had then.
pub trait RunSink: Send {
    /// Begins the records of a run that is not there yet. `scene` has the lengths of its stem.
    ///
    /// # Errors
    /// [`RunError`], as for all that follows.
    fn begin(&mut self, scene: &Scene) -> Result<(), RunError>;

    /// Cuts the records back to what they were at a checkpoint, which was found to be one of this run.
    ///
    /// # Errors
    /// [`RunError`]; [`RunError::Short`] where a record is shorter than it was.
    fn resume(&mut self, progress: &Progress) -> Result<(), RunError>;

    /// Replaces the scene of a run that goes on from its last checkpoint with other key frames of its clamps. Returns whether the
    /// record takes that; one that does not goes on with the scene that it was begun with alone.
    ///
    /// # Errors
    /// [`RunError`].
    fn steer(&mut self, _scene: &Scene) -> Result<bool, RunError> {
        Ok(false)
    }

    /// Takes a row of the energy table.
    ///
    /// # Errors
    /// [`RunError`].
    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError>;

    /// Takes an event.
    ///
    /// # Errors
    /// [`RunError`].
    fn event(&mut self, event: &Event) -> Result<(), RunError>;

    /// Takes the force of a clamp or a body.
    ///
    /// # Errors
    /// [`RunError`].
    fn force(&mut self, row: &ForceRow) -> Result<(), RunError>;

    /// Takes a frame.
    ///
    /// # Errors
    /// [`RunError`].
    fn frame(&mut self, frame: Frame) -> Result<(), RunError>;

    /// Replaces the checkpoint, in which it sets the lengths of the records. What was taken before must not be lost from
    /// here on.
    ///
    /// # Errors
    /// [`RunError`]. The checkpoint before is then kept.
    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError>;

    /// Returns the names of what was written, for reports.
    fn outputs(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Gives what a run has recorded so far. [`super::MemoryRun`] has it in memory.
pub trait RunSource: Send + Sync {
    /// Returns a name for messages, such as that of a folder.
    fn name(&self) -> String;

    /// Returns the scene as it was run.
    ///
    /// # Errors
    /// [`RunError`], as for all that follows; [`RunError::NoRun`] where nothing is recorded.
    fn scene(&self) -> Result<Scene, RunError>;

    /// Returns the last checkpoint; `None` where there is none.
    ///
    /// # Errors
    /// [`RunError`].
    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError>;

    /// Returns the energy table.
    ///
    /// # Errors
    /// [`RunError`].
    fn energies(&self) -> Result<Vec<EnergyRow>, RunError>;

    /// Returns all events.
    ///
    /// # Errors
    /// [`RunError`].
    fn events(&self) -> Result<Vec<Event>, RunError>;

    /// Returns the forces of clamps and bodies.
    ///
    /// # Errors
    /// [`RunError`].
    fn forces(&self) -> Result<Vec<ForceRow>, RunError>;

    /// Returns which frames there are.
    ///
    /// # Errors
    /// [`RunError`].
    fn frames(&self) -> Result<FrameTimes, RunError>;

    /// Returns frame `number`, counted from 0.
    ///
    /// # Errors
    /// [`RunError`]; [`RunError::NoSuchFrame`] beyond the last.
    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError>;
}

/// A run that can be recorded and read back.
pub trait RunStore: RunSink + RunSource {}

impl<T: RunSink + RunSource> RunStore for T {}

/// Which frames a run has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameTimes {
    /// The time of each, s.
    pub times: Vec<f64>,
    /// Bytes behind the last complete frame: above 0 where a run was cut short.
    pub trailing_bytes: u64,
}

impl FrameTimes {
    /// Returns the number of frames.
    pub fn count(&self) -> usize {
        self.times.len()
    }
}
