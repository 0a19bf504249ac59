//! A run that is recorded in memory, read while it grows, and gone on with from earlier states of it.

use greenstick::fibre::Event;
use greenstick::fibre::scene::Scene as Setting;
use greenstick::fibre::simulate::scenes_agree_until;
use greenstick::fibre::store::{Checkpoint, EnergyRow, ForceRow, Frame, FrameTimes, Progress};
use greenstick::simulate::{MemoryRun, RunError, RunSink, RunSource};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most states that are kept. Where there are more, every other one is let go: a run then goes on from a state before the one that
/// is asked for, which takes longer and gives the same.
const MOST_STATES: usize = 64;
/// Most vertices of rods that the kept states have together, each of which takes about a kilobyte with its bonds.
const MOST_VERTICES: usize = 400_000;
/// Seconds by which the end of a scene and a state there may differ.
pub const SAME_TIME: f64 = 1e-9;

/// A state that a run can go on from.
#[derive(Clone)]
struct State {
    /// The scene of the run when it was kept, with lengths for its stem.
    setting: Arc<Setting>,
    checkpoint: Arc<Checkpoint>,
}

#[derive(Clone, Default)]
struct Content {
    run: MemoryRun,
    /// States at the end of frames, in their order.
    states: Vec<State>,
}

impl Content {
    /// Keeps the state that was saved last, if it is that of a frame which has none yet.
    fn keep(&mut self) -> Result<(), RunError> {
        let Some(checkpoint) = self.run.checkpoint()? else {
            return Ok(());
        };
        let last = self.states.last();
        if last.is_some_and(|s| s.checkpoint.progress.frames >= checkpoint.progress.frames) {
            return Ok(());
        }
        let vertices = checkpoint.world.state.position.x.len();
        let setting = self.run.scene()?;
        let setting = match last.filter(|s| *s.setting == setting) {
            Some(last) => last.setting.clone(),
            None => Arc::new(setting),
        };
        let checkpoint = Arc::new(checkpoint);
        self.states.push(State {
            setting,
            checkpoint,
        });
        let most = (MOST_VERTICES / vertices.max(1)).clamp(2, MOST_STATES);
        if self.states.len() > most {
            let mut number = 0;
            self.states.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
        Ok(())
    }

    /// Goes back to a state that was kept.
    fn go_back(&mut self, number: usize) -> Result<(), RunError> {
        self.states.truncate(number + 1);
        let State {
            setting,
            checkpoint,
        } = self.states[number].clone();
        self.run.steer(&setting)?;
        self.run.resume(&checkpoint.progress)?;
        self.run.save(Checkpoint::clone(&checkpoint))
    }
}

/// A run that is recorded in memory, with states that it can be gone on from.
#[derive(Clone, Default)]
pub struct Recording(Arc<Mutex<Content>>);

impl Recording {
    fn content(&self) -> MutexGuard<'_, Content> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A recording of its own of a run of `before` until where `next` begins to move otherwise, for `next` to go on from; none where
    /// it does so from the start.
    pub fn branch(&self, before: &Setting, next: &Setting) -> Option<Recording> {
        let content = self.content();
        let agrees = |state: &State| {
            let Checkpoint {
                world, progress, ..
            } = &*state.checkpoint;
            let time = world.state.time;
            // A run with nothing left to do would not know how it stepped.
            progress.buckling.is_none()
                && time < next.duration - SAME_TIME
                && scenes_agree_until(before, next, time)
        };
        let number = content.states.iter().rposition(agrees)?;
        let mut branch = content.clone();
        drop(content);
        branch.go_back(number).ok()?;
        Some(Recording(Arc::new(Mutex::new(branch))))
    }
}

impl RunSink for Recording {
    fn begin(&mut self, scene: &Setting) -> Result<(), RunError> {
        let mut content = self.content();
        content.states.clear();
        content.run.begin(scene)
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.content().run.resume(progress)
    }

    fn steer(&mut self, scene: &Setting) -> Result<bool, RunError> {
        self.content().run.steer(scene)
    }

    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.content().run.energy(row)
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.content().run.event(event)
    }

    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.content().run.force(row)
    }

    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        RunSink::frame(&mut self.content().run, frame)
    }

    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError> {
        let mut content = self.content();
        content.run.save(checkpoint)?;
        content.keep()
    }
}

impl RunSource for Recording {
    fn name(&self) -> String {
        self.content().run.name()
    }

    fn scene(&self) -> Result<Setting, RunError> {
        self.content().run.scene()
    }

    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        self.content().run.checkpoint()
    }

    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        self.content().run.energies()
    }

    fn events(&self) -> Result<Vec<Event>, RunError> {
        self.content().run.events()
    }

    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        self.content().run.forces()
    }

    fn frames(&self) -> Result<FrameTimes, RunError> {
        self.content().run.frames()
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        RunSource::frame(&self.content().run, number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hand::{add_hand, steered};
    use crate::model::holds::{HoldPart, Moved};
    use greenstick::geometry::Context;
    use greenstick::simulate::{SimulateRequest, simulate};

    const HELD: &str = "duration = 0.3\nframes_per_second = 20.0\nfor_length = '15 cm'\nsolver = 'interactive'\n\
        [stem]\nkind = 'cylinder'\nlength = '15 cm'\ndiameter = '1 cm'\n[rods]\nnumber = 7\nedge = ['8 mm', '12 mm']\n\
        [loads]\ndamping = 5.0\n[[clamp]]\nto = 0.08\n";

    fn run(setting: &Setting, recording: &mut Recording) {
        let request = SimulateRequest {
            scene: setting.clone(),
            resume: recording.frames().is_ok_and(|f| f.count() > 0),
            ..SimulateRequest::default()
        };
        simulate(&request, recording, &Context::quiet()).unwrap();
    }

    #[test]
    fn a_run_goes_on_from_any_of_its_frames_as_one_that_was_begun_so() {
        let setting = Setting::read(HELD).unwrap();
        let with = |hand: &Moved| {
            let mut setting = setting.clone();
            add_hand(&mut setting, hand);
            setting
        };
        let hand = Moved {
            part: HoldPart::Hand,
            at: 0.9,
            by: [0.0, 0.0, -0.3],
            before: Vec::new(),
        };
        let first = with(&hand);
        let mut recording = Recording::default();
        run(&first, &mut recording);
        let times = recording.frames().unwrap().times;
        assert_eq!(times.len(), 7);
        for number in [6, 3, 0] {
            let next = with(&steered(&setting, &hand, times[number], [0.0, 0.2, 0.1]));
            let mut branch = recording.branch(&first, &next).unwrap();
            let kept = branch.frames().unwrap().count();
            // Where a state is a rounding after its frame's time, the hand is steered in the next.
            assert!(
                (number + 1..=number + 2).contains(&kept),
                "{kept} of {number}"
            );
            run(&next, &mut branch);
            let mut alone = Recording::default();
            run(&next, &mut alone);
            let count = alone.frames().unwrap().count();
            assert!(branch.frames().unwrap().count() == count && count >= 7);
            for i in 0..count {
                assert_eq!(branch.frame(i).unwrap(), alone.frame(i).unwrap());
            }
            assert_eq!(branch.energies().unwrap(), alone.energies().unwrap());
        }
        // What it went on from is as it was.
        assert_eq!(recording.frames().unwrap().count(), 7);
        // Where the hand takes hold elsewhere, nothing can be kept.
        let elsewhere = Moved { at: 0.8, ..hand };
        assert!(recording.branch(&first, &with(&elsewhere)).is_none());
    }
}
