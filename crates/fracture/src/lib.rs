//! Procedural fracture: break surfaces in wood, cracks, and cutting a mesh along them.
#![deny(missing_docs)]

mod board;
pub mod cracks;
pub mod cut;
mod ends;
mod even;
mod field;
pub mod height_grid;
mod height_model;
pub mod heights;
pub mod layout;
mod limit;
mod outline;
pub mod parameters;
mod plates;
pub mod presets;
mod rays;
pub mod recipe;
mod slabs;
pub mod splinters;
mod strips;
pub mod surface;
mod thorns;
mod torn;
mod wedge;
