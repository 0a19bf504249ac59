//! Quadrilaterals, and the choice of their diagonal.

use crate::intersect::orient2d;
use glam::DVec2;

/// Whether the diagonal of the quadrilateral a, b, c, d (counter-clockwise, convex) should run from b to d instead of
/// from a to c: whether d lies inside the circle through a, b, c, beyond rounding. This does without the exact predicate,
/// which is slow for points on one circle, a frequent case; only a certain flip is known to lower the lifted surface.
pub(super) fn better_flipped(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let [a, b, c] = [a - d, b - d, c - d];
    let (bc, ca, ab) = (b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
    let [la, lb, lc] = [a, b, c].map(DVec2::length_squared);
    let products = |p: DVec2, q: DVec2| (p.x * q.y).abs() + (p.y * q.x).abs();
    // Shewchuk's bound is 10 rounding errors of 1.1e-16.
    let bound = 4e-15 * (products(b, c) * la + products(c, a) * lb + products(a, b) * lc);
    la * bc + lb * ca + lc * ab > bound
}

/// Appends two triangles for a quadrilateral. Returns false if neither diagonal leaves two triangles of the same
/// orientation, because edges cross, all points lie on a line, or no diagonal ends in a straight angle.
pub(super) fn triangulate_quad([a, b, c, d]: [DVec2; 4], triangles: &mut Vec<[u32; 3]>) -> bool {
    let same = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    let (abc, acd) = (orient2d(a, b, c), orient2d(a, c, d));
    let (bcd, bda) = (orient2d(b, c, d), orient2d(b, d, a));
    let (first, second) = (same(abc, acd), same(bcd, bda));
    if !first && !second {
        return false;
    }
    let clockwise = if first { abc < 0.0 } else { bcd < 0.0 };
    // The sign of the circle test changes with the orientation.
    let flip = !first
        || second
            && if clockwise {
                better_flipped(a, d, c, b)
            } else {
                better_flipped(a, b, c, d)
            };
    let pair = if flip {
        [[1, 2, 3], [1, 3, 0]]
    } else {
        [[0, 1, 2], [0, 2, 3]]
    };
    triangles.extend(pair.map(|[i, j, k]| if clockwise { [i, k, j] } else { [i, j, k] }));
    true
}
