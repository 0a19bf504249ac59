//! The run: ticks of the tables, frames, and checkpoints.

use super::error::SimulateError;
use super::meshes::SceneMeshes;
use super::prepare::{PreparedScene, prepare};
use super::report::{SimulateReport, begin_report, finish_report};
use crate::error::SolverError;
use crate::outcome::WoodAtStart;
use crate::scene::{AssembledScene, Scene};
use crate::solvers::{AdvanceReport, Solver};
use crate::store::{
    Checkpoint, EnergyRow, ForceRow, Frame, Progress, RunError, RunStore, stagger_velocities,
};
use greenstick_geometry::{Context, Stage};

/// What to simulate.
#[derive(Debug, Clone, Default)]
pub struct SimulateRequest {
    /// The scene.
    pub scene: Scene,
    /// The meshes that it names.
    pub meshes: SceneMeshes,
    /// Whether to continue from the checkpoint of the run instead of beginning it.
    pub resume: bool,
}

/// A run between two ticks.
struct Run<'a> {
    scene: &'a Scene,
    assembled: AssembledScene,
    hash: u64,
    progress: Progress,
    store: &'a mut dyn RunStore,
    /// Time of the last checkpoint, s.
    saved: f64,
}

impl Run<'_> {
    fn begin(&mut self, context: &Context) -> Result<(), SimulateError> {
        self.store.begin(self.scene)?;
        self.record(true, 0.0)?;
        let lag = self.scene.solver.velocity_lag();
        if lag > 0.0 {
            let world = &mut self.assembled.world;
            let step = self.scene.make_solver().step(world, context);
            let step = step.map_err(|error| stopped(error, 0.0))?;
            stagger_velocities(world, lag * step);
        }
        self.save()
    }

    fn resume(&mut self, checkpoint: Checkpoint) -> Result<(), SimulateError> {
        self.store.resume(&checkpoint.progress)?;
        let assembled = &mut self.assembled;
        assembled.world = checkpoint.world;
        let world = &assembled.world;
        (assembled.bodies).resume(&checkpoint.bodies, &world.bundle, &world.loads)?;
        self.progress = checkpoint.progress;
        self.saved = world.state.time;
        Ok(())
    }

    /// Records what belongs to the present time, at which velocities are those of `lag` seconds before.
    fn record(&mut self, frame: bool, lag: f64) -> Result<(), SimulateError> {
        let AssembledScene { world, bodies, .. } = &mut self.assembled;
        for event in std::mem::take(&mut world.events) {
            self.store.event(&event)?;
            self.progress.events += 1;
        }
        let row = EnergyRow::measure(world, bodies, &self.progress.ledger, lag);
        self.store.energy(&row)?;
        let interval = 1.0 / self.scene.table_rate();
        for row in ForceRow::take(world, bodies, interval) {
            self.store.force(&row)?;
        }
        if frame {
            let states: Vec<_> = bodies.iter().map(|b| b.1).collect();
            let frame = Frame::capture(&world.bundle, &world.state, &states);
            self.store.frame(frame)?;
            self.progress.frames += 1;
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), SimulateError> {
        self.store.save(Checkpoint {
            world: self.assembled.world.clone(),
            bodies: self.assembled.bodies.checkpoint(),
            progress: self.progress,
            hash: self.hash,
        })?;
        self.saved = self.assembled.world.state.time;
        Ok(())
    }

    /// Continues the run to its end.
    fn advance(
        &mut self,
        report: &mut SimulateReport,
        context: &Context,
    ) -> Result<(), SimulateError> {
        let scene = self.scene;
        let mut solver = scene.make_solver();
        let rows = scene.table_rate();
        // What is shorter than a row of the tables lasts a row.
        let ticks = ((scene.duration * rows).round() as u64).max(u64::from(scene.duration > 0.0));
        let frame_of =
            |tick: u64| (tick as f64 * scene.frames_per_second / rows + 1e-9).floor() as u64;
        while self.progress.ticks < ticks {
            let tick = self.progress.ticks + 1;
            let left = tick as f64 / rows - self.assembled.world.state.time;
            let item = context.item(self.progress.ticks as usize, ticks as usize);
            let advanced = self.tick(&mut *solver, left.max(0.0), &item)?;
            self.progress.ledger.add(&advanced);
            self.progress.ticks = tick;
            report.step_s = advanced.step;
            report.limit_s = advanced.limit.is_finite().then_some(advanced.limit);
            let frame = frame_of(tick) > frame_of(tick - 1);
            self.record(frame, scene.solver.velocity_lag() * advanced.step)?;
            if frame {
                self.save()?;
            }
        }
        Ok(())
    }

    /// Advances by a tick of `duration` seconds. Where the caller stops it before its first step is complete, the state is
    /// that between two ticks and is saved; later than that a resumed run would take other steps, so that the last
    /// checkpoint remains.
    fn tick(
        &mut self,
        solver: &mut dyn Solver,
        duration: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SimulateError> {
        let AssembledScene { world, bodies, .. } = &mut self.assembled;
        let step = world.state.step;
        let advanced = match context.report(0.0) {
            Ok(()) => solver.advance(world, bodies, duration, context),
            Err(stop) => Err(stop.into()),
        };
        if matches!(advanced, Err(SolverError::Cancelled(_))) && world.state.step == step {
            self.save()?;
        }
        advanced.map_err(|error| stopped(error, self.saved))
    }
}

fn stopped(error: SolverError, checkpoint: f64) -> SimulateError {
    match error {
        SolverError::Cancelled(stop) => stop.into(),
        error => SimulateError::Solver { error, checkpoint },
    }
}

/// Returns the checkpoint to resume from; `None` where a run is to begin.
fn checkpoint(
    request: &SimulateRequest,
    store: &dyn RunStore,
) -> Result<Option<Checkpoint>, SimulateError> {
    let run = store.name();
    match store.checkpoint() {
        Ok(None) if request.resume => Err(SimulateError::NothingToResume { run }),
        Ok(Some(_)) | Err(RunError::Store { .. }) if !request.resume => {
            Err(SimulateError::Taken { run })
        }
        other => Ok(other?),
    }
}

/// Simulates a scene, and records everything in `store`. What is recorded can be read while it runs.
///
/// # Errors
/// [`SimulateError`]. Whatever happens, the last checkpoint is kept and can be resumed from.
pub fn simulate(
    request: &SimulateRequest,
    store: &mut dyn RunStore,
    context: &Context,
) -> Result<SimulateReport, SimulateError> {
    let [preparing, moving] =
        context.split([(Stage::new("prepare"), 1.0), (Stage::new("simulate"), 20.0)]);
    let checkpoint = checkpoint(request, store)?;
    let PreparedScene {
        assembled,
        scene,
        hash,
        wood,
        notes,
    } = prepare(&request.scene, &request.meshes, &preparing)?;
    // Nothing of a run is cut before its checkpoint is known to be good.
    if checkpoint.as_ref().is_some_and(|c| c.hash != hash) {
        return Err(SimulateError::OtherRun { run: store.name() });
    }
    let start = {
        let AssembledScene {
            world,
            fraction,
            length,
            ..
        } = &assembled;
        WoodAtStart::new(&world.bundle, fraction, *length)
    };
    let mut report = begin_report(&scene, &assembled, (wood, notes));
    let mut run = Run {
        scene: &scene,
        assembled,
        hash,
        progress: Progress::default(),
        store,
        saved: 0.0,
    };
    match checkpoint {
        Some(checkpoint) => run.resume(checkpoint)?,
        None => run.begin(&moving)?,
    }
    run.advance(&mut report, &moving)?;
    run.save()?;
    finish_report(
        &mut report,
        (&start, &run.assembled.world),
        run.progress.frames,
        run.store,
    )?;
    Ok(report)
}
