//! Quadric error metrics (Garland & Heckbert 1997, Surface Simplification Using Quadric Error Metrics).

use glam::{DMat3, DVec3};
use std::ops::AddAssign;

/// A sum of weighted squared distances from planes, as a function of position.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Quadric {
    matrix: DMat3,
    vector: DVec3,
    constant: f64,
    /// Sum of the weights.
    pub weight: f64,
}

impl Quadric {
    pub const ZERO: Quadric = Quadric {
        matrix: DMat3::ZERO,
        vector: DVec3::ZERO,
        constant: 0.0,
        weight: 0.0,
    };

    /// The weighted squared distance from the plane through `point` with the unit normal `normal`.
    pub fn from_plane(normal: DVec3, point: DVec3, weight: f64) -> Quadric {
        let offset = -normal.dot(point);
        let scaled = normal * weight;
        Quadric {
            matrix: DMat3::from_cols(scaled * normal.x, scaled * normal.y, scaled * normal.z),
            vector: scaled * offset,
            constant: weight * offset * offset,
            weight,
        }
    }

    /// Evaluates the sum at `p`; rounding never makes it negative.
    pub fn evaluate(&self, p: DVec3) -> f64 {
        (p.dot(self.matrix * p) + 2.0 * self.vector.dot(p) + self.constant).max(0.0)
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Quadric) {
        self.matrix += other.matrix;
        self.vector += other.vector;
        self.constant += other.constant;
        self.weight += other.weight;
    }
}
