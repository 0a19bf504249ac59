//! How far vertices have moved.

use crate::vectors::Vectors;

/// Returns the largest squared distance between the vectors of two lists, m²; NaN where there is one.
pub(super) fn moved_squared(a: &Vectors, b: &Vectors) -> f64 {
    let parts =
        a.x.iter()
            .zip(&b.x)
            .zip(a.y.iter().zip(&b.y))
            .zip(a.z.iter().zip(&b.z));
    parts.fold(0.0, |most: f64, (((ax, bx), (ay, by)), (az, bz))| {
        let (x, y, z) = (ax - bx, ay - by, az - bz);
        let d = x * x + y * y + z * z;
        if d > most || d.is_nan() { d } else { most }
    })
}
