//! Closed, textured meshes from what fracture and simulation produce.
#![deny(missing_docs)]

pub mod broken;
pub mod cracks;
mod error;
pub mod fray;
pub mod hang;
pub mod prepared;
pub mod remainder;
pub mod rods;
pub mod texture;

pub use error::BreakError;
