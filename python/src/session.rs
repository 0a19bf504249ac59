//! Sessions: one scene that is broken often, with requests that change.

use crate::broken::Broken;
use crate::convert::Reduced;
use crate::failure::Failure;
use crate::mesh::Mesh;
use crate::request::Request;
use crate::scene::Scene;
use crate::work;
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Scene as Meshes};
use greenstick::scanning::ScanParameters;
use greenstick::wood::stem::StemLocation;
use greenstick::{BreakSession, ErrorKind};
use greenstick_sweep::Input;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// What decides how an input is loaded: where it changes, it is loaded again.
#[derive(Clone, PartialEq)]
struct Loading {
    path: Option<PathBuf>,
    unit: Option<LengthUnit>,
    scan: ScanParameters,
    /// The first place, which scans are made about.
    place: StemLocation,
}

impl Loading {
    fn new(request: &Request) -> Self {
        Loading {
            path: request.input_path(),
            unit: request.file.unit,
            scan: request.file.scan.clone(),
            place: request.first_place(),
        }
    }

    /// Whether an input that was loaded so is the one that `other` asks for.
    fn serves(&self, other: &Loading, input: &Input) -> bool {
        let mut other = other.clone();
        if input.scan.is_none() && !other.scan.as_scan {
            other.place = self.place;
        }
        *self == other
    }
}

/// An input and the session that breaks it.
struct Loaded {
    input: Input,
    /// How it was loaded; none of a scene that was given.
    loading: Option<Loading>,
    session: BreakSession,
}

/// A scene that is broken often: only the stages that a change touches are made anew.
///
/// `Session()` breaks the input of each request, and loads it again only where it changes; `Session(scene)` breaks a scene.
///
/// >>> session = Session()
/// >>> request = Request()
/// >>> pieces = session.pieces(request)
/// >>> request.inclination = 10
/// >>> pieces = session.pieces(request)
/// >>> session.started_at
/// 'heights'
///
/// A session works for one thread at a time; `fork` gives another thread its own. It pickles as its scene: its stages are made anew.
#[pyclass(module = "greenstick", frozen)]
pub struct Session {
    given: Option<Py<Scene>>,
    loaded: Mutex<Option<Loaded>>,
}

/// A piece of broken wood.
#[pyclass(module = "greenstick", frozen, get_all)]
pub struct Piece {
    /// `lower`, `upper`, `piece_0` or `splinter_000` and so on.
    name: String,
    /// The number of the break that made it, in the order of the request.
    break_number: usize,
    /// Its mesh, in the coordinates of the node that was cut. Not a copy.
    mesh: Py<Mesh>,
}

#[pymethods]
impl Piece {
    fn __repr__(&self) -> String {
        let triangles = self.mesh.get().mesh.triangles.len();
        format!("<greenstick.Piece {}, {triangles} triangles>", self.name)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (String, usize, Py<Mesh>)> {
        let piece = slf.get();
        let parts = (
            piece.name.clone(),
            piece.break_number,
            piece.mesh.clone_ref(slf.py()),
        );
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The piece of a pickle.
    #[staticmethod]
    fn _again(name: String, break_number: usize, mesh: Py<Mesh>) -> Self {
        Piece {
            name,
            break_number,
            mesh,
        }
    }
}

impl Session {
    /// What is loaded, for this thread alone.
    fn lock(&self) -> Result<MutexGuard<'_, Option<Loaded>>, Failure> {
        match self.loaded.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => {
                // What a fault has left half done is not used again.
                let mut guard = poisoned.into_inner();
                *guard = None;
                self.loaded.clear_poison();
                Ok(guard)
            }
            Err(TryLockError::WouldBlock) => Err(Failure::new(
                "BusyError",
                ErrorKind::Request,
                "the session is at work for another thread; fork() gives each thread its own",
            )),
        }
    }

    /// Calls `work` with the session and the input of a request, loaded where that is needed, without the interpreter's lock.
    fn at_work<T: Send>(
        &self,
        py: Python<'_>,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&mut BreakSession, &Input, &Context) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let given = self.given.as_ref().map(|scene| {
            let scene = scene.get();
            scene.scene.clone()
        });
        work::run(py, progress, |context| {
            let mut slot = self.lock()?;
            let loading = Loading::new(request);
            let fresh = match (&*slot, &given) {
                (Some(_), Some(_)) => true,
                (Some(loaded), None) => loaded
                    .loading
                    .as_ref()
                    .is_some_and(|l| l.serves(&loading, &loaded.input)),
                (None, _) => false,
            };
            if !fresh {
                *slot = None;
                let place = loading.place;
                let (input, loading) = match given {
                    Some(scene) => (Input::of_scene(Meshes::clone(&scene), place), None),
                    None => {
                        let input = Input::of_request(
                            &request.file,
                            loading.path.as_deref(),
                            &context.silenced(),
                        )?;
                        (input, Some(loading))
                    }
                };
                *slot = Some(Loaded {
                    session: BreakSession::new(input.scene.clone()),
                    input,
                    loading,
                });
            }
            let Some(loaded) = &mut *slot else {
                return Err(Failure::value("no input was loaded"));
            };
            if loaded.input.scan.is_none() {
                loaded.input.place = request.first_place();
            }
            work(&mut loaded.session, &loaded.input, context)
        })
    }
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (scene=None))]
    pub fn new(scene: Option<Py<Scene>>) -> Self {
        Session {
            given: scene,
            loaded: Mutex::new(None),
        }
    }

    /// Returns the pieces of a request as meshes without textures: of every break the lower piece, the upper one, then
    /// splinters, from the break farthest from the base to the nearest. Meshes are not copied.
    #[pyo3(signature = (request, *, progress=None))]
    fn pieces(
        &self,
        py: Python<'_>,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Piece>> {
        let breaks = self.at_work(py, request, progress, |session, input, context| {
            Ok(session.pieces(&input.request(&request.file), context)?)
        })?;
        let mut all = Vec::new();
        for one in &breaks {
            for piece in &one.pieces.pieces {
                all.push(Piece {
                    name: piece.role.name(),
                    break_number: one.number,
                    mesh: Py::new(
                        py,
                        Mesh {
                            mesh: piece.mesh.clone(),
                        },
                    )?,
                });
            }
        }
        Ok(all)
    }

    /// Breaks the wood, with materials and textures as files hold them.
    #[pyo3(signature = (request, *, progress=None))]
    pub fn broken(
        &self,
        py: Python<'_>,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Broken> {
        let given = self.given.as_ref().map(|scene| scene.clone_ref(py));
        let source = match &given {
            Some(scene) => scene.get().path.clone(),
            None => request.input_path(),
        };
        let outcome = self.at_work(py, request, progress, |session, input, context| {
            let mut broken = session.broken(&input.request(&request.file), context)?;
            input.note_origin(&mut broken, &request.file, source.as_deref());
            Ok(broken)
        })?;
        Ok(Broken::new(outcome, request.clone(), given, source))
    }

    /// The first stage that the last request made anew (`stem`, `layout`, `heights`, `cut` or `finish`); `None` if all of it
    /// was there.
    #[getter]
    fn started_at(&self) -> PyResult<Option<String>> {
        let loaded = self.lock()?;
        let stage = loaded.as_ref().and_then(|l| l.session.started_at());
        Ok(stage.map(|stage| format!("{stage:?}").to_lowercase()))
    }

    /// An independent session with everything that this one has made so far, for another thread.
    fn fork(&self, py: Python<'_>) -> PyResult<Session> {
        let loaded = self.lock()?;
        let copy = loaded.as_ref().map(|loaded| Loaded {
            input: loaded.input.clone(),
            loading: loaded.loading.clone(),
            session: loaded.session.fork(),
        });
        Ok(Session {
            given: self.given.as_ref().map(|scene| scene.clone_ref(py)),
            loaded: Mutex::new(copy),
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (Option<Py<Scene>>,)> {
        let given = slf.get().given.as_ref();
        let given = given.map(|scene| scene.clone_ref(slf.py()));
        Ok((slf.get_type().into_any(), (given,)))
    }
}
