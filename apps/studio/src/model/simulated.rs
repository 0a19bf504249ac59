//! The work of a simulation: running a scene, drawing its frames, and taking the break that it leaves. No threads, no files.

use super::engine::Failure;
use super::input::{Input, InputContent};
use super::look::WoodLook;
use super::meshes::{DecodedImages, DrawnScene};
use super::simulation::{Chart, DrawnFrame, Line, Look, Outcome, Recorded, SceneEntry, Taken};
use glam::{DAffine3, DVec3, Vec3};
use greenstick::ErrorKind;
use greenstick::fibre::bodies::Shape;
use greenstick::fibre::scene::{BUILT_IN, Scene as Setting, StemChoice, UpChoice};
use greenstick::fibre::simulate::{LoadCurves, energy_curves};
use greenstick::fibre::store::{Checkpoint, EnergyRow, ForceRow, Frame, FrameTimes, Progress};
use greenstick::fibre::{Event, EventKind};
use greenstick::files::encode;
use greenstick::film::{DrawnFilm, FilmError, film_of_faces, open_run};
use greenstick::formats::{Format, InputFormat, LengthUnit, read_content};
use greenstick::geometry::Context;
use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::rods_scene;
use greenstick::simulate::{
    MemoryRun, RunError, RunSink, RunSource, SceneMeshes, SimulateError, SimulateReport,
    SimulateRequest, body_shapes, simulate,
};
use greenstick::simulated_faces::{PartlyBroken, SimulatedFacesError, simulated_faces};
use greenstick::skin::film::{FilmOptions, FilmParameters, Run};
use greenstick::wood::primitive::BranchOptions;
use greenstick::wood::stem::StemLocation;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Share of the wood that drawn faces may show out of place before rods show a run better.
const SPLIT_SHARE: f64 = 0.05;

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
/// scenes make themselves.
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
    let InputContent::Mesh(scene) = &*input.content else {
        return Err(Failure::new(format!(
            "{}: a scan has no bark yet that could be simulated; export its bark as a mesh, and open that",
            input.title()
        )));
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
    Ok(Some(scene.clone()))
}

/// A run that is recorded in memory, and read while it grows.
#[derive(Clone, Default)]
pub struct Recording(Arc<Mutex<MemoryRun>>);

impl Recording {
    fn run(&self) -> MutexGuard<'_, MemoryRun> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RunSource for Recording {
    fn name(&self) -> String {
        self.run().name()
    }

    fn scene(&self) -> Result<Setting, RunError> {
        self.run().scene()
    }

    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        self.run().checkpoint()
    }

    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        self.run().energies()
    }

    fn events(&self) -> Result<Vec<Event>, RunError> {
        self.run().events()
    }

    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        self.run().forces()
    }

    fn frames(&self) -> Result<FrameTimes, RunError> {
        self.run().frames()
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        self.run().frame(number)
    }
}

/// Records a run and tells of each frame.
struct Telling<'a> {
    recording: Recording,
    tell: &'a (dyn Fn(&dyn RunSource) + Sync),
}

impl RunSink for Telling<'_> {
    fn begin(&mut self, scene: &Setting) -> Result<(), RunError> {
        self.recording.run().begin(scene)
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.recording.run().resume(progress)
    }

    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.recording.run().energy(row)
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.recording.run().event(event)
    }

    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.recording.run().force(row)
    }

    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        RunSink::frame(&mut *self.recording.run(), frame)?;
        (self.tell)(&self.recording);
        Ok(())
    }

    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError> {
        self.recording.run().save(checkpoint)
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

/// Runs a scene into `recording`; `tell` is told of each frame as it is recorded.
///
/// # Errors
/// What is wrong with the scene, or that it was cancelled; what was recorded until then stays.
pub fn run(
    (setting, meshes): (Setting, SceneMeshes),
    recording: &Recording,
    tell: &(dyn Fn(&dyn RunSource) + Sync),
    context: &Context,
) -> Result<Outcome, Failure> {
    setting.check().map_err(Failure::new)?;
    let request = SimulateRequest {
        scene: setting,
        meshes,
        resume: false,
    };
    let mut telling = Telling {
        recording: recording.clone(),
        tell,
    };
    let report = simulate(&request, &mut telling, context)?;
    Ok(outcome(&report))
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

/// Draws frames of a run.
pub struct FrameArtist {
    source: Arc<dyn RunSource>,
    meshes: SceneMeshes,
    shapes: Option<Vec<Shape>>,
    /// The middle of the first frame, which all frames are drawn about, and its radius.
    rest: Option<(DVec3, f64)>,
    /// The axis of the stem there, about that middle.
    axis: Arc<Vec<Vec3>>,
    /// The wood, once it is cut.
    film: Option<(DrawnFilm, Vec<(u32, WoodLook)>)>,
    decoded: DecodedImages,
}

impl FrameArtist {
    /// One for a run, and the meshes that its scene names.
    pub fn new(source: Arc<dyn RunSource>, meshes: SceneMeshes) -> Self {
        FrameArtist {
            source,
            meshes,
            shapes: None,
            rest: None,
            axis: Arc::default(),
            film: None,
            decoded: DecodedImages::new(),
        }
    }

    /// Has it draw wood from now on.
    pub fn take_film(&mut self, film: DrawnFilm) {
        let woods = film.broken.woods.iter();
        let looks = woods.map(|w| (w.material, WoodLook::new(w))).collect();
        self.film = Some((film, looks));
    }

    /// Draws a frame; as rods where there is no wood. Files have y up, and so has the picture.
    ///
    /// # Errors
    /// Where the frame cannot be read.
    pub fn draw(&mut self, number: usize, look: Look) -> Result<DrawnFrame, Failure> {
        let (middle, rest_radius) = match self.rest {
            Some(rest) => rest,
            None => {
                let first = DrawnScene::unbroken(&self.rods(0)?);
                let frame = self.source.frame(0).map_err(SimulateError::from)?;
                let axis = axis(&frame).into_iter();
                let drawn = axis.map(|p| (upright().transform_point3(p) - first.middle).as_vec3());
                self.axis = Arc::new(drawn.collect());
                (first.middle, first.radius)
            }
        };
        self.rest = Some((middle, rest_radius));
        let axis = self.axis.clone();
        if let (Look::Wood, Some((film, looks))) = (look, &mut self.film) {
            let scene = film.skinned.at(number).map_err(FilmError::from)?;
            let scene = DrawnScene::moved(&scene, looks, middle, &mut self.decoded);
            return Ok(DrawnFrame {
                scene,
                rest_radius,
                axis,
            });
        }
        let rods = self.rods(number)?;
        let plain = &mut DecodedImages::new();
        let scene = DrawnScene::moved(&rods, &[], middle, plain);
        Ok(DrawnFrame {
            scene,
            rest_radius,
            axis,
        })
    }

    fn rods(&mut self, number: usize) -> Result<greenstick::geometry::Scene, Failure> {
        let frame = self.source.frame(number).map_err(SimulateError::from)?;
        let shapes = match &mut self.shapes {
            Some(shapes) => shapes,
            none => {
                let setting = self.source.scene().map_err(SimulateError::from)?;
                none.insert(body_shapes(&setting, &self.meshes)?)
            }
        };
        let mut scene = rods_scene(&frame, shapes);
        for node in &mut scene.nodes {
            node.transform = upright() * node.transform;
        }
        Ok(scene)
    }
}

/// Turns what has z up to have y up.
fn upright() -> DAffine3 {
    DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2)
}

/// Points along the axis of a stem, and the part of the longest rod's length from which on a rod runs along all of the stem.
const AXIS_POINTS: usize = 33;
const WHOLE: f64 = 0.95;

/// The axis of the stem of a frame in even steps: the middle of the rods that run along all of it.
fn axis(frame: &Frame) -> Vec<DVec3> {
    let point = |i: u32| DVec3::from(frame.position[i as usize].map(f64::from));
    let rods = frame.rod_offsets.windows(2).filter(|r| r[1] > r[0] + 1);
    let rods: Vec<Vec<DVec3>> = rods.map(|r| (r[0]..r[1]).map(point).collect()).collect();
    let length = |rod: &[DVec3]| rod.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
    let longest = rods.iter().map(|r| length(r)).fold(0.0, f64::max);
    let whole: Vec<_> = rods
        .iter()
        .filter(|r| length(r) >= WHOLE * longest)
        .collect();
    let at = |rod: &[DVec3], part: f64| {
        let mut left = part * length(rod);
        for pair in rod.windows(2) {
            let step = pair[0].distance(pair[1]);
            if left <= step && step > 0.0 {
                return pair[0].lerp(pair[1], left / step);
            }
            left -= step;
        }
        rod[rod.len() - 1]
    };
    if whole.is_empty() {
        return Vec::new();
    }
    let parts = (0..AXIS_POINTS).map(|k| k as f64 / (AXIS_POINTS - 1) as f64);
    let sum = |part: f64| whole.iter().map(|r| at(r, part)).sum::<DVec3>();
    parts.map(|part| sum(part) / whole.len() as f64).collect()
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
        let run = open_run(source, meshes, context)?;
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
        let best = film.misplaced_share(&self.run)? <= SPLIT_SHARE;
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
