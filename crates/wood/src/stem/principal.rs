//! The principal directions of a shell: those in which its surface spreads most and least.

use super::surface::Surface;
use glam::{DMat3, DVec3};

/// Triangles that are evenly taken: some ten thousand show the directions of any mesh.
const SAMPLES: usize = 20_000;

/// The centroid of a shell's surface and its principal directions.
pub(crate) struct PrincipalAxes {
    /// Centroid, m.
    pub centroid: DVec3,
    /// Unit vectors, that of the largest spread first, the smallest last.
    pub directions: [DVec3; 3],
}

impl PrincipalAxes {
    /// The axes of a surface by its second moments of area.
    pub fn new(surface: &Surface) -> Self {
        let stride = (surface.len() / SAMPLES).max(1);
        let (mut weight, mut centroid) = (0.0, DVec3::ZERO);
        for i in (0..surface.len()).step_by(stride) {
            let [a, b, c] = surface.corners(i);
            let area = (b - a).cross(c - a).length();
            weight += area;
            centroid += (a + b + c) * (area / 3.0);
        }
        centroid /= weight.max(f64::MIN_POSITIVE);
        let mut spread = DMat3::ZERO;
        for i in (0..surface.len()).step_by(stride) {
            let [a, b, c] = surface.corners(i).map(|p| p - centroid);
            let area = (b - a).cross(c - a).length();
            // Second moment of a triangle from its corners and its middle, so that coarse meshes count right.
            let m = (a + b + c) / 3.0;
            spread +=
                (outer_product(a) + outer_product(b) + outer_product(c) + outer_product(m) * 9.0)
                    * (area / 12.0);
        }
        let longest = dominant_eigenvector(spread);
        let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        let shortest = dominant_eigenvector(DMat3::from_diagonal(DVec3::splat(trace)) - spread);
        let shortest = shortest.reject_from(longest).try_normalize();
        let shortest = shortest.unwrap_or_else(|| longest.any_orthonormal_vector());
        PrincipalAxes {
            centroid,
            directions: [longest, shortest.cross(longest), shortest],
        }
    }
}

/// Eigenvector of the largest eigenvalue of a symmetric matrix, by repeated squaring.
fn dominant_eigenvector(mut matrix: DMat3) -> DVec3 {
    for _ in 0..12 {
        let size = matrix
            .to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        if size == 0.0 {
            return DVec3::Y;
        }
        matrix *= 1.0 / size;
        matrix *= matrix;
    }
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let mut best = columns[0];
    for c in columns {
        if c.length_squared() > best.length_squared() {
            best = c;
        }
    }
    best.try_normalize().unwrap_or(DVec3::Y)
}

fn outer_product(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}
