//! Exact signs of areas and volumes.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// Positive where `a`, `b`, `c` turn counter-clockwise, negative where clockwise, zero exactly where they lie on a
/// line. The size is about twice the area.
#[inline]
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    robust::orient2d(a, b, c)
}

/// Positive where `d` lies on the side of the plane of `a`, `b`, `c` from which these turn clockwise, negative on the
/// other, zero exactly where all four lie in a plane. The size is about six times the volume.
#[inline]
pub fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    // Faces along the axes are frequent, and the adaptive predicate is slowest for exact zeros.
    let flat = |k: usize| (a[k] == d[k]) & (b[k] == d[k]) & (c[k] == d[k]);
    if flat(0) || flat(1) || flat(2) {
        return 0.0;
    }
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    robust::orient3d(a, b, c, d)
}

/// Whether three points lie exactly on a line, two of them being equal included.
pub fn collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    // Far from collinear by the rounded product already: rounding changes it by less than 1e-15 of the bound.
    let (ab, ac) = (b - a, c - a);
    let size = a.abs().max(b.abs()).max(c.abs()).max_element();
    if ab.cross(ac).abs().max_element() > 1e-14 * size * (ab.abs() + ac.abs()).max_element() {
        return false;
    }
    (0..3).all(|drop| super::flat::project(&[a, b, c], drop).is_none())
}
