//! What a run looks like: the skin of a frame, and films.

use crate::convert::{Reduced, report};
use crate::failure::Failure;
use crate::pictures::Picture;
use crate::scene::{Scene, encode, file_dictionary, matrix, picture_parameters};
use crate::values::{dictionary, each};
use crate::work;
use greenstick::files::{self, Batch, Output};
use greenstick::film::{FilmError, open_run};
use greenstick::formats::film::{GlbOptions, write_glb, write_usd};
use greenstick::formats::usd::UsdFormat;
use greenstick::geometry::{Context, Stage};
use greenstick::provenance;
use greenstick::schema::Parameters;
use greenstick::simulate::{RunSource, SceneMeshes};
use greenstick::simulated_faces::{SimulatedFaceReport, SimulatedFacesError};
use greenstick::skin::WoodField;
use greenstick::skin::film::{FilmParameters, Run as Opened, SkinReport};
use greenstick::skin::view::FilmView;
use greenstick_sweep::shown::{Faces, RunFilm, RunStill, ShowError, ShownAs, film_shot};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use std::io::{Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        match error {
            FilmError::Simulate(error) => error.into(),
            FilmError::Work(error) => error.into(),
            FilmError::File(error) => error.into(),
            error => Failure::new("FilmError", error.kind(), error),
        }
    }
}

impl From<ShowError> for Failure {
    fn from(error: ShowError) -> Self {
        match error {
            ShowError::Film(error) | ShowError::Faces(SimulatedFacesError::Run(error)) => {
                error.into()
            }
            ShowError::Faces(error) => Failure::new("FilmError", error.kind(), error),
            ShowError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

/// What is asked of a skin.
#[derive(Clone)]
pub struct Asked {
    faces: Option<Faces>,
    field: Option<WoodField>,
    parameters: FilmParameters,
}

impl Asked {
    /// Reads the arguments of `Run.skin` and `Run.film`.
    pub fn new(
        faces: Option<&str>,
        field: Option<&str>,
        dictionaries: [Option<&Bound<'_, PyDict>>; 2],
    ) -> PyResult<Self> {
        let mut parameters = FilmParameters::default();
        let mut given = Vec::new();
        each(dictionaries, |key, value| {
            given.push(key.to_owned());
            Ok(parameters.set(key, value)?)
        })?;
        parameters.check().map_err(Failure::from)?;
        let faces = match faces {
            None => None,
            Some("drawn") => Some(Faces::Drawn),
            Some("rods") => Some(Faces::Rods),
            Some(other) => {
                let message = format!("faces is {other:?}; expected \"drawn\", \"rods\" or None");
                return Err(Failure::value(message).into());
            }
        };
        let faces = Faces::meant(faces, |key| given.iter().any(|g| g == key)).map_err(|key| {
            Failure::value(format!(
                "{key} applies to the skin of the rods, and faces asks for drawn ones; expected one of them"
            ))
        })?;
        let field = match field {
            None => None,
            Some("strain") => Some(WoodField::Strain),
            Some("damage") => Some(WoodField::Damage),
            Some(other) => {
                let message =
                    format!("field is {other:?}; expected \"strain\", \"damage\" or None");
                return Err(Failure::value(message).into());
            }
        };
        Ok(Asked {
            faces,
            field,
            parameters,
        })
    }

    /// What reads it again: settings, faces and field.
    fn words<'py>(&self, py: Python<'py>) -> PyResult<Words<Bound<'py, PyDict>>> {
        let faces = self.faces.map(|faces| match faces {
            Faces::Drawn => "drawn".to_owned(),
            Faces::Rods => "rods".to_owned(),
        });
        let field = self.field.map(|field| match field {
            WoodField::Strain => "strain".to_owned(),
            WoodField::Damage => "damage".to_owned(),
        });
        Ok((dictionary(py, self.parameters.changed())?, faces, field))
    }

    fn shown(&self, seed: u64) -> ShownAs {
        ShownAs {
            faces: self.faces,
            field: self.field,
            film: self.parameters.film_options(seed),
        }
    }
}

/// What is asked of a skin as Python gives it: settings, faces and field.
type Words<D> = (D, Option<String>, Option<String>);

/// The same as the arguments of a run's `skin` and `film`: settings, and what is named.
fn arguments<'py>(
    (settings, faces, field): Words<Bound<'py, PyDict>>,
) -> PyResult<[Bound<'py, PyDict>; 2]> {
    let named = PyDict::new(settings.py());
    named.set_item("faces", faces)?;
    named.set_item("field", field)?;
    Ok([settings, named])
}

/// A run that was recorded, and the meshes that it is of.
#[derive(Clone)]
pub struct Recording {
    pub source: Arc<dyn RunSource>,
    pub meshes: SceneMeshes,
}

impl Recording {
    fn open(&self, context: &Context) -> Result<Opened, Failure> {
        Ok(open_run(self.source.clone(), &self.meshes, context)?)
    }

    /// Makes the skin of a frame, counted from 0 or from −1 backwards.
    pub fn skin(
        &self,
        frame: i64,
        (run_object, asked): (Py<PyAny>, Asked),
        context: &Context,
    ) -> Result<Skin, Failure> {
        let [read, work] = context.split([(Stage::new("read"), 1.0), (Stage::new("skin"), 9.0)]);
        let mut run = self.open(&read)?;
        let count = run.frames();
        let number = usize::try_from(if frame < 0 {
            count as i64 + frame
        } else {
            frame
        });
        let number = number.ok().filter(|n| *n < count).ok_or_else(|| {
            Failure::value(format!(
                "frame is {frame}, but there are {count} frames, counted from 0 or from -1 backwards"
            ))
        })?;
        let how = asked.shown(run.scene.seed);
        let mut still = RunStill::new(&mut run, number, &how, &work)?;
        still.scene().metadata = provenance("skin", None, &run.scene).metadata();
        Ok(Skin {
            report: FilmReport::new(still.report()),
            of: (run_object, number),
            asked,
            shown: Mutex::new((run, still)),
        })
    }

    /// Makes a film of all frames, or of those that are asked for.
    pub fn film(
        &self,
        (run_object, asked): (Py<PyAny>, Asked),
        context: &Context,
    ) -> Result<Film, Failure> {
        let [read, work] = context.split([(Stage::new("read"), 1.0), (Stage::new("skin"), 9.0)]);
        let mut run = self.open(&read)?;
        let frames = asked.parameters.frames.map(Into::into);
        let frames = frames.unwrap_or(0..run.frames());
        let how = asked.shown(run.scene.seed);
        let mut film = RunFilm::new(&mut run, frames, &how, &work)?;
        film.skinned().film.metadata = provenance("skin", None, &run.scene).metadata();
        Ok(Film {
            report: FilmReport::new(film.report()),
            glb: GlbOptions {
                max_joints: asked.parameters.max_joints.map(|n| n as usize),
                max_influences: asked.parameters.influences as usize,
            },
            of: run_object,
            asked,
            shown: Mutex::new((run, film)),
            view: OnceLock::new(),
        })
    }
}

/// The report of a skin or film.
#[derive(Serialize)]
struct FilmReport {
    #[serde(flatten)]
    skin: SkinReport,
    /// What each face was made from, from the base of the stem to its tip.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    simulated: Vec<SimulatedFaceReport>,
}

impl FilmReport {
    fn new((skin, faces): (&SkinReport, &[SimulatedFaceReport])) -> Self {
        FilmReport {
            skin: skin.clone(),
            simulated: faces.to_vec(),
        }
    }
}

/// The skin of one frame: its pieces as they are then, and bodies. It pickles as its run and what was asked, and is made again when
/// it is unpickled.
#[pyclass(module = "greenstick", frozen)]
pub struct Skin {
    report: FilmReport,
    /// Its run (a `Run`), and the frame.
    of: (Py<PyAny>, usize),
    asked: Asked,
    /// The run, and what is shown of it.
    shown: Mutex<(Opened, RunStill)>,
}

#[pymethods]
impl Skin {
    /// The pieces, then what the rods do not fill, then bodies: lengths in m, y up.
    #[getter]
    fn scene(&self) -> Scene {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        Scene::new(shown.1.scene().clone(), None)
    }

    /// The report as the program prints it with `--json`: lengths in m, volumes in m³, times in s.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.report)
    }

    /// Takes a picture of it. Keys are those of pictures: `picture_size="640x480"`, `samples=16`, `close_up=6`.
    #[pyo3(signature = (*, progress=None, **keys))]
    fn picture(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Picture> {
        let options = picture_parameters(keys)?.options();
        work::run(py, progress, |context| {
            let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
            let (run, still) = &mut *shown;
            let metadata = still.scene().metadata.clone();
            Ok(Picture::new(
                still.picture(run, &options, context)?,
                metadata,
            ))
        })
    }

    /// Encodes it in the format of the ending of `name`: names of files and their bytes, those that the program writes.
    fn encode<'py>(&self, py: Python<'py>, name: PathBuf) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.scene();
        let outputs = work::run(py, None, |_| encode(&scene.scene, None, &name, None))?;
        file_dictionary(py, outputs)
    }

    /// Writes it in the format of the ending of `path`, with its companions: all files or none. Returns the paths.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<PathBuf>> {
        let scene = self.scene();
        work::run(py, None, |_| {
            let outputs = encode(&scene.scene, None, &path, None)?;
            files::write_all(&outputs)?;
            Ok(outputs.into_iter().map(|o| o.path).collect())
        })
    }

    fn __repr__(&self) -> String {
        let [first, _] = self.report.skin.time_s;
        format!("<greenstick.Skin at {first} s>")
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> Reduced<'py, (Py<PyAny>, usize, Words<Bound<'py, PyDict>>)> {
        let (py, skin) = (slf.py(), slf.get());
        let parts = (skin.of.0.clone_ref(py), skin.of.1, skin.asked.words(py)?);
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The skin of a pickle.
    #[staticmethod]
    fn _again<'py>(
        run: &Bound<'py, PyAny>,
        frame: i64,
        words: Words<Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [settings, shown] = arguments(words)?;
        run.call_method("skin", (frame, settings), Some(&shown))
    }
}

/// A film: pieces that are the same in all frames, and how they move. It pickles as its run and what was asked, and is made again
/// when it is unpickled.
#[pyclass(module = "greenstick", frozen)]
pub struct Film {
    report: FilmReport,
    /// Its run (a `Run`).
    of: Py<PyAny>,
    asked: Asked,
    glb: GlbOptions,
    /// The run, and what is shown of it.
    shown: Mutex<(Opened, RunFilm)>,
    /// What pictures of all frames show, once one was taken.
    view: OnceLock<FilmView>,
}

impl Film {
    /// A frame as a scene; `number` is counted from 0, or from −1 backwards.
    fn at(&self, number: i64) -> Result<greenstick::geometry::Scene, Failure> {
        let count = self.report.skin.frames as i64;
        let from_first = if number < 0 { count + number } else { number };
        if !(0..count).contains(&from_first) {
            return Err(Failure::value(format!(
                "there is no frame {number}; the film has {count}"
            )));
        }
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let (run, film) = &mut *shown;
        let mut scene = film.at(run, from_first as usize)?;
        scene.metadata = film.skinned().film.metadata.clone();
        Ok(scene)
    }

    /// Writes the film in the format of the ending of `path`; returns the files that go beside it.
    fn write_into(
        &self,
        path: &Path,
        out: &mut (impl Write + Seek),
        context: &Context,
    ) -> Result<Vec<Output>, Failure> {
        let format = Ending::of(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let skinned = shown.1.skinned();
        let (film, motion) = (&skinned.film, &mut skinned.motion);
        let beside = match format {
            Ending::Glb => {
                write_glb(film, motion, &name, &self.glb, out, context).map_err(FilmError::from)?;
                Vec::new()
            }
            Ending::Usd(format) => {
                write_usd(format, film, motion, &name, out, context)
                    .map_err(FilmError::from)?
                    .1
            }
        };
        let beside = beside.into_iter().map(|file| Output {
            path: path.with_file_name(file.name),
            bytes: file.bytes,
        });
        Ok(beside.collect())
    }
}

/// The formats of films.
enum Ending {
    Glb,
    Usd(UsdFormat),
}

impl Ending {
    fn of(path: &Path) -> Result<Self, Failure> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match UsdFormat::from_path(path) {
            Some(UsdFormat::Usda) | None if ending.as_deref() != Some("glb") => {
                Err(Failure::value(format!(
                    "{}: a film is written as .glb, .usdc or .usdz",
                    path.display()
                )))
            }
            Some(format) => Ok(Ending::Usd(format)),
            None => Ok(Ending::Glb),
        }
    }
}

#[pymethods]
impl Film {
    /// The report as the program prints it with `--json`: lengths in m, volumes in m³, times in s.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.report)
    }

    /// The map from the world of the mesh that was simulated to that of the film, which is the same but for a mesh with z up or a
    /// stem of the scene's own: shape (4, 4), float64, m, y up. A copy.
    #[getter]
    fn transform<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        matrix(py, &shown.0.film_from_stem())
    }

    /// A frame as a scene, counted from the film's first or, from −1, backwards: lengths in m, y up.
    fn scene(&self, py: Python<'_>, number: i64) -> PyResult<Scene> {
        work::run(py, None, |_| Ok(Scene::new(self.at(number)?, None)))
    }

    /// Takes a picture of a frame, with the camera and the ground where they are in all frames. Keys are those of pictures:
    /// `picture_size="640x480"`, `samples=16`, `close_up=6`.
    #[pyo3(signature = (number, *, progress=None, **keys))]
    fn picture(
        &self,
        py: Python<'_>,
        number: i64,
        progress: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Picture> {
        let options = picture_parameters(keys)?.options();
        work::run(py, progress, |context| {
            let [framing, drawing] =
                context.split([(Stage::new("frames"), 0.1), (Stage::new("picture"), 1.0)]);
            let frame = self.at(number)?;
            let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
            let (run, film) = &mut *shown;
            let view = match self.view.get() {
                Some(view) => view,
                None => {
                    let all: Vec<usize> = (0..self.report.skin.frames).collect();
                    let view = film.view(&all, &framing)?;
                    self.view.get_or_init(|| view)
                }
            };
            let shot = film_shot(view, &options);
            let picture = film.picture(run, &frame, &shot, &drawing)?;
            Ok(Picture::new(picture, frame.metadata.clone()))
        })
    }

    /// Encodes the film as .glb, .usdc or .usdz, the ending of `name`: names of files and their bytes, those that the program
    /// writes. It is in memory as a whole.
    fn encode<'py>(&self, py: Python<'py>, name: PathBuf) -> PyResult<Bound<'py, PyDict>> {
        let outputs = work::run(py, None, |context| {
            let mut out = Cursor::new(Vec::new());
            let mut outputs = self.write_into(&name, &mut out, context)?;
            let (path, bytes) = (name.clone(), out.into_inner());
            outputs.insert(0, Output { path, bytes });
            Ok(outputs)
        })?;
        file_dictionary(py, outputs)
    }

    /// Writes the film as .glb, .usdc or .usdz, with its companions: all files or none. Frames are written as they are made;
    /// none is kept. Returns the paths.
    #[pyo3(signature = (path, *, progress=None))]
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<PathBuf>> {
        work::run(py, progress, |context| {
            Ending::of(&path)?;
            let mut batch = Batch::default();
            let beside = batch.stream(&path, |file| self.write_into(&path, file, context))?;
            beside.iter().try_for_each(|output| batch.add(output))?;
            batch.finish()?;
            let mut paths = vec![path.clone()];
            paths.extend(beside.into_iter().map(|o| o.path));
            Ok(paths)
        })
    }

    fn __len__(&self) -> usize {
        self.report.skin.frames
    }

    fn __repr__(&self) -> String {
        format!("<greenstick.Film {} frames>", self.__len__())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> Reduced<'py, (Py<PyAny>, Words<Bound<'py, PyDict>>)> {
        let (py, film) = (slf.py(), slf.get());
        let parts = (film.of.clone_ref(py), film.asked.words(py)?);
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The film of a pickle.
    #[staticmethod]
    fn _again<'py>(
        run: &Bound<'py, PyAny>,
        words: Words<Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [settings, shown] = arguments(words)?;
        run.call_method("film", (settings,), Some(&shown))
    }
}
