//! The work of a simulation: running a scene, drawing its frames, and taking the break that it leaves. No threads, no files.

use super::engine::Failure;
use super::input::{Input, InputContent};
use super::recording::Recording;
use super::simulation::{Chart, Line, Outcome, Recorded, SceneEntry, Taken};
use greenstick::ErrorKind;
use greenstick::fibre::scene::{BUILT_IN, Scene as Setting, StemChoice, UpChoice};
use greenstick::fibre::simulate::{LoadCurves, energy_curves};
use greenstick::fibre::store::{Checkpoint, EnergyRow, ForceRow, Frame, FrameTimes, Progress};
use greenstick::fibre::{Event, EventKind};
use greenstick::files::encode;
use greenstick::film::{DrawnFilm, FilmError, film_of_faces, open_run};
use greenstick::formats::{Format, InputFormat, LengthUnit, read_content};
use greenstick::geometry::Context;
use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::simulate::{
    RunError, RunSink, RunSource, SceneMeshes, SimulateError, SimulateReport, SimulateRequest,
    simulate,
};
use greenstick::simulated_faces::{PartlyBroken, SimulatedFacesError, simulated_faces};
use greenstick::skin::film::{FilmOptions, FilmParameters, Run, shows_well};
use greenstick::wood::primitive::BranchOptions;
use greenstick::wood::stem::StemLocation;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// The scenes that come with the program.
pub fn scenes() -> Vec<SceneEntry> {
    let entry = |built_in: &greenstick::fibre::scene::BuiltIn| {
        let scene = built_in.scene().ok()?;
        Some(SceneEntry {
            name: built_in.name.to_owned(),
            about: scene.about,
            duration: scene.duration,
        })
    };
    BUILT_IN.iter().filter_map(entry).collect()
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        Failure {
            cancelled: error.kind() == ErrorKind::Cancelled,
            ..Failure::new(error)
        }
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        Failure {
            cancelled: error.kind() == ErrorKind::Cancelled,
            ..Failure::new(error)
        }
    }
}

impl From<SimulatedFacesError> for Failure {
    fn from(error: SimulatedFacesError) -> Self {
        Failure {
            cancelled: error.kind() == ErrorKind::Cancelled,
            ..Failure::new(error)
        }
    }
}

/// Puts a scene on a stem, at a place. Returns the meshes with the stem; none of the built-in branch, which has no file and which
/// scenes make themselves, nor where the meshes are elsewhere.
///
/// # Errors
/// Where the stem is that of a scan, whose bark is still to be laid.
pub fn put_on(
    setting: &mut Setting,
    input: &Input,
    place: StemLocation,
) -> Result<Option<greenstick::geometry::Scene>, Failure> {
    if input.is_built_in() {
        let branch = BranchOptions::default();
        setting.stem.kind = StemChoice::Branch;
        (setting.stem.length, setting.stem.diameter) = (branch.length, branch.diameter);
        return Ok(None);
    }
    let scene = match &*input.content {
        InputContent::Mesh(scene) => Some(scene.clone()),
        InputContent::Elsewhere(seen) if seen.unbroken.is_some() => None,
        _ => {
            return Err(Failure::new(format!(
                "{}: a scan has no bark yet that could be simulated; export its bark as a mesh, and open that",
                input.title()
            )));
        }
    };
    (setting.stem.kind, setting.stem.at) = (StemChoice::Input, place);
    if let Some(format) = (input.path.as_deref()).and_then(|p| InputFormat::from_path(Path::new(p)))
    {
        let up = if format.is_z_up() {
            UpChoice::Z
        } else {
            UpChoice::Y
        };
        setting.stem.up = setting.stem.up.or(Some(up));
    }
    Ok(scene)
}

/// What a run is to do after a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// To go on.
    GoOn,
    /// To stop, as the hand is to pull elsewhere: so many parts of the stem's length along the axes of the scene.
    Steer([f64; 3]),
    /// To stop until it is gone on with.
    Rest,
}

/// What a run tells, and asks.
pub struct Listener<'a> {
    /// Is told of each frame.
    pub tell: &'a (dyn Fn(&dyn RunSource) + Sync),
    /// Is asked when a frame can be gone on from.
    pub ask: &'a (dyn Fn() -> Wish + Sync),
}

/// How a run came to an end.
pub enum Ended {
    /// It is over.
    Over(Outcome),
    /// The hand is to pull elsewhere from its last frame on.
    Steered([f64; 3]),
    /// It rests after its last frame.
    Resting,
}

/// Records a run and tells of each frame.
struct Telling<'a> {
    recording: Recording,
    listener: &'a Listener<'a>,
    /// Frames after which the run was asked whether to go on.
    asked: u64,
    /// What it was told last.
    wish: Wish,
}

impl RunSink for Telling<'_> {
    fn begin(&mut self, scene: &Setting) -> Result<(), RunError> {
        self.recording.begin(scene)
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.recording.resume(progress)
    }

    fn steer(&mut self, scene: &Setting) -> Result<bool, RunError> {
        self.recording.steer(scene)
    }

    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.recording.energy(row)
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.recording.event(event)
    }

    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.recording.force(row)
    }

    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        RunSink::frame(&mut self.recording, frame)?;
        (self.listener.tell)(&self.recording);
        Ok(())
    }

    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError> {
        let frames = checkpoint.progress.frames;
        self.recording.save(checkpoint)?;
        // Only a frame is stopped at: else there would be more stops than steps.
        if frames > self.asked {
            self.asked = frames;
            self.wish = (self.listener.ask)();
        }
        match self.wish {
            Wish::GoOn => Ok(()),
            Wish::Steer(_) => Err(RunError::Other("the hand is steered elsewhere".into())),
            Wish::Rest => Err(RunError::Other("the run rests".into())),
        }
    }
}

impl RunSource for Telling<'_> {
    fn name(&self) -> String {
        self.recording.name()
    }

    fn scene(&self) -> Result<Setting, RunError> {
        self.recording.scene()
    }

    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        self.recording.checkpoint()
    }

    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        self.recording.energies()
    }

    fn events(&self) -> Result<Vec<Event>, RunError> {
        self.recording.events()
    }

    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        self.recording.forces()
    }

    fn frames(&self) -> Result<FrameTimes, RunError> {
        self.recording.frames()
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        RunSource::frame(&self.recording, number)
    }
}

/// Runs a scene into `recording`, or goes on with the run that is there. What it stops for can be gone on from.
///
/// # Errors
/// What is wrong with the scene, or that it was cancelled; what was recorded until then stays.
pub fn run(
    (setting, meshes): (Setting, SceneMeshes),
    recording: &Recording,
    listener: &Listener,
    context: &Context,
) -> Result<Ended, Failure> {
    setting.check().map_err(Failure::new)?;
    let frames = recording.frames().map_or(0, |f| f.count() as u64);
    let request = SimulateRequest {
        scene: setting,
        meshes,
        resume: frames > 0,
    };
    let mut telling = Telling {
        recording: recording.clone(),
        listener,
        asked: frames,
        wish: Wish::GoOn,
    };
    let simulated = simulate(&request, &mut telling, context);
    match (simulated, telling.wish) {
        (Err(_), Wish::Steer(by)) => Ok(Ended::Steered(by)),
        (Err(_), Wish::Rest) => Ok(Ended::Resting),
        (report, _) => Ok(Ended::Over(outcome(&report?))),
    }
}

/// Time of the frame that a run goes on from, s.
pub fn time_of(recording: &Recording) -> f64 {
    let checkpoint = recording.checkpoint().ok().flatten();
    checkpoint.map_or(0.0, |c| c.world.state.time)
}

/// What the window says of a report.
fn outcome(report: &SimulateReport) -> Outcome {
    let mut facts = Vec::new();
    let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
    if let Some(outcome) = &report.outcome {
        fact("Mode", outcome.mode.description().to_owned());
        if outcome.greatest_load_n > 0.0 {
            fact("Greatest load", format!("{:.1} N", outcome.greatest_load_n));
        }
        if outcome.greatest_moment_nm > 0.0 {
            fact(
                "Greatest moment",
                format!("{:.2} N m", outcome.greatest_moment_nm),
            );
        }
        let shares: Vec<String> = (outcome.pieces.iter())
            .map(|p| format!("{:.0} %", 100.0 * p.share))
            .collect();
        let pieces = format!("{}: {}", outcome.pieces.len(), shares.join(", "));
        fact("Pieces", pieces);
        if outcome.splinters > 0 {
            let share = 100.0 * outcome.splinter_share;
            fact(
                "Splinters",
                format!("{} of {share:.1} %", outcome.splinters),
            );
        }
        if let Some(place) = outcome.place_m {
            fact("Broke at", format!("{place:.3} m from the base"));
        }
    }
    // A rod may break in several places.
    let [breaks, _, bonds] = report.broke;
    let broken = report.outcome.as_ref().map_or(0, |o| o.rods_broken);
    fact("Broken rods", format!("{broken} of {}", report.rods));
    fact("Broken bonds", format!("{bonds} of {}", report.bonds));
    if let Some(time) = report.first_break_s {
        fact("First break", format!("{time:.3} s"));
    }
    if let Some(buckling) = &report.buckling {
        fact("Buckling", buckling.to_string());
    }
    Outcome {
        facts,
        report: report.to_string(),
        broke: breaks + bonds > 0,
    }
}

/// What the window says of a run whose report is no more: what its tables hold.
///
/// # Errors
/// Where it cannot be read.
pub fn recorded_outcome(source: &dyn RunSource) -> Result<Outcome, Failure> {
    let (events, forces) = (source.events(), source.forces());
    let events = events.map_err(SimulateError::from)?;
    let forces = forces.map_err(SimulateError::from)?;
    let of = |kind| events.iter().filter(move |e| e.kind == kind);
    // A rod may break in several places, a bond once.
    let rods: BTreeSet<u32> = of(EventKind::RodBroke).map(|e| e.rod).collect();
    let (rods, bonds) = (rods.len(), of(EventKind::BondBroke).count());
    let greatest = |of: fn(&ForceRow) -> f64| forces.iter().map(of).fold(0.0, f64::max);
    let [force, moment] = [
        greatest(|r| r.force.length()),
        greatest(|r| r.moment.length()),
    ];
    let mut facts = vec![
        ("Broken rods".to_owned(), rods.to_string()),
        ("Broken bonds".to_owned(), bonds.to_string()),
    ];
    for (name, value, unit) in [
        ("Greatest load", force, "N"),
        ("Greatest moment", moment, "N m"),
    ] {
        if value > 0.0 {
            facts.push((name.to_owned(), format!("{value:.2} {unit}")));
        }
    }
    Ok(Outcome {
        facts,
        report: String::new(),
        broke: rods + bonds > 0,
    })
}

/// What is recorded so far.
pub fn recorded(source: &dyn RunSource) -> Recorded {
    let line = |curve: greenstick::fibre::Curve| Line {
        name: curve.name,
        points: curve.points,
    };
    let load = LoadCurves::from_rows(&source.forces().unwrap_or_default());
    let energies = energy_curves(&source.energies().unwrap_or_default());
    Recorded {
        times: source.frames().map(|f| f.times).unwrap_or_default(),
        load: Chart {
            axes: load.axes.map(str::to_owned),
            lines: load.curves.into_iter().map(line).collect(),
        },
        energy: Chart {
            axes: ["time (s)", "energy (J)"].map(str::to_owned),
            lines: energies.into_iter().map(line).collect(),
        },
    }
}

/// A run that ended, as the break that it left is taken from it.
pub struct EndedRun {
    run: Run,
    /// The stem that it is of; none where it is that of its scene.
    stem: Option<RunStem>,
}

/// The stem of a run, and the unit of length in its file, where one was named.
pub type RunStem = (Input, Option<LengthUnit>);

impl EndedRun {
    /// Opens a run that ended.
    ///
    /// # Errors
    /// Where it has no frames, or is of other meshes.
    pub fn open(
        source: Arc<dyn RunSource>,
        meshes: &SceneMeshes,
        stem: Option<RunStem>,
        context: &Context,
    ) -> Result<Self, Failure> {
        // The window shows the scene's axes.
        let run = open_run(source, meshes, context)?.along_x();
        Ok(EndedRun { run, stem })
    }

    /// Cuts its wood along the faces that its end decided; also returns whether that shows the run better than its rods.
    ///
    /// # Errors
    /// Why there are no such faces.
    pub fn film(&mut self, context: &Context) -> Result<(DrawnFilm, bool), Failure> {
        let options = FilmOptions {
            texture_width: 0,
            ..FilmParameters::default().film_options(self.run.scene.seed)
        };
        let all = 0..self.run.frames();
        let mut film = film_of_faces(&mut self.run, all, &options, context)?;
        let in_two = film.reports.iter().any(|report| report.parted);
        let best = shows_well(film.misplaced_share(&self.run)?, in_two);
        Ok((film, best))
    }

    /// Takes the break that its end left.
    ///
    /// # Errors
    /// That the wood holds, or cannot be cut where it broke.
    pub fn take(&self, at_hand: Option<u64>, context: &Context) -> Result<Taken, Failure> {
        let last = self.run.frames().saturating_sub(1);
        let faces = simulated_faces(&self.run, last, PartlyBroken::Separated, context)?;
        let (input, unit) = match &self.stem {
            Some((stem, _)) if at_hand == Some(stem.id) => (None, None),
            Some((stem, unit)) => (Some(stem.clone()), *unit),
            None => (Some(self.own_stem()?), None),
        };
        Ok(Taken {
            request: faces.request,
            input,
            unit,
        })
    }

    /// The stem that the scene made, as the file that a project will keep it in has it.
    fn own_stem(&self) -> Result<Input, Failure> {
        let name = Path::new("stem.glb");
        let mut scene = self.run.input().clone();
        // Built-in stems split their triangles by materials that no scene lists.
        let listed = scene.materials.len();
        for node in &mut scene.nodes {
            let unlisted = Arc::make_mut(&mut node.mesh).materials.iter_mut();
            unlisted
                .filter(|m| **m as usize >= listed)
                .for_each(|m| *m = NO_MATERIAL);
        }
        let written = encode(&scene, name, LengthUnit::Metre).map_err(Failure::new)?;
        let file = written.into_iter().next();
        let bytes = file.map(|f| f.bytes).unwrap_or_default();
        let none = |_: &str| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
        let format = InputFormat::Mesh(Format::Glb);
        let content = read_content(format, &bytes, "stem.glb", None, &none);
        Ok(Input::made(content.map_err(Failure::new)?, bytes))
    }
}
