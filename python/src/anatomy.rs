//! The inside of a stem.

use crate::convert::{encoded_files, report, write_files};
use crate::failure::Failure;
use crate::scene::Scene;
use crate::values::each;
use crate::work;
use greenstick::anatomy::{AnatomyFile, AnatomyInput, anatomy_files};
use greenstick::scanning::outline_error;
use greenstick::schema::Parameters;
use greenstick_sweep::Input;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// The inside of a stem: its numbers, and tables, pictures and volumes as files in memory.
#[pyclass(module = "greenstick", frozen)]
pub struct Anatomy {
    /// The numbers of `anatomy.json`: lengths in m, areas in m², volumes in m³.
    #[pyo3(get)]
    report: Py<PyAny>,
    /// Names of files and their bytes, those that the program writes.
    #[pyo3(get)]
    files: Py<PyDict>,
}

#[pymethods]
impl Anatomy {
    /// A table of Parquet as a `pyarrow.Table`, such as "particles"; units are in the metadata of its schema.
    fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let foreign = py.import("greenstick._foreign")?;
        foreign.call_method1("parquet_table", (self.files.bind(py), name))
    }

    /// A table as a dictionary of arrays of shape (n,), such as "particles": read from the PLY file, whose columns are views into
    /// its bytes, or from comma-separated values. Names of columns and units are those of the files.
    fn arrays<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let arrays = py.import("greenstick._arrays")?;
        arrays.call_method1("columns", (self.files.bind(py), name))
    }

    /// The voxels: a `Voxels` for each straight part of the stem; they take `only=["volume"]`. Copies.
    fn voxels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let arrays = py.import("greenstick._arrays")?;
        arrays.call_method1("voxels", (self.files.bind(py),))
    }

    /// Writes all files into a folder, all or none.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        write_files(self.files.bind(py), &folder)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<greenstick.Anatomy {} files>", self.files.bind(py).len())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> crate::convert::Reduced<'py, (Py<PyAny>, Py<PyDict>)> {
        let (py, anatomy) = (slf.py(), slf.get());
        let parts = (anatomy.report.clone_ref(py), anatomy.files.clone_ref(py));
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The inside of a pickle.
    #[staticmethod]
    fn _again(report: Py<PyAny>, files: Py<PyDict>) -> Self {
        Anatomy { report, files }
    }
}

/// Makes the inside of a stem: rings, tissues, particles, voxels and their numbers.
///
/// Keys are those of the program's options with underscores: `species="Sitka spruce"`, `resolution=64`,
/// `only=["particles", "measures"]`. The stem is that of `scene`, of the file `input`, or the branch that comes with the library.
#[pyfunction]
#[pyo3(signature = (scene=None, settings=None, *, progress=None, **keys))]
pub fn anatomy<'py>(
    py: Python<'py>,
    scene: Option<&Scene>,
    settings: Option<&Bound<'py, PyDict>>,
    progress: Option<&Bound<'py, PyAny>>,
    keys: Option<&Bound<'py, PyDict>>,
) -> PyResult<Anatomy> {
    let mut file = AnatomyFile::default();
    each([settings, keys], |key, value| Ok(file.set(key, value)?))?;
    file.check().map_err(Failure::from)?;
    let given = scene.map(|scene| (*scene.scene).clone());
    let made = work::run(py, progress, |context| {
        let place = file.request.location;
        let path = file.input.clone().map(PathBuf::from);
        let input = match (given, &path) {
            (Some(scene), _) => Input::of_scene(scene, place),
            (None, Some(path)) => Input::load(path, place, file.unit, &file.scan, context)?,
            (None, None) => Input::of_scene(greenstick::built_in_branch(), place),
        };
        // Files name their input without its folder.
        file.input = path
            .as_deref()
            .and_then(Path::file_name)
            .map(|n| n.to_string_lossy().into_owned());
        let provenance = file.provenance(input.scan.as_ref());
        file.request.location = input.place;
        let outline = input.scan.as_ref().and_then(outline_error);
        file.request.smoothing = file.request.smoothing.or(outline);
        let about = AnatomyInput {
            scene: &input.scene,
            scan: input.scan.as_ref(),
            cleaned: input.cleaned.as_ref(),
            provenance,
        };
        Ok(anatomy_files(&about, &file.request, context)?)
    })?;
    let files = encoded_files(py, &made.files)?;
    Ok(Anatomy {
        report: report(py, &made.report)?.unbind(),
        files: files.unbind(),
    })
}
