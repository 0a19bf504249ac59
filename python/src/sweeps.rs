//! Sweeps: many breaks, simulations or bending tests with parameters that vary, and forests.

use crate::convert::report;
use crate::failure::Failure;
use crate::work;
use greenstick_sweep::{Part, Run, Sweep, SweepError};
use pyo3::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use std::thread;

/// Variants above which a sweep may be a mistake: about an hour of work, or a folder that is a nuisance to delete.
pub const MANY: u64 = 10_000;

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        let class = match &error {
            SweepError::Recipe(_)
            | SweepError::Vary { .. }
            | SweepError::Forest { .. }
            | SweepError::TooMany { .. } => "ParameterError",
            SweepError::Scene(_) | SweepError::SceneFile { .. } => "SimulateError",
            SweepError::File(_) => "FileError",
            SweepError::Cancelled(_) => "Cancelled",
            _ => "SweepError",
        };
        Failure::new(class, error.kind(), error)
    }
}

/// What came of a run, as the program prints it with `--json`.
#[derive(Serialize)]
struct Report {
    variants: u64,
    found: u64,
    made: u64,
    failed: u64,
    table: Option<PathBuf>,
    sheet: Option<PathBuf>,
    scene: Option<PathBuf>,
}

/// A sweep that is described in TOML, whose relative files begin in `folder`.
fn read(text: &str, folder: &std::path::Path) -> Result<Sweep, Failure> {
    Ok(Sweep::read(text, folder)?)
}

/// Returns a description, as a JSON object, in TOML.
#[pyfunction]
pub fn _sweep_text(json: &str) -> PyResult<String> {
    let table: toml::Table = serde_json::from_str(json).map_err(Failure::value)?;
    Ok(toml::to_string(&table).map_err(Failure::value)?)
}

/// Returns the number of variants of a sweep.
#[pyfunction]
pub fn _sweep_count(text: &str, folder: PathBuf) -> PyResult<u64> {
    Ok(read(text, &folder)?.count())
}

/// What shows the progress of work that Python itself does.
#[pyclass(module = "greenstick", frozen)]
pub struct _Shown(Option<work::Shown>);

#[pymethods]
impl _Shown {
    #[new]
    #[pyo3(signature = (progress=None))]
    fn new(progress: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Ok(_Shown(work::Shown::new(progress)?))
    }

    fn show(&self, py: Python<'_>, stage: &str, fraction: f64) -> PyResult<()> {
        match &self.0 {
            Some(shown) => shown.show(py, stage, fraction),
            None => Ok(()),
        }
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        match &self.0 {
            Some(shown) => shown.close(py),
            None => Ok(()),
        }
    }
}

/// Makes what is missing of a sweep, or of a part of it ("2/4"), in the folder `output`, and returns the report.
#[pyfunction]
#[pyo3(signature = (text, folder, output, part=None, threads=None, many=false, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn _sweep<'py>(
    py: Python<'py>,
    text: &str,
    folder: PathBuf,
    output: PathBuf,
    part: Option<&str>,
    threads: Option<usize>,
    many: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let sweep = read(text, &folder)?;
    let part: Option<Part> = match part {
        Some(part) => Some(part.parse().map_err(Failure::value)?),
        None => None,
    };
    let threads = match threads {
        Some(0) => return Err(Failure::value("threads is 0; expected at least 1").into()),
        Some(threads) => threads,
        None => thread::available_parallelism().map_or(1, usize::from),
    };
    let made = work::run(py, progress, |context| {
        let run = Run {
            sweep: &sweep,
            folder: &output,
            part,
            threads,
            alone: &in_one_thread,
        };
        let variants = run.wanted();
        if variants > MANY && !many {
            return Err(Failure::value(format!(
                "the sweep has {variants} variants, which may be a mistake; many=True makes them"
            )));
        }
        let mut journal = run.journal()?;
        let found = journal.done().count();
        run.make(&mut journal, context)?;
        let overview = match part {
            None => Some(run.overview(&journal, &context.silenced())?),
            Some(_) => None,
        };
        let (table, sheet, scene) =
            overview.map_or((None, None, None), |o| (Some(o.table), o.sheet, o.scene));
        Ok(Report {
            variants,
            found,
            made: journal.done().count() - found,
            failed: journal.failed(),
            table,
            sheet,
            scene,
        })
    })?;
    report(py, &made)
}

/// Calls something in a pool of one thread, in which the loops inside a break do not compete with those of other variants.
fn in_one_thread(call: &mut (dyn FnMut() + Send)) {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(call),
        Err(_) => call(),
    }
}
