//! Simulation: a stem filled with rods, moved by a solver, recorded as it runs, and charts of what was recorded.
//!
//! The work is that of [`greenstick_fibre::simulate`]. A run is recorded in a [`RunStore`]: a folder
//! (`files::run::RunFolder`, with the feature `files`) or memory ([`MemoryRun`]).

pub use crate::charts::{energy_chart, load_chart};
pub use greenstick_fibre::simulate::{
    EnergyDrift, FilledStem, SceneMeshes, SimulateError, SimulateReport, SimulateRequest, UP,
    body_shapes, fill_scene_stem, find_break, simulate,
};
pub use greenstick_fibre::store::{MemoryRun, RunError, RunSink, RunSource, RunStore};
