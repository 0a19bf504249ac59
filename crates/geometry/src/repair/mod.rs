//! Repairs of meshes: snapping to the precision of files, and resolving self-intersections by bisecting or collapsing
//! edges.

mod bisection;
mod collapse;
mod self_intersections;
mod snap;

pub use bisection::{EdgeBisector, crossing_pairs, crossing_pairs_within};
pub use collapse::{Collapsed, EdgeCollapser};
pub use self_intersections::{KnownPositions, resolve_self_intersections};
pub use snap::snap_to_f32;
