//! The run: ticks of the tables, frames, and checkpoints.

use super::error::SimulateError;
use super::meshes::SceneMeshes;
use super::prepare::{PreparedScene, prepare};
use super::report::{Buckled, SimulateReport, begin_report, finish_report};
use super::steered::is_steered;
use crate::error::SolverError;
use crate::event::EventKind;
use crate::outcome::WoodAtStart;
use crate::scene::{AssembledScene, Scene};
use crate::solvers::{AdvanceReport, Solver};
use crate::store::{
    Checkpoint, EnergyRow, ForceRow, Frame, Progress, RunError, RunStore, stagger_velocities,
};
use greenstick_geometry::{Context, Stage};

/// Ticks for which a film stays slow after the last one in which a rod breaks.
const CALM_TICKS: u64 = 2;

/// What to simulate.
#[derive(Debug, Clone, Default)]
pub struct SimulateRequest {
    /// The scene.
    pub scene: Scene,
    /// The meshes that it names.
    pub meshes: SceneMeshes,
    /// Whether to continue from the checkpoint of the run instead of beginning it. The scene may then last longer, and its clamps
    /// may have other key frames from the checkpoint on, where the run's record takes that ([`RunSink::steer`](crate::store::RunSink::steer)).
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
        self.restore(checkpoint)?;
        self.saved = self.assembled.world.state.time;
        Ok(())
    }

    /// Goes back to a checkpoint after which nothing was recorded. Clamps move as the scene says: after the checkpoint that may be
    /// otherwise than the scene said before.
    fn restore(&mut self, checkpoint: Checkpoint) -> Result<(), SimulateError> {
        let assembled = &mut self.assembled;
        let before = std::mem::replace(&mut assembled.world, checkpoint.world);
        let world = &mut assembled.world;
        for (clamp, own) in world.loads.clamps.iter_mut().zip(before.loads.clamps) {
            clamp.motion = own.motion;
        }
        (assembled.bodies).resume(&checkpoint.bodies, &world.bundle, &world.loads)?;
        self.progress = checkpoint.progress;
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

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            world: self.assembled.world.clone(),
            bodies: self.assembled.bodies.checkpoint(),
            progress: self.progress,
            hash: self.hash,
        }
    }

    fn save(&mut self) -> Result<(), SimulateError> {
        self.store.save(self.checkpoint())?;
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
        while self.progress.ticks < ticks && self.progress.buckling.is_none() {
            let tick = self.progress.ticks + 1;
            let item = context.item(self.progress.ticks as usize, ticks as usize);
            if scene.slow > 1.0 && tick <= self.progress.slow_until {
                self.slow_tick(&mut *solver, tick, report, &item)?;
                continue;
            }
            // Whether rods break in a tick is known when it is over.
            let before = (scene.slow > 1.0).then(|| self.checkpoint());
            let left = tick as f64 / rows - self.assembled.world.state.time;
            let advanced = self.tick(&mut *solver, left.max(0.0), &item)?;
            if let Some(before) = before
                && self.has_broken()
            {
                self.restore(before)?;
                solver = scene.make_solver();
                self.slow_tick(&mut *solver, tick, report, &item)?;
                continue;
            }
            self.progress.ticks = tick;
            self.complete(&advanced, frame_of(tick) > frame_of(tick - 1), report)?;
        }
        Ok(())
    }

    /// Records what a solver has advanced by.
    fn complete(
        &mut self,
        advanced: &AdvanceReport,
        frame: bool,
        report: &mut SimulateReport,
    ) -> Result<(), SimulateError> {
        self.progress.ledger.add(advanced);
        self.progress.buckling = advanced.buckling;
        let frame = frame || advanced.buckling.is_some();
        report.step_s = advanced.step;
        report.limit_s = advanced.limit.is_finite().then_some(advanced.limit);
        self.record(frame, self.scene.solver.velocity_lag() * advanced.step)?;
        if frame {
            self.save()?;
        }
        Ok(())
    }

    /// Advances by a tick in slow motion: in as many frames as that takes. Stays slow for some ticks after the last in which
    /// rods break.
    fn slow_tick(
        &mut self,
        solver: &mut dyn Solver,
        tick: u64,
        report: &mut SimulateReport,
        context: &Context,
    ) -> Result<(), SimulateError> {
        let rows = self.scene.table_rate();
        let per_tick = self.scene.frames_per_second * self.scene.slow / rows;
        let parts = per_tick.round().max(1.0) as u64;
        let frame_of = |tick: u64| (tick as f64 * per_tick + 1e-9).floor() as u64;
        let frame = parts > 1 || frame_of(tick) > frame_of(tick - 1);
        self.progress.slow_until = tick.max(self.progress.slow_until);
        for part in 1..=parts {
            let end = ((tick - 1) as f64 + part as f64 / parts as f64) / rows;
            let left = end - self.assembled.world.state.time;
            // A run that is resumed may have some of the parts behind it.
            if left < 0.5 / (rows * parts as f64) {
                continue;
            }
            let item = context.item(part as usize - 1, parts as usize);
            let advanced = self.tick(solver, left, &item)?;
            if self.has_broken() {
                self.progress.slow_until = tick + CALM_TICKS;
            }
            if part == parts {
                self.progress.ticks = tick;
            }
            self.complete(&advanced, frame, report)?;
            if advanced.buckling.is_some() {
                break;
            }
        }
        self.progress.ticks = tick;
        Ok(())
    }

    /// Whether a rod has broken since the last record.
    fn has_broken(&self) -> bool {
        let mut events = self.assembled.world.events.iter();
        events.any(|e| e.kind == EventKind::RodBroke)
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
    if let Some(checkpoint) = checkpoint.as_ref().filter(|c| c.hash != hash) {
        let is_steered = is_steered(checkpoint, &store.scene()?, &scene, &assembled);
        if !(is_steered && store.steer(&scene)?) {
            return Err(SimulateError::OtherRun { run: store.name() });
        }
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
    let AssembledScene {
        fraction, length, ..
    } = &run.assembled;
    report.buckling = (run.progress.buckling.as_ref()).map(|b| Buckled::new(b, fraction, *length));
    finish_report(
        &mut report,
        (&start, &run.assembled.world),
        run.progress.frames,
        run.store,
    )?;
    Ok(report)
}
