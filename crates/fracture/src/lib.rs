//! Procedural fracture: the parameters of a broken face and of drying cracks, presets and recipes
//! for them.
#![deny(missing_docs)]

pub mod parameters;
pub mod presets;
pub mod recipe;
