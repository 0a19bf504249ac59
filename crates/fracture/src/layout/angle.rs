//! Angles about the pith.

use std::f64::consts::{PI, TAU};

/// Returns an angle (rad) brought to −π … π.
///
/// ```
/// use greenstick_fracture::layout::wrap_angle;
///
/// assert!((wrap_angle(7.0) - (7.0 - std::f64::consts::TAU)).abs() < 1e-12);
/// ```
#[inline]
pub fn wrap_angle(angle: f64) -> f64 {
    if (-PI..PI).contains(&angle) {
        return angle;
    }
    angle - TAU * ((angle + PI) / TAU).floor()
}
