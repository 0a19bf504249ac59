//! Requests: everything that decides the outcome of a break.

use crate::convert::{Reduced, from_python, report};
use crate::failure::Failure;
use crate::pickled::damaged;
use crate::values::{attribute, dictionary, each, get};
use greenstick::files::read_text;
use greenstick::fracture::presets::PRESETS;
use greenstick::schema::Parameters;
use greenstick::wood::stem::StemLocation;
use greenstick::{RequestFile, RequestFileError};
use greenstick_sweep::keys;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::path::{Path, PathBuf};

/// Everything that decides the outcome of a break: what is read, where and how it breaks, what is shown.
///
/// Layers, later ones over earlier ones: defaults, `presets`, the TOML of a recipe in `text`, `settings`, `keys`. Keys are
/// those of recipes; those of the table `break` may stand alone (`slab_height`), and keys with dots go into `settings` or
/// brackets: `request["high.height"] = 2`. `None` is "auto". Lengths are in metres, or texts with a unit ("3 cm").
///
/// Every key without a dot is an attribute, too: `request.seed = 7`.
///
/// >>> request = Request("brash", species="white oak", seed=7, part="3 cm")
/// >>> request.part
/// 0.03
///
/// A request pickles as its recipe.
#[pyclass(module = "greenstick")]
#[derive(Clone)]
pub struct Request {
    pub file: RequestFile,
    /// The folder that a relative input starts from.
    pub folder: PathBuf,
}

impl Request {
    /// The file that is broken; none is the built-in branch.
    pub fn input_path(&self) -> Option<PathBuf> {
        let name = self.file.input.as_ref()?;
        Some(self.folder.join(name))
    }

    /// The place of the first break.
    pub fn first_place(&self) -> StemLocation {
        let first = self.file.breaks.first();
        first.unwrap_or(&self.file.common).place
    }
}

fn failure(error: RequestFileError) -> Failure {
    error.into()
}

#[pymethods]
impl Request {
    #[new]
    #[pyo3(signature = (*presets, text=None, settings=None, **keys))]
    fn new(
        presets: &Bound<'_, PyTuple>,
        text: Option<&str>,
        settings: Option<&Bound<'_, PyDict>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let presets: Vec<String> = presets.extract()?;
        let presets: Vec<&str> = presets.iter().map(String::as_str).collect();
        let mut file = RequestFile::resolve(&presets, text, &[]).map_err(failure)?;
        each([settings, keys], |key, value| {
            Ok(keys::set(&mut file, key, value)?)
        })?;
        file.complete().map_err(Failure::from)?;
        Ok(Request {
            file,
            folder: PathBuf::new(),
        })
    }

    /// Reads a recipe file (TOML). A relative input in it starts from its folder.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let text = read_text(&path).map_err(Failure::from)?;
        let file = RequestFile::resolve(&[], Some(&text), &[]).map_err(|error| {
            Failure::new(
                "ParameterError",
                greenstick::ErrorKind::Request,
                format!("{}: {error}", path.display()),
            )
        })?;
        Ok(Request {
            file,
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        })
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        get(py, &self.file, key)
    }

    fn __setitem__(&mut self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = from_python(key, value)?;
        let mut file = self.file.clone();
        keys::set(&mut file, key, &value).map_err(Failure::from)?;
        file.complete().map_err(Failure::from)?;
        self.file = file;
        Ok(())
    }

    fn __getattr__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        attribute(py, &self.file, key)
    }

    fn __setattr__(&mut self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.__setitem__(key, value)
    }

    fn __contains__(&self, key: &str) -> bool {
        keys::find(&self.file, key).is_ok()
    }

    /// All keys, in the order of the reference.
    fn keys(&self) -> Vec<String> {
        self.file.list().into_iter().map(|p| p.key).collect()
    }

    /// All parameters with their values.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(py, self.file.list())
    }

    /// The parameters that are not at their defaults; those of breaks as `breaks[0].fray`.
    fn changed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        dictionary(py, self.file.changed())
    }

    /// What is known of a parameter: its unit, range, choices, default and documentation.
    fn about<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let info = keys::find(&self.file, key).map_err(Failure::from)?;
        report(py, &info)
    }

    /// Sets several parameters, all or none. Keys with dots go into `settings`.
    #[pyo3(signature = (settings=None, **keys))]
    fn update(
        &mut self,
        settings: Option<&Bound<'_, PyDict>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut file = self.file.clone();
        each([settings, keys], |key, value| {
            Ok(keys::set(&mut file, key, value)?)
        })?;
        file.complete().map_err(Failure::from)?;
        self.file = file;
        Ok(())
    }

    /// Adds a break: it starts from the keys of the request, with these over them. The request then breaks the stem where
    /// its breaks are, and nowhere else.
    #[pyo3(signature = (settings=None, **keys))]
    fn add_break(
        &mut self,
        settings: Option<&Bound<'_, PyDict>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut file = self.file.clone();
        let mut one = file.common.clone();
        each([settings, keys], |key, value| {
            let key = keys::find(&one, key)?.key;
            Ok(one.set(&key, value)?)
        })?;
        file.breaks.push(one);
        file.complete().map_err(Failure::from)?;
        self.file = file;
        Ok(())
    }

    /// The number of breaks.
    #[getter]
    fn break_count(&self) -> usize {
        self.file.breaks.len().max(1)
    }

    /// The request as a recipe (TOML) with every parameter, so that it means the same whatever defaults and presets become.
    fn to_toml(&self) -> String {
        self.file.to_toml()
    }

    /// A hash of all parameters, 32 hexadecimal digits, the same on every machine; not for security.
    fn hash(&self) -> String {
        self.file.hash()
    }

    /// A copy that changes by itself.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Request>().ok();
        other.is_some_and(|other| {
            let other = other.borrow();
            (&other.file, &other.folder) == (&self.file, &self.folder)
        })
    }

    fn __repr__(&self) -> String {
        let changed = self.file.changed();
        let changed: Vec<String> = changed
            .iter()
            .map(|p| format!("{}={}", p.key, p.value))
            .collect();
        format!("<greenstick.Request {}>", changed.join(", "))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (String, PathBuf)> {
        let request = slf.borrow();
        let again = slf.get_type().getattr("_again")?;
        Ok((again, (request.file.to_toml(), request.folder.clone())))
    }

    /// The request of a recipe whose relative input starts from a folder; for pickles.
    #[staticmethod]
    fn _again(text: &str, folder: PathBuf) -> PyResult<Self> {
        let file = RequestFile::resolve(&[], Some(text), &[]);
        let file = file.map_err(|problem| damaged("a request", problem))?;
        // Python writes an empty path as ".".
        let folder = folder
            .strip_prefix(".")
            .map(Path::to_owned)
            .unwrap_or(folder);
        Ok(Request { file, folder })
    }
}

/// The presets: ways in which wood breaks, each with one line about it.
#[pyfunction]
pub fn presets(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let dictionary = PyDict::new(py);
    for preset in PRESETS {
        dictionary.set_item(preset.name, preset.summary)?;
    }
    Ok(dictionary)
}
