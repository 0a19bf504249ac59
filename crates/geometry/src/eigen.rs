//! Eigenvectors of symmetric 3 × 3 matrices by Jacobi rotations (Golub and Van Loan 2013, Matrix Computations, §8.5):
//! sums, products, quotients and square roots only, so that every machine gives the same bits.

use glam::{DMat3, DVec3};

/// Returns the eigenvalues of a symmetric matrix, ascending, with their unit eigenvectors.
///
/// ```
/// use glam::{DMat3, DVec3};
/// use greenstick_geometry::symmetric_eigen;
///
/// let [(least, axis), ..] = symmetric_eigen(DMat3::from_diagonal(DVec3::new(2.0, 1.0, 3.0)));
/// assert_eq!((least, axis.abs()), (1.0, DVec3::Y));
/// ```
pub fn symmetric_eigen(matrix: DMat3) -> [(f64, DVec3); 3] {
    // Convergence is quadratic; about six sweeps suffice.
    const MAX_SWEEPS: usize = 12;
    let mut a = matrix.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..MAX_SWEEPS {
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        let on = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
        if off <= 1e-30 * on {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                let (x, y) = (row[p], row[q]);
                (row[p], row[q]) = (c * x - s * y, s * x + c * y);
            }
            for k in 0..3 {
                let (x, y) = (a[p][k], a[q][k]);
                (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
                let (x, y) = (v[p][k], v[q][k]);
                (v[p][k], v[q][k]) = (c * x - s * y, s * x + c * y);
            }
        }
    }
    let mut pairs = [0, 1, 2].map(|k| (a[k][k], DVec3::from_array(v[k])));
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_scaled_by_their_eigenvalues() {
        for matrix in [
            DMat3::from_cols_array(&[2.0, 1.0, 0.5, 1.0, 3.0, -0.7, 0.5, -0.7, 1.0]),
            DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)),
            DMat3::from_cols_array(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
        ] {
            let pairs = symmetric_eigen(matrix);
            for (value, vector) in pairs {
                assert!((matrix * vector - vector * value).length() < 1e-12);
                assert!((vector.length() - 1.0).abs() < 1e-12);
            }
            assert!(pairs[0].0 <= pairs[1].0 && pairs[1].0 <= pairs[2].0);
        }
    }
}
