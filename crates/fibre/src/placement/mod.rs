//! From a stem to a bundle: rods along the grain, their cells, and bonds between neighbours (Sutherland 2012 §3.3; physical
//! constants of the modules).
//!
//! | module | content |
//! |---|---|
//! | `options` | [`PlacementOptions`] |
//! | `fill` | [`fill_stem`]: points, cells, rods and bonds, with the taper of the stem |
//! | `points` | where rods pierce a cross-section |
//! | `voronoi` | [`VoronoiCell`]: the cells of these points |
//! | `bonding` | bonds between neighbouring cells |
//! | `material` | [`WoodMaterial`]: elasticity and strength of a species |
//! | `scatter` | Weibull scatter of strength |

mod bonding;
mod fill;
mod material;
mod options;
mod points;
mod scatter;
#[cfg(test)]
mod tests;
mod voronoi;

pub use fill::{PlacedRods, fill_stem};
pub use material::{WoodMaterial, strength_at};
pub use options::{Arrangement, EdgeLengths, PlacementError, PlacementOptions, RodCount};
pub use voronoi::{Facet, VoronoiCell, voronoi_cells};
