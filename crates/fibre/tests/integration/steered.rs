//! Runs whose clamps get other key frames while they go on: they end as runs that had them from the start.

use greenstick_fibre::Event;
use greenstick_fibre::scene::{KeyFrame, Scene};
use greenstick_fibre::simulate::{SimulateError, SimulateRequest, simulate};
use greenstick_fibre::store::{
    Checkpoint, EnergyRow, ForceRow, Frame, FrameTimes, MemoryRun, Progress, RunError, RunSink,
    RunSource,
};
use greenstick_geometry::Context;
use std::sync::Arc;

/// A stick that is held at its base, and a clamp near its tip.
const HELD: &str = "duration = 0.4\nframes_per_second = 20.0\nsolver = 'interactive'\n\
    [stem]\nkind = 'cylinder'\nlength = '15 cm'\ndiameter = '1 cm'\n[failure]\nevery = 8\n\
    [rods]\nnumber = 9\nedge = ['6 mm', '9 mm']\nweibull = 12.0\n[loads]\ndamping = 5.0\n\
    [[clamp]]\nto = 0.08\n[[clamp]]\nfrom = 0.87\nto = 0.93\naxes = 'yz'\n";

/// The scene with a clamp that is moved by so many metres across in each frame.
fn pulled(duration: f64, steps: &[f64]) -> Scene {
    let mut scene = Scene::read(HELD).unwrap();
    scene.duration = duration;
    let mut at = 0.0;
    let mut keys = vec![KeyFrame::default()];
    for (k, step) in steps.iter().enumerate() {
        at += step;
        keys.push(KeyFrame {
            time: (k + 1) as f64 / 20.0,
            move_by: [0.0, 0.0, at],
            ..KeyFrame::default()
        });
    }
    scene.clamp[1].key = keys;
    scene
}

/// A record that takes nothing more after a checkpoint with so many frames, and that may not be steered.
struct Halting {
    run: MemoryRun,
    frames: u64,
    takes_scenes: bool,
}

impl RunSink for Halting {
    fn begin(&mut self, scene: &Scene) -> Result<(), RunError> {
        self.run.begin(scene)
    }
    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.run.resume(progress)
    }
    fn steer(&mut self, scene: &Scene) -> Result<bool, RunError> {
        match self.takes_scenes {
            true => self.run.steer(scene),
            false => Ok(false),
        }
    }
    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.run.energy(row)
    }
    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.run.event(event)
    }
    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.run.force(row)
    }
    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        RunSink::frame(&mut self.run, frame)
    }
    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError> {
        let frames = checkpoint.progress.frames;
        self.run.save(checkpoint)?;
        match frames < self.frames {
            true => Ok(()),
            false => Err(RunError::Other("it halts here".into())),
        }
    }
}

impl RunSource for Halting {
    fn name(&self) -> String {
        self.run.name()
    }
    fn scene(&self) -> Result<Scene, RunError> {
        self.run.scene()
    }
    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        self.run.checkpoint()
    }
    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        self.run.energies()
    }
    fn events(&self) -> Result<Vec<Event>, RunError> {
        self.run.events()
    }
    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        self.run.forces()
    }
    fn frames(&self) -> Result<FrameTimes, RunError> {
        self.run.frames()
    }
    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        RunSource::frame(&self.run, number)
    }
}

fn request(scene: Scene, resume: bool) -> SimulateRequest {
    SimulateRequest {
        scene,
        resume,
        ..SimulateRequest::default()
    }
}

/// A run of a scene that was halted when it had so many frames.
fn halted(scene: &Scene, frames: u64, takes_scenes: bool) -> Halting {
    let run = MemoryRun::new();
    let mut halting = Halting {
        run,
        frames,
        takes_scenes,
    };
    let stopped = simulate(
        &request(scene.clone(), false),
        &mut halting,
        &Context::quiet(),
    );
    assert!(matches!(
        stopped,
        Err(SimulateError::Run(RunError::Other(_)))
    ));
    assert_eq!(halting.run.frames().unwrap().count() as u64, frames);
    halting.frames = u64::MAX;
    halting
}

#[test]
fn a_run_that_is_steered_ends_as_one_that_was_begun_so() {
    let first = pulled(0.4, &[0.008; 8]);
    // From the fifth key frame on it goes back, and longer: the time of the fourth frame may be that of its key frame, or rounded up.
    let mut steps = vec![0.008; 4];
    steps.extend([-0.02; 6]);
    let next = pulled(0.5, &steps);
    let mut steered = halted(&first, 4, true);
    let report = simulate(
        &request(next.clone(), true),
        &mut steered,
        &Context::quiet(),
    )
    .unwrap();
    let mut begun = MemoryRun::new();
    let expected = simulate(&request(next, false), &mut begun, &Context::quiet()).unwrap();
    assert!(expected.broke[0] > 0, "{expected}");
    assert_eq!(report.to_string(), expected.to_string());
    let run = steered.run;
    assert_eq!(run.scene().unwrap(), begun.scene().unwrap());
    assert_eq!(run.energies().unwrap(), begun.energies().unwrap());
    assert_eq!(run.events().unwrap(), begun.events().unwrap());
    assert_eq!(run.forces().unwrap(), begun.forces().unwrap());
    assert_eq!(run.checkpoint().unwrap(), begun.checkpoint().unwrap());
    for number in 0..11 {
        let frames = [&run, &begun].map(|run| RunSource::frame(run, number).unwrap());
        assert!(frames[0] == frames[1], "frame {number}");
    }
}

#[test]
fn what_has_been_cannot_be_steered() {
    let first = pulled(0.4, &[0.008; 8]);
    let go_on = |halting: &mut Halting, scene: Scene| {
        let outcome = simulate(&request(scene, true), halting, &Context::quiet());
        matches!(outcome, Err(SimulateError::OtherRun { .. }))
    };
    let mut steps = vec![0.008; 8];
    steps[2] = 0.0;
    let mut halting = halted(&first, 4, true);
    assert!(go_on(&mut halting, pulled(0.4, &steps)), "an earlier frame");
    let mut other = first.clone();
    other.loads.damping = 4.0;
    assert!(go_on(&mut halting, other), "other loads");
    steps = vec![0.008; 8];
    steps[5] = 0.0;
    let mut halting = halted(&first, 4, false);
    assert!(
        go_on(&mut halting, pulled(0.4, &steps)),
        "a record that takes no other scene"
    );
}
