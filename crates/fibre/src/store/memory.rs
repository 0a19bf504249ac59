//! A run in memory.

use super::checkpoint::{Checkpoint, Progress, RecordLengths};
use super::error::RunError;
use super::forces::ForceRow;
use super::frames::Frame;
use super::record::{FrameTimes, RunSink, RunSource};
use super::tables::EnergyRow;
use crate::event::Event;
use crate::scene::Scene;
use std::sync::Arc;

/// A run that is recorded in memory.
#[derive(Debug, Clone, Default)]
pub struct MemoryRun {
    scene: Option<Scene>,
    energies: Vec<EnergyRow>,
    events: Vec<Event>,
    frames: Vec<Arc<Frame>>,
    forces: Vec<ForceRow>,
    checkpoint: Option<Checkpoint>,
}

const NAME: &str = "the run in memory";

impl MemoryRun {
    /// Returns an empty one.
    pub fn new() -> Self {
        MemoryRun::default()
    }

    fn lengths(&self) -> RecordLengths {
        RecordLengths {
            energies: self.energies.len() as u64,
            events: self.events.len() as u64,
            frames: self.frames.len() as u64,
            forces: self.forces.len() as u64,
        }
    }
}

fn cut<T>(rows: &mut Vec<T>, length: u64) -> Result<(), RunError> {
    if (rows.len() as u64) < length {
        return Err(RunError::Short {
            location: NAME.to_owned(),
            unit: "rows",
            found: rows.len() as u64,
            expected: length,
        });
    }
    rows.truncate(length as usize);
    Ok(())
}

impl RunSink for MemoryRun {
    fn begin(&mut self, scene: &Scene) -> Result<(), RunError> {
        *self = MemoryRun {
            scene: Some(scene.clone()),
            ..MemoryRun::default()
        };
        Ok(())
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        let lengths = progress.lengths;
        cut(&mut self.energies, lengths.energies)?;
        cut(&mut self.events, lengths.events)?;
        cut(&mut self.frames, lengths.frames)?;
        cut(&mut self.forces, lengths.forces)
    }

    fn steer(&mut self, scene: &Scene) -> Result<bool, RunError> {
        self.scene = Some(scene.clone());
        Ok(true)
    }

    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.energies.push(*row);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.events.push(*event);
        Ok(())
    }

    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.forces.push(row.clone());
        Ok(())
    }

    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        self.frames.push(Arc::new(frame));
        Ok(())
    }

    fn save(&mut self, mut checkpoint: Checkpoint) -> Result<(), RunError> {
        checkpoint.progress.lengths = self.lengths();
        self.checkpoint = Some(checkpoint);
        Ok(())
    }
}

impl RunSource for MemoryRun {
    fn name(&self) -> String {
        NAME.to_owned()
    }

    fn scene(&self) -> Result<Scene, RunError> {
        self.scene.clone().ok_or(RunError::NoRun {
            location: self.name(),
            problem: "nothing was simulated".into(),
        })
    }

    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        Ok(self.checkpoint.clone())
    }

    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        Ok(self.energies.clone())
    }

    fn events(&self) -> Result<Vec<Event>, RunError> {
        Ok(self.events.clone())
    }

    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        Ok(self.forces.clone())
    }

    fn frames(&self) -> Result<FrameTimes, RunError> {
        Ok(FrameTimes {
            times: self.frames.iter().map(|f| f.time).collect(),
            trailing_bytes: 0,
        })
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        let frame = self.frames.get(number).cloned();
        frame.ok_or(RunError::NoSuchFrame {
            number,
            count: self.frames.len(),
        })
    }
}
