//! Simulation: a stem filled with rods, moved by a solver, written as it runs.
//!
//! A run owns a folder: `scene.toml`, `energy.csv`, `events.csv`, `forces.csv`, `frames.gsf` and `checkpoint.bin`. Tables and
//! frames are only appended to, and the checkpoint, which is written beside its place and renamed, says how long they were
//! then. To resume is to cut them to that length and to go on, so that a run that was stopped anywhere ends in the same
//! bytes.

mod charts;
mod error;
mod growing;
mod origin;
mod prepare;
mod report;

pub(crate) use charts::causes;
pub use charts::{UP, energy_chart, frames, load_chart};
pub use error::SimulateError;
pub(crate) use growing::FRAME_FILE;
pub use origin::Origin;
pub(crate) use prepare::lay;
pub use prepare::{Grown, body_shapes, grow, scene_of};
pub use report::{EnergyDrift, SimulateReport};

use crate::files::{self, FileError, Output};
use greenstick_fibre::scene::{AssembledScene, Scene as Setting};
use greenstick_fibre::store::{
    Checkpoint, ENERGY_HEADER, EVENT_HEADER, EnergyRow, FORCE_HEADER, ForceRow, Frame, Progress,
    event_line, stagger_velocities, write_header,
};
use greenstick_geometry::{Context, Scene, Stage};
use growing::{ENERGIES, EVENTS, FORCES, FRAMES, Growing};
use prepare::prepare;
use report::{begin_report, finish_report};
use std::fs;
use std::path::{Path, PathBuf};

/// What is to be simulated, and where it goes.
#[derive(Debug, Clone)]
pub struct SimulateRequest {
    /// The scene.
    pub scene: Setting,
    /// Where the input and the mesh files of bodies are.
    pub origin: Origin,
    /// The folder that takes everything.
    pub folder: PathBuf,
    /// Whether to go on from the folder's checkpoint.
    pub resume: bool,
}

const CHECKPOINT: &str = "checkpoint.bin";

/// A run between two ticks.
struct Run<'a> {
    request: &'a SimulateRequest,
    made: AssembledScene,
    hash: u64,
    progress: Progress,
    growing: Growing,
    saved: f64,
}

impl Run<'_> {
    fn start(&mut self) -> Result<(), SimulateError> {
        let scene = Output {
            path: self.request.folder.join("scene.toml"),
            bytes: self.request.scene.to_toml().into_bytes(),
        };
        let (name, bytes) = self.request.origin.file();
        let origin = Output {
            path: self.request.folder.join(name),
            bytes,
        };
        files::write_all(&[scene, origin])?;
        self.growing.write(ENERGIES, ENERGY_HEADER.as_bytes())?;
        self.growing.write(EVENTS, EVENT_HEADER.as_bytes())?;
        self.growing.write(FORCES, FORCE_HEADER.as_bytes())?;
        let mut head = Vec::new();
        // Memory takes every byte.
        let _ = write_header(&mut head);
        self.growing.write(FRAMES, &head)?;
        self.record(true, 0.0)?;
        let lag = self.request.scene.solver.velocity_lag();
        if lag > 0.0 {
            let mut solver = self.request.scene.make_solver();
            let world = &mut self.made.world;
            let step =
                solver
                    .step(world, &Context::quiet())
                    .map_err(|error| SimulateError::Solver {
                        error,
                        checkpoint: 0.0,
                    })?;
            stagger_velocities(world, lag * step);
        }
        self.save()
    }

    /// Writes what belongs to the present time, at which velocities are those of `lag` seconds before.
    fn record(&mut self, frame: bool, lag: f64) -> Result<(), SimulateError> {
        let world = &mut self.made.world;
        for event in std::mem::take(&mut world.events) {
            self.growing.write(EVENTS, event_line(&event).as_bytes())?;
            self.progress.events += 1;
        }
        let row = EnergyRow::measure(world, &self.made.bodies, &self.progress.ledger, lag);
        self.growing.write(ENERGIES, row.line().as_bytes())?;
        let interval = 1.0 / self.request.scene.table_rate();
        for row in ForceRow::measure(world, &mut self.made.bodies, interval) {
            self.growing.write(FORCES, row.line().as_bytes())?;
        }
        if frame {
            let bodies: Vec<_> = self.made.bodies.iter().map(|b| b.1).collect();
            let mut bytes = Vec::new();
            let _ = Frame::capture(&world.bundle, &world.state, &bodies).write(&mut bytes);
            self.growing.write(FRAMES, &bytes)?;
            self.progress.frames += 1;
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), SimulateError> {
        self.growing.flush()?;
        self.progress.bytes = self.growing.bytes;
        let path = self.request.folder.join(CHECKPOINT);
        let point = Checkpoint {
            world: self.made.world.clone(),
            bodies: self.made.bodies.checkpoint(),
            progress: self.progress,
        };
        let bytes = point
            .to_bytes(self.hash)
            .map_err(|error| SimulateError::Store {
                path: path.clone(),
                error,
            })?;
        files::write_all(&[Output { path, bytes }])?;
        self.saved = self.made.world.state.time;
        Ok(())
    }

    fn restore(&mut self, point: Checkpoint) -> Result<(), SimulateError> {
        self.made.world = point.world;
        let world = &self.made.world;
        self.made
            .bodies
            .resume(&point.bodies, &world.bundle, &world.loads)?;
        self.progress = point.progress;
        self.saved = world.state.time;
        Ok(())
    }
}

/// The checkpoint in a folder, if it is one of the simulation `hash`.
fn checkpoint(folder: &Path, hash: u64) -> Result<Checkpoint, SimulateError> {
    let path = folder.join(CHECKPOINT);
    let bytes = fs::read(&path).map_err(|source| FileError::Unreadable {
        path: path.clone(),
        source,
    })?;
    let (point, of) = Checkpoint::from_bytes(&bytes).map_err(|error| SimulateError::Store {
        path: path.clone(),
        error,
    })?;
    if of == hash {
        Ok(point)
    } else {
        Err(SimulateError::OtherRun { path })
    }
}

/// Simulates a scene, on the mesh `input` where the scene is of one, and writes everything into the request's folder.
/// `energy.csv` and `events.csv` can be read while it runs.
///
/// # Errors
/// [`SimulateError`]. Whatever happens, the last checkpoint is kept and can be resumed from.
pub fn simulate(
    input: Option<&Scene>,
    request: &SimulateRequest,
    context: &Context,
) -> Result<SimulateReport, SimulateError> {
    let [preparing, moving] =
        context.split([(Stage::new("prepare"), 1.0), (Stage::new("simulate"), 20.0)]);
    let (made, scene, hash) = prepare(request, input, &preparing)?;
    let request = &SimulateRequest {
        scene,
        ..request.clone()
    };
    let folder = &request.folder;
    let taken = folder.join(CHECKPOINT).exists();
    if taken && !request.resume {
        return Err(SimulateError::Taken {
            folder: folder.clone(),
        });
    }
    if request.resume && !taken {
        return Err(SimulateError::NothingToResume {
            folder: folder.clone(),
        });
    }
    fs::create_dir_all(folder).map_err(|source| SimulateError::Unwritable {
        path: folder.clone(),
        source,
    })?;
    let mut report = begin_report(request, &made);
    // Of a run that is resumed nothing is cut before its checkpoint is known to be good.
    let point = if taken {
        Some(checkpoint(folder, hash)?)
    } else {
        None
    };
    let growing = Growing::open(folder, point.as_ref().map(|p| p.progress.bytes))?;
    let mut run = Run {
        request,
        made,
        hash,
        progress: Progress::default(),
        growing,
        saved: 0.0,
    };
    match point {
        Some(point) => run.restore(point)?,
        None => run.start()?,
    }
    advance(&mut run, &mut report, &moving)?;
    run.save()?;
    finish_report(&mut report, &run)?;
    Ok(report)
}

/// Moves the run on to its end.
fn advance(
    run: &mut Run,
    report: &mut SimulateReport,
    context: &Context,
) -> Result<(), SimulateError> {
    let scene = &run.request.scene;
    let mut solver = scene.make_solver();
    let rows = scene.table_rate();
    // What is shorter than a row of the tables lasts a row.
    let ticks = ((scene.duration * rows).round() as u64).max(u64::from(scene.duration > 0.0));
    let frame_of = |tick: u64| (tick as f64 * scene.frames_per_second / rows + 1e-9).floor() as u64;
    while run.progress.ticks < ticks {
        let done = run.progress.ticks as f64 / ticks as f64;
        if let Err(stop) = context.report(done) {
            run.save()?;
            return Err(stop.into());
        }
        let next = run.progress.ticks + 1;
        let left = next as f64 / rows - run.made.world.state.time;
        let moved = solver
            .advance(
                &mut run.made.world,
                &mut run.made.bodies,
                left.max(0.0),
                &context.item(run.progress.ticks as usize, ticks as usize),
            )
            .map_err(|error| SimulateError::Solver {
                error,
                checkpoint: run.saved,
            })?;
        run.progress.ledger.add(&moved);
        run.progress.ticks = next;
        report.step_s = moved.step;
        report.limit_s = moved.limit.is_finite().then_some(moved.limit);
        let frame = frame_of(next) > frame_of(next - 1);
        run.record(frame, scene.solver.velocity_lag() * moved.step)?;
        if frame {
            run.save()?;
        }
    }
    Ok(())
}
