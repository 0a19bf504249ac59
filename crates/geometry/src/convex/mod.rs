//! Convex shapes for engines: hulls of points, and solids as unions of few of them.

mod hull;
mod parts;

pub use hull::{FINEST, HullLimits, hull, is_convex};
pub use parts::{ConvexOptions, ConvexParts, convex_parts};
