//! Closed, textured meshes from what fracture produces.
#![deny(missing_docs)]

pub mod face;
pub mod halve;
pub mod pieces;
pub mod rods;
pub mod settle;
pub mod texture;
pub mod untangle;
pub mod wind;
