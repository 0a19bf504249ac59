//! From a stem to a bundle: rods along the grain, their cells, and bonds between neighbours (Sutherland 2012 §3.3; physical
//! constants of the modules).
//!
//! | module | content |
//! |---|---|
//! | `options` | [`PlacementOptions`] |
//! | `fill` | [`fill_stem`]: points, cells, rods and bonds, with the taper of the stem |
//! | `points` | where rods pierce a cross-section |
//! | `voronoi` | [`VoronoiCell`]: the cells of these points |
//! | `neighbours` | which rods are bonded |
//! | `bonding` | bonds between neighbouring cells |
//! | `material` | [`WoodMaterial`]: elasticity and strength of a species |
//! | `section_wood` | [`RodWood`]: the wood of each rod, from the structure of the stem |
//! | `section_moment` | the bending moment that a section of rods bears |
//! | `grain` | rods whose grain is not along the stem |
//! | `scatter` | Weibull scatter of strength |

mod bonding;
mod fill;
mod grain;
mod material;
mod neighbours;
mod options;
mod points;
mod scatter;
mod section_moment;
mod section_wood;
#[cfg(test)]
mod structure_tests;
#[cfg(test)]
mod tests;
mod voronoi;

pub(crate) use bonding::{FacetMaterial, NearestPoint};
pub use fill::{PlacedRods, fill_stem, fill_structured_stem};
pub(crate) use material::RelativeWood;
pub use material::{WoodMaterial, strength_at};
pub use options::{
    Arrangement, EdgeLengths, FineEdges, Neighbours, PlacementError, PlacementOptions, RodCount,
};
pub(crate) use points::poisson_disk;
pub(crate) use scatter::weibull;
pub(crate) use section_moment::{Element, relative_capacities, relative_demands};
pub use section_wood::RodWood;
pub use voronoi::{Facet, VoronoiCell, voronoi_cells};
