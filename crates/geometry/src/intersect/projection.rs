//! Triangles projected along an axis, which preserves the side of every line on which a point of the plane lies.

use super::predicates::orient2d;
use glam::{DVec2, DVec3};

/// `p` without its coordinate `drop`.
pub(super) fn flatten(p: DVec3, drop: usize) -> DVec2 {
    DVec2::new(p[(drop + 1) % 3], p[(drop + 2) % 3])
}

/// The triangle without coordinate `drop`, counter-clockwise; `None` if it has no area then.
pub(super) fn project(t: &[DVec3; 3], drop: usize) -> Option<[DVec2; 3]> {
    let [a, b, c] = t.map(|p| flatten(p, drop));
    match orient2d(a, b, c) {
        o if o > 0.0 => Some([a, b, c]),
        o if o < 0.0 => Some([a, c, b]),
        _ => None,
    }
}

/// The coordinate to drop so that the triangle keeps an area; `None` if it has none.
pub(super) fn dropped_axis(t: &[DVec3; 3]) -> Option<usize> {
    let most = normal_axis(t);
    (most..most + 3)
        .map(|k| k % 3)
        .find(|&k| project(t, k).is_some())
}

/// The axis along which the normal of the triangle is longest.
pub(super) fn normal_axis(t: &[DVec3; 3]) -> usize {
    let normal = (t[1] - t[0]).cross(t[2] - t[0]).abs();
    (0..3)
        .max_by(|&a, &b| normal[a].total_cmp(&normal[b]))
        .unwrap_or(0)
}

/// Whether three points lie exactly on a line; two equal points always do.
pub fn collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    // The rounded product often shows that they do not: rounding changes it by less than 1e-15 of the bound.
    let (ab, ac) = (b - a, c - a);
    let size = a.abs().max(b.abs()).max(c.abs()).max_element();
    if ab.cross(ac).abs().max_element() > 1e-14 * size * (ab.abs() + ac.abs()).max_element() {
        return false;
    }
    (0..3).all(|drop| project(&[a, b, c], drop).is_none())
}
