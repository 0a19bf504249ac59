//! Rings as closed curves.

use glam::DVec2;
use std::f64::consts::TAU;

/// Points of a ring's curve, and directions in which rings are compared.
pub(super) const CURVE_POINTS: usize = 360;

/// The outer contour of a ring.
#[derive(Debug, Clone, PartialEq)]
pub struct RingCurve {
    /// Mean radius about the pith.
    pub mean_radius: f64,
    /// Its points.
    pub points: Vec<DVec2>,
}

/// Radii of a closed curve about `pith` at [`CURVE_POINTS`] equal angles, the farthest where there are more.
pub(super) fn radii(curve: &[DVec2], pith: DVec2) -> Vec<f64> {
    (0..CURVE_POINTS)
        .map(|i| {
            let (sin, cos) = libm::sincos(TAU * i as f64 / CURVE_POINTS as f64);
            let direction = DVec2::new(cos, sin);
            let crossings = (0..curve.len()).filter_map(|j| {
                let (a, b) = (curve[j] - pith, curve[(j + 1) % curve.len()] - pith);
                let (u, v) = (direction.perp_dot(a), direction.perp_dot(b));
                ((u > 0.0) != (v > 0.0)).then(|| direction.dot(a + (b - a) * (u / (u - v))))
            });
            crossings.fold(0.0, f64::max)
        })
        .collect()
}

/// Mean of radii at equal angles.
pub(super) fn mean(radii: &[f64]) -> f64 {
    radii.iter().sum::<f64>() / radii.len() as f64
}
