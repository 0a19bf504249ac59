//! Orientation predicates with exact signs.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// Positive where `a`, `b`, `c` turn counter-clockwise, negative where clockwise, zero exactly where they lie on a
/// line. The magnitude is about twice the area of the triangle.
#[inline]
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    robust::orient2d(a, b, c)
}

/// Positive where `d` lies on the side of the plane of `a`, `b`, `c` from which these turn clockwise, negative on the
/// other, zero exactly where all four lie in a plane. The magnitude is about six times the volume of the tetrahedron.
#[inline]
pub fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    // Faces perpendicular to an axis are frequent, and the adaptive predicate is slowest for exact zeros.
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
