//! Mixing colours and numbers, and what is left of detail from afar.

use crate::noise::smoothstep;
use glam::DVec3;

/// Linear interpolation of colours.
pub(super) fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}

/// Linear interpolation of numbers.
pub(super) fn mix_scalar(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// How much of a figure of the given size is left when averaged over a footprint, 0 to 1.
pub(super) fn visible_detail(size: f64, footprint: f64) -> f64 {
    1.0 - smoothstep(0.4, 1.2, footprint / size)
}
