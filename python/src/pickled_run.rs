//! Runs, and what is made of them, in pickles. A run pickles as all that was recorded, whether it is in memory or in a folder; a
//! skin or film as its run and what was asked of it.

use crate::convert::Reduced;
use crate::failure::Failure;
use crate::films::Recording;
use crate::scene::Scene;
use crate::simulation::Run;
use greenstick::fibre::scene::Scene as Setting;
use greenstick::fibre::store::{
    Checkpoint, EnergyRow, ForceRow, Frame, IndexedFrames, Record, RunError, event_line,
    parse_energies, parse_events, parse_forces,
};
use greenstick::simulate::{MemoryRun, RunSink, SceneMeshes};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::io::Cursor;
use std::sync::Arc;

/// What a pickle of a run holds: the scene and the tables as the files of a run have them, frames, the checkpoint, the mesh and
/// those of bodies, and the report.
pub type RunParts<'py> = (
    String,
    [String; 3],
    Bound<'py, PyBytes>,
    Option<Bound<'py, PyBytes>>,
    Option<Scene>,
    Vec<Option<Scene>>,
    Option<Py<PyAny>>,
);

/// Takes a recording apart.
pub fn run_parts<'py>(
    py: Python<'py>,
    recording: &Recording,
    report: Option<Py<PyAny>>,
) -> PyResult<RunParts<'py>> {
    let (source, meshes) = (&recording.source, &recording.meshes);
    let (text, tables, frames, checkpoint) = py
        .detach(|| {
            let text = source.scene()?.to_toml();
            let energies = source.energies()?.iter().map(EnergyRow::line).collect();
            let events = source.events()?.iter().map(event_line).collect();
            let forces = source.forces()?.iter().map(ForceRow::line).collect();
            let mut frames = Record::Frames.header();
            for number in 0..source.frames()?.count() {
                frames.extend(source.frame(number)?.to_bytes());
            }
            Ok::<_, RunError>((text, [energies, events, forces], frames, source.checkpoint()?))
        })
        .map_err(Failure::from)?;
    let checkpoint = checkpoint.map(|checkpoint| checkpoint.to_bytes());
    let checkpoint = checkpoint.transpose().map_err(damaged)?;
    let scene = |meshes: &Option<_>| Some(Scene::new(Clone::clone(meshes.as_ref()?), None));
    Ok((
        text,
        tables,
        PyBytes::new(py, &frames),
        checkpoint.map(|bytes| PyBytes::new(py, &bytes)),
        scene(&meshes.input),
        meshes.bodies.iter().map(scene).collect(),
        report,
    ))
}

/// What parts of a pickle become: the tables, and bytes of frames and of the checkpoint.
pub type Recorded<'a> = ([String; 3], &'a [u8], Option<&'a [u8]>);

/// Puts a recording together again.
pub fn recording(
    text: &str,
    (tables, frames, checkpoint): Recorded,
    input: Option<Bound<'_, Scene>>,
    bodies: Vec<Option<Bound<'_, Scene>>>,
) -> Result<Recording, Failure> {
    let mut run = MemoryRun::new();
    run.begin(&Setting::read(text).map_err(damaged)?)?;
    // Readers skip the heading of a table.
    let table = |record: Record, lines: &str| {
        let header = record.header();
        String::from_utf8_lossy(&header).into_owned() + lines
    };
    for row in parse_energies(&table(Record::Energies, &tables[0])) {
        run.energy(&row)?;
    }
    for event in parse_events(&table(Record::Events, &tables[1])) {
        run.event(&event)?;
    }
    for row in parse_forces(&table(Record::Forces, &tables[2])) {
        run.force(&row)?;
    }
    let mut stored = IndexedFrames::open(Cursor::new(frames)).map_err(damaged)?;
    for number in 0..stored.count() {
        let frame: Option<Frame> = stored.read(number).map_err(damaged)?;
        frame.map_or(Ok(()), |frame| run.frame(frame))?;
    }
    if let Some(bytes) = checkpoint {
        run.save(Checkpoint::from_bytes(bytes).map_err(damaged)?)?;
    }
    let meshes = |scene: Bound<'_, Scene>| (*scene.get().scene).clone();
    Ok(Recording {
        source: Arc::new(run),
        meshes: SceneMeshes {
            input: input.map(meshes),
            bodies: bodies.into_iter().map(|body| body.map(meshes)).collect(),
        },
    })
}

/// Reads the only frame of a pickle.
pub fn stored_frame(bytes: &[u8]) -> Result<Frame, Failure> {
    let store = [&Record::Frames.header()[..], bytes].concat();
    let mut stored = IndexedFrames::open(Cursor::new(store)).map_err(damaged)?;
    let frame = stored.read(0).map_err(damaged)?;
    frame.ok_or_else(|| damaged("there is no frame in it"))
}

fn damaged(error: impl std::fmt::Display) -> Failure {
    Failure::value(format!(
        "the pickle of the run is of another version of greenstick, or damaged: {error}"
    ))
}

/// The call of a method of a run that made a skin or film.
pub struct MadeBy {
    run: Py<Run>,
    /// An `operator.methodcaller`.
    call: Py<PyAny>,
}

impl MadeBy {
    /// The call of `method` with its arguments; `keys` are those that it was given by name.
    pub fn new<'py>(
        run: &Bound<'py, Run>,
        method: &str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
        looks: [(&str, Option<&str>); 2],
        keys: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let py = run.py();
        let named = match keys {
            Some(keys) => keys.copy()?,
            None => PyDict::new(py),
        };
        for (name, value) in looks {
            named.set_item(name, value)?;
        }
        let given = arguments.into_pyobject(py)?;
        let method = PyTuple::new(py, [method])?.add(given)?;
        let caller = py.import("operator")?.getattr("methodcaller")?;
        let call = caller.call(method.cast::<PyTuple>()?, Some(&named))?;
        Ok(MadeBy {
            run: run.clone().unbind(),
            call: call.unbind(),
        })
    }

    /// What `__reduce__` returns for what it made.
    pub fn reduce<'py>(&self, py: Python<'py>) -> Reduced<'py, (Py<Run>,)> {
        let call = self.call.clone_ref(py).into_bound(py);
        Ok((call, (self.run.clone_ref(py),)))
    }
}
