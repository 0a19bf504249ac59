//! Sessions: one scene that is broken often, with requests that change.

use crate::broken::Broken;
use crate::convert::Reduced;
use crate::loaded_input::LoadedInput;
use crate::mesh::Mesh;
use crate::request::Request;
use crate::scene::Scene;
use pyo3::prelude::*;

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
pub struct Session(LoadedInput);

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

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (scene=None))]
    fn new(scene: Option<Py<Scene>>) -> Self {
        Session(LoadedInput::new(scene))
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
        let breaks = (self.0).at_work(py, request, progress, |session, input, context| {
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
    fn broken(
        &self,
        py: Python<'_>,
        request: &Request,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Broken> {
        Broken::of(py, &self.0, request, progress)
    }

    /// The first stage that the last request made anew (`stem`, `layout`, `heights`, `cut` or `finish`); `None` if all of it
    /// was there.
    #[getter]
    fn started_at(&self) -> PyResult<Option<String>> {
        Ok(self.0.started_at()?)
    }

    /// An independent session with everything that this one has made so far, for another thread.
    fn fork(&self, py: Python<'_>) -> PyResult<Session> {
        Ok(Session(self.0.fork(py)?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (Option<Py<Scene>>,)> {
        let given = slf.get().0.given(slf.py());
        Ok((slf.get_type().into_any(), (given,)))
    }
}
