//! Convex shapes for physics engines: hulls of points, and solids as unions of a few convex shapes.

mod hull;
mod parts;

pub use hull::{HullLimits, convex_hull, is_convex};
pub use parts::{ConvexOptions, ConvexParts, convex_parts};
