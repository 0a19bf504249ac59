//! The stem: a curved axis with sections, and the address (ring coordinate, angle, length) of every point in it.

mod axis;
mod grain;

pub use axis::{Axis, Frame};
pub use grain::GrainSpace;
