//! Simulation: scenes that move until wood breaks, frame by frame.

use crate::arrays;
use crate::convert::report;
use crate::failure::Failure;
use crate::scene::Scene;
use crate::values::each;
use crate::work;
use greenstick::ErrorKind;
use greenstick::fibre::Event;
use greenstick::fibre::scene::{Scene as Setting, SceneError, StemChoice};
use greenstick::fibre::store::{
    Checkpoint, EnergyRow, ForceRow, Frame as Recorded, FrameTimes, Progress,
};
use greenstick::files::read_text;
use greenstick::schema::Parameters;
use greenstick::simulate::{
    MemoryRun, RunError, RunSink, RunSource, SceneMeshes, SimulateError, SimulateRequest,
    simulate as run_scene,
};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
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
}

/// A run in memory.
#[pyclass(module = "greenstick", frozen)]
pub struct Run {
    run: MemoryRun,
    /// The report as the program prints it with `--json`.
    #[pyo3(get)]
    report: Py<PyAny>,
}

#[pymethods]
impl Run {
    /// Times of the frames, s.
    #[getter]
    fn times(&self) -> PyResult<Vec<f64>> {
        Ok(self.run.frames().map_err(Failure::from)?.times)
    }

    /// A frame by its number from 0. Its memory is that of the run.
    fn frame(&self, number: usize) -> PyResult<Frame> {
        Ok(Frame(self.run.frame(number).map_err(Failure::from)?))
    }

    /// What broke and when: dictionaries.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.run.events().map_err(Failure::from)?)
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.run.frames().map_err(Failure::from)?.count())
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<greenstick.Run {} frames>", self.__len__()?))
    }
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
    let mut setting = if scene.contains('\n') {
        Setting::read(scene).map_err(scene_failure)?
    } else if scene.ends_with(".toml") {
        let text = read_text(&PathBuf::from(scene)).map_err(Failure::from)?;
        Setting::read(&text).map_err(scene_failure)?
    } else {
        Setting::built_in(scene).map_err(scene_failure)?
    };
    each([settings, keys], |key, value| {
        Ok(Parameters::set(&mut setting, key, value)?)
    })?;
    if mesh.is_some() {
        setting.stem.kind = StemChoice::Input;
    }
    setting.check().map_err(scene_failure)?;
    let request = SimulateRequest {
        scene: setting,
        meshes: SceneMeshes {
            input: mesh.map(|mesh| (*mesh.scene).clone()),
            bodies: Vec::new(),
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
    Ok(Run {
        run,
        report: report(py, &found)?.unbind(),
    })
}
