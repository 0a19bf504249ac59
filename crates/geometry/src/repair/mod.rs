//! Repairs of meshes: closing seams, separating sheets at edges of more than two triangles, snapping to the precision of files, and
//! resolving self-intersections by bisecting or collapsing edges.

mod bisection;
mod collapse;
mod non_manifold;
mod scene;
mod seams;
mod self_intersections;
mod snap;
mod touching;
mod untangle;

pub use bisection::{EdgeBisector, crossing_pairs, crossing_pairs_within};
pub use collapse::{Collapsed, EdgeCollapser};
pub use non_manifold::separate_sheets;
pub use scene::repair_scene;
pub use seams::{ClosedSeams, SEAM_TOLERANCE, close_seams};
pub use self_intersections::{
    KnownPositions, Rounded, resolve_self_intersections, round_halves_to_f32, round_to_f32,
};
pub use snap::snap_to_f32;
pub use untangle::{Untangled, Untangler};
