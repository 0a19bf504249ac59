//! Broken wood: the scene, the report and the picture of a break.

use crate::convert::{Reduced, report};
use crate::failure::Failure;
use crate::loaded_input::LoadedInput;
use crate::pickled::{unseal, version_seal};
use crate::pictures::Picture;
use crate::request::Request;
use crate::scene::{Scene, encode, file_dictionary};
use crate::work;
use greenstick::Broken as Outcome;
use greenstick::files;
use greenstick::formats::LengthUnit;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// Broken wood.
///
/// It pickles as its input and its request, and is broken again when it is unpickled: the same bytes, after the time of a
/// break. Where that is too long, pickle `scene` and `report`.
#[pyclass(module = "greenstick", frozen)]
pub struct Broken {
    outcome: Outcome,
    /// What it was made of.
    request: Request,
    /// The input, where it is not that of the request.
    given: Option<Py<Scene>>,
    /// The file that the input was read from.
    source: Option<PathBuf>,
}

impl Broken {
    /// Breaks an input as a request asks.
    pub fn of(
        py: Python<'_>,
        input: &LoadedInput,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Broken {
            outcome: input.broken(py, request, progress)?,
            given: input.given(py),
            source: input.source(request),
            request: request.clone(),
        })
    }

    fn unit(&self) -> Option<LengthUnit> {
        self.request.file.unit
    }
}

#[pymethods]
impl Broken {
    /// The pieces first: `lower`, `upper` and splinters, or, of several breaks, `piece_0` and so on from the base and
    /// splinters; then what was not touched. Meshes are not copied.
    #[getter]
    fn scene(&self) -> Scene {
        Scene::new(self.outcome.scene.clone(), self.source.clone())
    }

    /// The report as the program prints it with `--json`: lengths in m, volumes in m³.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.outcome.report)
    }

    /// The request.
    #[getter]
    fn request(&self) -> Request {
        self.request.clone()
    }

    /// Encodes the pieces in the format of the ending of `name`: names of files and their bytes. They are those that the
    /// program writes for the same recipe.
    fn encode<'py>(&self, py: Python<'py>, name: PathBuf) -> PyResult<Bound<'py, PyDict>> {
        let (scene, source) = (&self.outcome.scene, self.source.as_deref());
        let outputs = work::run(py, None, |_| encode(scene, source, &name, self.unit()))?;
        file_dictionary(py, outputs)
    }

    /// Writes the pieces in the format of the ending of `path`, with their companions: all files or none. Returns the paths.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<PathBuf>> {
        let (scene, source) = (&self.outcome.scene, self.source.as_deref());
        work::run(py, None, |_| {
            let outputs = encode(scene, source, &path, self.unit())?;
            files::write_all(&outputs)?;
            Ok(outputs.into_iter().map(|o| o.path).collect())
        })
    }

    /// Takes a picture of the break, opened so that its faces show. Keys are those of pictures (`picture_size="640x480"`,
    /// `samples=16`, `view="30,15"`, `close_up=3`); the others are as in the request.
    #[pyo3(signature = (*, progress=None, **keys))]
    fn picture(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Picture> {
        let options = match keys {
            Some(_) => {
                use greenstick::schema::Parameters;
                let mut parameters = self.request.file.picture.clone();
                crate::values::each([keys, None], |key, value| Ok(parameters.set(key, value)?))?;
                parameters.options()
            }
            None => self.request.file.picture.options(),
        };
        let outcome = &self.outcome;
        let drawn = work::run(py, progress, |context| {
            Ok(greenstick::picture_of_break(outcome, &options, context)?)
        })?;
        Ok(Picture::new(drawn, outcome.scene.metadata.clone()))
    }

    /// A small picture, for notebooks.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let small = PyDict::new(py);
        small.set_item("picture_size", NOTEBOOK_SIZE)?;
        small.set_item("samples", NOTEBOOK_SAMPLES)?;
        let picture = self.picture(py, None, Some(&small))?;
        Ok(picture.png(py).into_any())
    }

    fn __str__(&self) -> String {
        self.outcome.report.to_string()
    }

    fn __repr__(&self) -> String {
        let pieces = self.outcome.report.pieces.iter();
        let names: Vec<&str> = pieces.map(|p| p.name.as_str()).collect();
        format!("<greenstick.Broken {}>", names.join(", "))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> Reduced<'py, (Bound<'py, PyBytes>, Request, Option<Py<Scene>>)> {
        let (py, broken) = (slf.py(), slf.get());
        let given = broken.given.as_ref().map(|g| g.clone_ref(py));
        let parts = (version_seal(py), broken.request.clone(), given);
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The broken wood of a pickle.
    #[staticmethod]
    fn _again(
        py: Python<'_>,
        seal: &[u8],
        request: &Request,
        given: Option<Py<Scene>>,
    ) -> PyResult<Self> {
        unseal("broken wood", seal)?;
        break_wood(py, Some(request), given, None)
    }
}

/// Size of the pictures that notebooks show, pixels: wide enough for a column of text.
const NOTEBOOK_SIZE: &str = "640x480";
/// Their rays for each pixel: quick rather than smooth.
const NOTEBOOK_SAMPLES: u32 = 8;

/// Breaks wood once: the input of the request, or `scene`. To break it often, use a `Session`.
#[pyfunction]
#[pyo3(signature = (request=None, scene=None, *, progress=None))]
pub fn break_wood(
    py: Python<'_>,
    request: Option<&Request>,
    scene: Option<Py<Scene>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Broken> {
    let request = match request {
        Some(request) => request.clone(),
        None => Request::default_request().map_err(PyErr::from)?,
    };
    Broken::of(py, &LoadedInput::new(scene), &request, progress)
}

impl Request {
    /// The request that asks for nothing.
    pub fn default_request() -> Result<Self, Failure> {
        Ok(Request {
            file: greenstick::RequestFile::resolve(&[], None, &[])?,
            folder: PathBuf::new(),
        })
    }
}
