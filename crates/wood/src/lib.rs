//! Wood: the stem and the address of a point in it, species with their measured properties,
//! moisture and tissue.
#![deny(missing_docs)]

pub mod anatomy;
pub mod appearance;
pub mod branch;
pub mod colour;
pub mod moisture;
pub mod noise;
pub mod polygon;
pub mod primitive;
pub mod raster;
pub mod rings;
pub mod scan;
pub mod species;
pub mod structure;

pub mod stem;
pub mod tissue;

/// The sizes of what a stem is looked for in, m: from a wood cell to a hundred trees in millimetres. What lies beyond is
/// damage or a wrong unit, and counts that follow from lengths would fill the memory.
pub const EXTENT_RANGE: (f64, f64) = (1e-6, 1e6);
