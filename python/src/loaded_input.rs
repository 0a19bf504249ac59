//! An input that is loaded for a request and stays loaded for the next, with the session that breaks it.

use crate::failure::Failure;
use crate::request::Request;
use crate::scene::Scene;
use crate::work;
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Scene as Meshes};
use greenstick::scanning::ScanParameters;
use greenstick::wood::stem::StemLocation;
use greenstick::{BreakSession, Broken as Outcome, ErrorKind};
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

/// What requests break: a scene that was given, or the input of each, loaded again only where it changes.
pub struct LoadedInput {
    given: Option<Py<Scene>>,
    loaded: Mutex<Option<Loaded>>,
}

impl LoadedInput {
    pub fn new(given: Option<Py<Scene>>) -> Self {
        LoadedInput {
            given,
            loaded: Mutex::new(None),
        }
    }

    /// The scene that was given.
    pub fn given(&self, py: Python<'_>) -> Option<Py<Scene>> {
        self.given.as_ref().map(|scene| scene.clone_ref(py))
    }

    /// The file that the input of a request is read from.
    pub fn source(&self, request: &Request) -> Option<PathBuf> {
        match &self.given {
            Some(scene) => scene.get().path.clone(),
            None => request.input_path(),
        }
    }

    /// The same with everything that was made so far, for another thread.
    pub fn fork(&self, py: Python<'_>) -> Result<Self, Failure> {
        let loaded = self.lock()?;
        let copy = loaded.as_ref().map(|loaded| Loaded {
            input: loaded.input.clone(),
            loading: loaded.loading.clone(),
            session: loaded.session.fork(),
        });
        Ok(LoadedInput {
            given: self.given(py),
            loaded: Mutex::new(copy),
        })
    }

    /// The first stage that the last request made anew, in small letters.
    pub fn started_at(&self) -> Result<Option<String>, Failure> {
        let loaded = self.lock()?;
        let stage = loaded.as_ref().and_then(|l| l.session.started_at());
        Ok(stage.map(|stage| format!("{stage:?}").to_lowercase()))
    }

    /// Breaks the wood, with materials and textures as files hold them.
    pub fn broken(
        &self,
        py: Python<'_>,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Outcome> {
        let source = self.source(request);
        self.at_work(py, request, progress, |session, input, context| {
            let mut broken = session.broken(&input.request(&request.file), context)?;
            input.note_origin(&mut broken, &request.file, source.as_deref());
            Ok(broken)
        })
    }

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
    pub fn at_work<T: Send>(
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
