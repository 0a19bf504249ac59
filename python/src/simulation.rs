//! Simulation: scenes that move until wood breaks, frame by frame.

use crate::arrays;
use crate::convert::{Reduced, columns, json, report};
use crate::failure::Failure;
use crate::films::{Asked, Film, Recording, Skin};
use crate::pickled::damaged;
use crate::pickled_run::{RunParts, frame_again, frame_bytes, report_again, run_again, run_parts};
use crate::scene::Scene;
use crate::values::each;
use crate::work;
use greenstick::ErrorKind;
use greenstick::fibre::Event;
use greenstick::fibre::scene::{BUILT_IN, Scene as Setting, SceneError, StemChoice};
use greenstick::fibre::store::{
    Checkpoint, EnergyRow, ForceRow, Frame as Recorded, FrameTimes, Progress, Record,
};
use greenstick::files;
use greenstick::files::run::{Origin, RunFolder, read_body_meshes};
use greenstick::formats::Reach;
use greenstick::geometry::Scene as Meshes;
use greenstick::schema::Parameters;
use greenstick::simulate::{
    MemoryRun, RunError, RunSink, RunSource, SceneMeshes, SimulateError, SimulateRequest,
    simulate as run_scene,
};
use greenstick_sweep::input::up_axis;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        Failure::new("SimulateError", error.kind(), error)
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        SimulateError::from(error).into()
    }
}

fn scene_failure(error: SceneError) -> Failure {
    Failure::new("ParameterError", ErrorKind::Request, error)
}

/// A frame of a simulation: where all rods are at a time. Its arrays look into its memory, and are read-only.
#[pyclass(module = "greenstick", frozen)]
pub struct Frame(Arc<Recorded>);

#[pymethods]
impl Frame {
    /// Time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// Steps taken.
    #[getter]
    fn step(&self) -> u64 {
        self.0.step
    }

    /// Positions of the vertices: shape (v, 3), float32, m.
    #[getter]
    fn positions<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let flat: &[f32] = bytemuck::cast_slice(&slf.get().0.position);
        arrays::view(slf.as_any(), flat, 3)
    }

    /// Per rod its first vertex, and at the end the number of vertices: shape (r + 1,), uint32.
    #[getter]
    fn rod_offsets<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let data = &slf.get().0.rod_offsets;
        arrays::view(slf.as_any(), data, 1)?.reshape([data.len()])
    }

    /// Diameters of the rods: shape (r,), float32, m.
    #[getter]
    fn diameters<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let data = &slf.get().0.diameter;
        arrays::view(slf.as_any(), data, 1)?.reshape([data.len()])
    }

    /// Per rod its rod in the unbroken bundle: shape (r,), uint32.
    #[getter]
    fn parents<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let data = &slf.get().0.parent;
        arrays::view(slf.as_any(), data, 1)?.reshape([data.len()])
    }

    /// Bonds: the vertex and the edge that each connects: shape (b, 2), uint32.
    #[getter]
    fn bonds<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let flat: &[u32] = bytemuck::cast_slice(&slf.get().0.bonds);
        arrays::view(slf.as_any(), flat, 2)
    }

    fn __repr__(&self) -> String {
        let rods = self.0.diameter.len();
        format!("<greenstick.Frame {} s, {rods} rods>", self.0.time)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (Bound<'py, PyBytes>,)> {
        let bytes = PyBytes::new(slf.py(), &frame_bytes(&slf.get().0));
        Ok((slf.get_type().getattr("_again")?, (bytes,)))
    }

    /// The frame of a pickle.
    #[staticmethod]
    fn _again(bytes: &[u8]) -> PyResult<Self> {
        Ok(Frame(Arc::new(frame_again(bytes)?)))
    }
}

/// A run: in memory as `simulate` made it, or in a folder as the program left it. It pickles with all that it recorded.
#[pyclass(module = "greenstick", frozen)]
pub struct Run {
    recording: Recording,
    /// The report as the program prints it with `--json`; None of a run that was read from a folder.
    #[pyo3(get)]
    report: Option<Py<PyAny>>,
    /// The same as JSON.
    report_text: Option<String>,
}

#[pymethods]
impl Run {
    /// The run in a folder, as the program's `simulate` leaves it. `mesh` is the mesh that it is of, in place of the file that it
    /// remembers.
    #[staticmethod]
    #[pyo3(signature = (folder, mesh=None))]
    fn read(py: Python<'_>, folder: PathBuf, mesh: Option<&Scene>) -> PyResult<Self> {
        let mesh = mesh.map(with_images);
        let recording = work::run(py, None, |_| {
            let origin = Origin::read(&folder)?;
            let input = match (mesh, origin.input_file()) {
                (Some(mesh), _) => Some(mesh),
                (None, Some((path, unit))) => {
                    let mut scene = files::read(&path, unit)?;
                    files::embed_images(&mut scene, &path);
                    Some(scene)
                }
                (None, None) => None,
            };
            let beside = origin.beside.clone();
            let run = RunFolder::new(&folder, origin);
            let scene = run.scene()?;
            // What it may read was decided when it was simulated.
            let bodies = read_body_meshes(&scene, &beside, Reach::Outside)?;
            Ok(Recording {
                source: Arc::new(run),
                meshes: SceneMeshes { input, bodies },
            })
        })?;
        Run::new(py, recording, None)
    }

    /// Times of the frames, s.
    #[getter]
    fn times(&self) -> PyResult<Vec<f64>> {
        let frames = self.recording.source.frames().map_err(Failure::from)?;
        Ok(frames.times)
    }

    /// A frame by its number from 0.
    fn frame(&self, number: usize) -> PyResult<Frame> {
        let frame = self.recording.source.frame(number);
        Ok(Frame(frame.map_err(Failure::from)?))
    }

    /// What broke and when: dictionaries.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.recording.source.events().map_err(Failure::from)?)
    }

    /// Energies over time: arrays of shape (n,), float64, whose names end with the unit. Copies.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.recording.source.energies().map_err(Failure::from)?;
        table(py, Record::Energies, rows.iter().map(EnergyRow::line))
    }

    /// Forces of clamps and bodies on the wood over time, and how far they have moved: arrays of shape (n,), whose names end with
    /// the unit. Copies.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.recording.source.forces().map_err(Failure::from)?;
        table(py, Record::Forces, rows.iter().map(ForceRow::line))
    }

    /// Makes the skin of a frame, counted from 0 or from −1 backwards: the mesh that was simulated, cut along the faces that the
    /// run decided, or the skin of the rods.
    ///
    /// Keys are those of the program's `skin`: `texture_size=512`, `no_bodies=True`, `slabs=0.4`. `faces` is "drawn", "rods" or
    /// None for those that show the run best. `field` colours the wood by "strain" or "damage".
    #[pyo3(signature = (frame=-1, settings=None, *, faces=None, field=None, progress=None, **keys))]
    pub fn skin<'py>(
        slf: &Bound<'py, Self>,
        frame: i64,
        settings: Option<&Bound<'py, PyDict>>,
        faces: Option<&str>,
        field: Option<&str>,
        progress: Option<&Bound<'py, PyAny>>,
        keys: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Skin> {
        let asked = Asked::new(faces, field, [settings, keys])?;
        let (recording, run) = (&slf.get().recording, slf.clone().into_any().unbind());
        work::run(slf.py(), progress, |context| {
            recording.skin(frame, (run, asked), context)
        })
    }

    /// Makes a film of all frames, or of `frames="30..60"`. Arguments are those of `skin`.
    #[pyo3(signature = (settings=None, *, faces=None, field=None, progress=None, **keys))]
    pub fn film<'py>(
        slf: &Bound<'py, Self>,
        settings: Option<&Bound<'py, PyDict>>,
        faces: Option<&str>,
        field: Option<&str>,
        progress: Option<&Bound<'py, PyAny>>,
        keys: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Film> {
        let asked = Asked::new(faces, field, [settings, keys])?;
        let (recording, run) = (&slf.get().recording, slf.clone().into_any().unbind());
        work::run(slf.py(), progress, |context| {
            recording.film((run, asked), context)
        })
    }

    fn __len__(&self) -> PyResult<usize> {
        let frames = self.recording.source.frames().map_err(Failure::from)?;
        Ok(frames.count())
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<greenstick.Run {} frames>", self.__len__()?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, RunParts<'py>> {
        let run = slf.get();
        let parts = run_parts(slf.py(), &run.recording, run.report_text.as_deref())?;
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The run of a pickle.
    #[staticmethod]
    fn _again(
        py: Python<'_>,
        head: &[u8],
        report: Option<&[u8]>,
        frames: Vec<Bound<'_, PyBytes>>,
        input: Option<Bound<'_, Scene>>,
        bodies: Vec<Option<Bound<'_, Scene>>>,
    ) -> PyResult<Self> {
        let report = report.map(report_again).transpose()?;
        Run::new(py, run_again(head, &frames, input, bodies)?, report)
    }
}

impl Run {
    fn new(py: Python<'_>, recording: Recording, report_text: Option<String>) -> PyResult<Self> {
        let report = report_text.as_deref().map(|text| {
            let value = serde_json::from_str(text).map_err(|e| damaged("a run", e))?;
            Ok::<_, PyErr>(json(py, &value)?.unbind())
        });
        Ok(Run {
            recording,
            report: report.transpose()?,
            report_text,
        })
    }
}

/// The meshes of a scene with the images that its file refers to.
fn with_images(scene: &Scene) -> Meshes {
    let mut meshes = (*scene.scene).clone();
    if let Some(path) = &scene.path {
        files::embed_images(&mut meshes, path);
    }
    meshes
}

/// The columns of a run's table.
fn table<'py>(
    py: Python<'py>,
    record: Record,
    lines: impl Iterator<Item = String>,
) -> PyResult<Bound<'py, PyAny>> {
    let header = String::from_utf8_lossy(&record.header()).into_owned();
    columns(py, &lines.fold(header, |text, line| text + &line))
}

/// A run in memory that sends its frames on.
struct Telling<'a> {
    run: MemoryRun,
    /// Who is told; nobody where there is no callback.
    frames: Option<&'a SyncSender<Arc<Recorded>>>,
}

impl RunSink for Telling<'_> {
    fn begin(&mut self, scene: &Setting) -> Result<(), RunError> {
        self.run.begin(scene)
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.run.resume(progress)
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

    fn frame(&mut self, frame: Recorded) -> Result<(), RunError> {
        RunSink::frame(&mut self.run, frame)?;
        if let Some(frames) = self.frames {
            let last = self.run.frames()?.count() - 1;
            // Nobody listens any more where the work was cancelled.
            let _ = frames.send(self.run.frame(last)?);
        }
        Ok(())
    }

    fn save(&mut self, checkpoint: Checkpoint) -> Result<(), RunError> {
        self.run.save(checkpoint)
    }
}

impl RunSource for Telling<'_> {
    fn name(&self) -> String {
        self.run.name()
    }

    fn scene(&self) -> Result<Setting, RunError> {
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

    fn frame(&self, number: usize) -> Result<Arc<Recorded>, RunError> {
        self.run.frame(number)
    }
}

/// The scenes that come with the library, each with one line about it.
#[pyfunction]
pub fn scenes(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let dictionary = PyDict::new(py);
    for built_in in BUILT_IN {
        let scene = built_in.scene().map_err(scene_failure)?;
        dictionary.set_item(built_in.name, scene.about)?;
    }
    Ok(dictionary)
}

/// Moves wood as bonded fibres until it breaks.
///
/// `scene` is a scene that comes with the library ("bend"), a scene file (.toml), or its text; keys change it (`duration=0.1`,
/// `settings={"wood.species": "white oak"}`). `mesh` is simulated in place of the scene's stem. `frame` is called with every
/// `Frame` as it is recorded; what it raises stops the run, as Ctrl-C does.
#[pyfunction]
#[pyo3(signature = (scene, mesh=None, settings=None, *, frame=None, progress=None, **keys))]
pub fn simulate(
    py: Python<'_>,
    scene: &str,
    mesh: Option<&Scene>,
    settings: Option<&Bound<'_, PyDict>>,
    frame: Option<Py<PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
    keys: Option<&Bound<'_, PyDict>>,
) -> PyResult<Run> {
    let mut beside = PathBuf::new();
    let mut setting = if scene.contains('\n') {
        Setting::read(scene).map_err(scene_failure)?
    } else if scene.ends_with(".toml") {
        let path = Path::new(scene);
        beside = path.parent().unwrap_or(&beside).to_owned();
        let text = files::read_text(path).map_err(Failure::from)?;
        let read = Setting::read(&text).map_err(scene_failure);
        read.map_err(|failure| failure.about(path))?
    } else {
        Setting::built_in(scene).map_err(scene_failure)?
    };
    each([settings, keys], |key, value| {
        Ok(Parameters::set(&mut setting, key, value)?)
    })?;
    if let Some(mesh) = mesh {
        setting.stem.kind = StemChoice::Input;
        let up = mesh.path.as_deref().and_then(up_axis);
        setting.stem.up = setting.stem.up.or(up);
    }
    setting.check().map_err(scene_failure)?;
    let bodies = read_body_meshes(&setting, &beside, Reach::Folder).map_err(Failure::from)?;
    let request = SimulateRequest {
        scene: setting,
        meshes: SceneMeshes {
            input: mesh.map(with_images),
            bodies,
        },
        resume: false,
    };
    let told = frame.is_some();
    let (run, found) = work::run_with_messages(
        py,
        progress,
        |context, frames| {
            let mut telling = Telling {
                run: MemoryRun::new(),
                frames: told.then_some(frames),
            };
            let found = run_scene(&request, &mut telling, context)?;
            Ok((telling.run, found))
        },
        |py, recorded| match &frame {
            Some(frame) => frame.call1(py, (Frame(recorded),)).map(drop),
            None => Ok(()),
        },
    )?;
    let recording = Recording {
        source: Arc::new(run),
        meshes: request.meshes,
    };
    let report = serde_json::to_string(&found).map_err(Failure::report)?;
    Run::new(py, recording, Some(report))
}
