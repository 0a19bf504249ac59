//! Runs in pickles: all that was recorded, whether it is in memory or in a folder.

use crate::failure::Failure;
use crate::films::Recording;
use crate::pickled::{damaged, seal, unseal};
use crate::scene::Scene;
use greenstick::fibre::scene::Scene as Setting;
use greenstick::fibre::store::{
    EnergyRow, ForceRow, Frame, IndexedFrames, Record, event_line, parse_energies, parse_events,
    parse_forces,
};
use greenstick::simulate::{MemoryRun, RunError, RunSink, SceneMeshes};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};
use std::io::Cursor;
use std::sync::Arc;

/// What is pickled, in messages.
const RUN: &str = "a run";
const FRAME: &str = "a frame";
/// Bytes of a checksum, which a stored frame ends with.
const SUM: usize = 8;

/// All of a run but its frames and meshes: the scene and the tables as the files of a run have them. The checkpoint is left out, as
/// nothing in Python goes on with a run.
#[derive(Serialize, Deserialize)]
struct Head {
    scene: String,
    energies: String,
    events: String,
    forces: String,
    /// The checksum of each frame.
    frames: Vec<u64>,
}

/// What a pickle of a run holds: the head and, of a run that was simulated here, its report as JSON, both sealed; frames as
/// `frames.gsf` has them; the mesh of the scene and those of bodies. All but the report is the same for a run in a folder.
pub type RunParts<'py> = (
    Bound<'py, PyBytes>,
    Option<Bound<'py, PyBytes>>,
    Vec<Bound<'py, PyBytes>>,
    Option<Scene>,
    Vec<Option<Scene>>,
);

/// Takes a run apart.
pub fn run_parts<'py>(
    py: Python<'py>,
    recording: &Recording,
    report: Option<&str>,
) -> PyResult<RunParts<'py>> {
    let source = &recording.source;
    let read = || -> Result<(Head, usize), RunError> {
        let head = Head {
            scene: source.scene()?.to_toml(),
            energies: source.energies()?.iter().map(EnergyRow::line).collect(),
            events: source.events()?.iter().map(event_line).collect(),
            forces: source.forces()?.iter().map(ForceRow::line).collect(),
            frames: Vec::new(),
        };
        Ok((head, source.frames()?.count()))
    };
    let (mut head, count) = py.detach(read).map_err(Failure::from)?;
    let mut frames = Vec::with_capacity(count);
    // One after the other: a run may fill a good part of the memory.
    for number in 0..count {
        py.check_signals()?;
        let frame = py.detach(|| Ok(source.frame(number)?.to_bytes()));
        let frame = frame.map_err(|error: RunError| Failure::from(error))?;
        head.frames.push(sum_of(&frame));
        frames.push(PyBytes::new(py, &frame));
    }
    let head = postcard::to_stdvec(&head)
        .map_err(|e| Failure::value(format!("the run cannot be pickled: {e}")))?;
    let scene = |meshes: &Option<_>| Some(Scene::new(Clone::clone(meshes.as_ref()?), None));
    Ok((
        PyBytes::new(py, &seal(&head)),
        report.map(|text| PyBytes::new(py, &seal(text.as_bytes()))),
        frames,
        scene(&recording.meshes.input),
        recording.meshes.bodies.iter().map(scene).collect(),
    ))
}

/// Puts a run together again.
pub fn run_again(
    head: &[u8],
    frames: &[Bound<'_, PyBytes>],
    input: Option<Bound<'_, Scene>>,
    bodies: Vec<Option<Bound<'_, Scene>>>,
) -> PyResult<Recording> {
    let head: Head =
        postcard::from_bytes(unseal(RUN, head)?).map_err(|problem| damaged(RUN, problem))?;
    if frames.len() != head.frames.len() {
        let (found, expected) = (frames.len(), head.frames.len());
        return Err(damaged(RUN, format!("it has {found} frames, not {expected}")).into());
    }
    let mut run = MemoryRun::new();
    fill(&mut run, &head).map_err(|problem| damaged(RUN, problem))?;
    for (number, (stored, sum)) in frames.iter().zip(&head.frames).enumerate() {
        let stored = stored.as_bytes();
        if sum_of(stored) != *sum {
            return Err(damaged(RUN, format!("frame {number} is another one")).into());
        }
        run.frame(stored_frame(stored).map_err(|problem| damaged(RUN, problem))?)
            .map_err(Failure::from)?;
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

/// The report of a run as JSON.
pub fn report_again(sealed: &[u8]) -> Result<String, Failure> {
    let text =
        std::str::from_utf8(unseal(RUN, sealed)?).map_err(|problem| damaged(RUN, problem))?;
    Ok(text.to_owned())
}

/// Puts the scene and the tables into a run.
fn fill(run: &mut MemoryRun, head: &Head) -> Result<(), Box<dyn std::error::Error>> {
    run.begin(&Setting::read(&head.scene)?)?;
    // Readers find columns by the heading of a table.
    let table = |record: Record, lines: &str| {
        String::from_utf8_lossy(&record.header()).into_owned() + lines
    };
    for row in parse_energies(&table(Record::Energies, &head.energies)) {
        run.energy(&row)?;
    }
    for event in parse_events(&table(Record::Events, &head.events)) {
        run.event(&event)?;
    }
    for row in parse_forces(&table(Record::Forces, &head.forces)) {
        run.force(&row)?;
    }
    Ok(())
}

/// The bytes of a frame by itself.
pub fn frame_bytes(frame: &Frame) -> Vec<u8> {
    seal(&frame.to_bytes())
}

/// The frame of such bytes.
pub fn frame_again(sealed: &[u8]) -> Result<Frame, Failure> {
    stored_frame(unseal(FRAME, sealed)?).map_err(|problem| damaged(FRAME, problem))
}

/// Reads a frame as `frames.gsf` has it.
fn stored_frame(bytes: &[u8]) -> Result<Frame, String> {
    let store = [&Record::Frames.header()[..], bytes].concat();
    let mut stored = IndexedFrames::open(Cursor::new(store)).map_err(|e| e.to_string())?;
    let frame = stored.read(0).map_err(|e| e.to_string())?;
    frame.ok_or_else(|| "a frame is not whole".to_owned())
}

/// The checksum that a stored frame ends with.
fn sum_of(frame: &[u8]) -> u64 {
    frame
        .last_chunk::<SUM>()
        .map_or(0, |sum| u64::from_le_bytes(*sum))
}
