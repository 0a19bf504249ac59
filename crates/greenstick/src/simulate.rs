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

use greenstick_fibre::Event;
use greenstick_fibre::outcome::broken_region as region_of_breaks;
use greenstick_fibre::store::Frame;
use greenstick_picture::Sphere;

/// Returns what a close-up of `diameters` diameters of a stem shows of a run: a sphere about the places (m) at which rods broke, or
/// nothing where none did. `first` is the first frame.
pub fn broken_region(first: &Frame, events: &[Event], diameters: f64) -> Option<Sphere> {
    let (centre, radius) = region_of_breaks(first, events, diameters)?;
    Some(Sphere { centre, radius })
}
