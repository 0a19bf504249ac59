//! `import greenstick`: the library `greenstick` for Python, and nothing of its own.
//!
//! Classes hold what the library returns. Work runs without the interpreter's lock ([`work`]), arrays look into the library's
//! memory where that is possible ([`arrays`]), and errors become exceptions with the same messages ([`failure`]).

mod anatomy;
mod arrays;
mod bending;
mod broken;
mod convert;
mod failure;
mod films;
mod loaded_input;
mod mesh;
mod pickled;
mod pickled_run;
mod pictures;
mod request;
mod rings;
mod scene;
mod session;
mod simulation;
mod species;
mod sweeps;
mod values;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::anatomy::{Anatomy, anatomy};
    #[pymodule_export]
    use super::bending::{BendTest, bend_test};
    #[pymodule_export]
    use super::broken::{Broken, break_wood};
    #[pymodule_export]
    use super::films::{Film, Skin};
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::pictures::Picture;
    #[pymodule_export]
    use super::request::{Request, presets};
    #[pymodule_export]
    use super::rings::{Rings, rings};
    #[pymodule_export]
    use super::scene::{Node, Scene, built_in_branch};
    #[pymodule_export]
    use super::session::{Piece, Session};
    #[pymodule_export]
    use super::simulation::{Frame, Run, scenes, simulate};
    #[pymodule_export]
    use super::species::{Species, species};
    #[pymodule_export]
    use super::sweeps::{_Shown, _sweep, _sweep_count, _sweep_text};
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("_MANY_VARIANTS", super::sweeps::MANY)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
