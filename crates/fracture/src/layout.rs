//! Layouts: a section split into fibre bundles, rings × sectors about the pith.
//!
//! The smooth layout is the grid of Yang 2019 §3.1. The fibrous layout gives every ring as many bundles as keep their
//! areas about equal, and shifts the bundles of neighbouring rings against each other like bricks: no more than three
//! meet at a corner, so however their heights fall, the steps between them form a manifold.

mod angle;
mod bundles;
mod dips;
mod fibrous;
mod nodes;
mod skin_depth;
mod smooth;

pub use angle::wrap_angle;
pub use bundles::{FibreBundle, FibreBundles, LayoutOptions};
pub(crate) use fibrous::BEYOND_BARK;
pub use fibrous::fibrous;
pub use skin_depth::{InnerEdge, SkinDepth, SkinPoint};
pub use smooth::smooth;
