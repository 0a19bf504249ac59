//! Closed, textured meshes from what fracture and simulation produce.
#![deny(missing_docs)]

pub mod broken;
pub mod cracks;
mod error;
#[cfg(feature = "rods")]
pub mod film;
pub mod finish;
#[cfg(feature = "rods")]
pub mod fit;
pub mod fray;
mod fuzz;
pub mod hang;
pub mod lean;
pub mod materials;
pub mod prepared;
#[cfg(feature = "rods")]
pub mod remainder;
pub mod report;
#[cfg(feature = "rods")]
pub mod rods;
#[cfg(feature = "rods")]
pub mod rods_scene;
#[cfg(feature = "rods")]
pub mod simulated;
mod source;
pub mod stages;
pub mod texture;
pub mod view;
mod wood_field;

pub use error::BreakError;
pub use wood_field::WoodField;
