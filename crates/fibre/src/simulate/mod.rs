//! Simulation: a stem filled with rods, moved by a solver, recorded as it runs.
//!
//! A run is recorded in a [`RunStore`](crate::store::RunStore), such as a [`MemoryRun`](crate::store::MemoryRun). Tables
//! and frames only grow, and a checkpoint says how long they were when it was made. A run is resumed by cutting them to
//! that length and continuing, so that a run that was stopped anywhere ends in the same bytes. From there on its clamps may have other
//! key frames; it then ends in the bytes of a run that had those from the start.
//!
//! ```
//! use greenstick_fibre::scene::Scene;
//! use greenstick_fibre::simulate::{SimulateRequest, simulate};
//! use greenstick_fibre::store::{MemoryRun, RunSource};
//! use greenstick_geometry::Context;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = "
//!     duration = 0.002
//!     stem = { kind = 'cylinder', length = '6 cm', diameter = '6 mm' }
//!     wood = { stiffness = 0.002 }
//!     rods = { number = 8, twist = 'off' }
//!     clamp = [{ to = 0.2 }]
//!     loads = { gravity = [0, 0, -9.81] }
//! ";
//! let request = SimulateRequest { scene: Scene::read(scene)?, ..SimulateRequest::default() };
//! let mut run = MemoryRun::new();
//! let report = simulate(&request, &mut run, &Context::quiet())?;
//! println!("{report}");
//! assert_eq!(report.frames, run.frames()?.count() as u64);
//! # Ok(())
//! # }
//! ```

mod curves;
mod error;
mod meshes;
mod prepare;
mod refine;
mod report;
mod run;
mod steered;
mod tissue_report;

pub use curves::{LoadCurves, energy_curves};
pub use error::SimulateError;
pub use meshes::{SceneMeshes, body_shapes};
pub use prepare::{FilledStem, PositionedBundle, fill_scene_stem, position_bundle};
pub use refine::find_break;
pub use report::{Buckled, EnergyDrift, SimulateReport};
pub use run::{SimulateRequest, simulate};
pub use steered::scenes_agree_until;
pub use tissue_report::TissueReport;

use glam::DVec3;

/// Upwards in a scene.
pub const UP: DVec3 = DVec3::Z;
