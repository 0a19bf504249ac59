//! The contact of two triangles.

use super::predicates::{orient2d, orient3d};
use super::projection::collinear;
use super::{Contact, coplanar, projection};
use glam::DVec3;

/// Returns how triangles `a` and `b` meet. Vertices at equal positions are shared: triangles that share a vertex meet
/// only if they do so elsewhere, triangles that share an edge only if they are folded onto each other. A triangle without
/// area has no interior and meets nothing.
///
/// ```
/// use glam::DVec3;
/// use greenstick_geometry::intersect::{Contact, contact};
///
/// let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let standing = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 1.0)];
/// assert_eq!(contact(floor, standing), Contact::Touching);
/// assert_eq!(contact(floor, standing.map(|p| p - DVec3::Z * 0.1)), Contact::Crossing);
/// ```
pub fn contact(a: [DVec3; 3], b: [DVec3; 3]) -> Contact {
    let (a, b, shared) = shared_first(a, b);
    match shared {
        0 => contact_without_shared_edge(&a, &b, false),
        1 => contact_without_shared_edge(&a, &b, true),
        2 => contact_across_edge(&a, &b),
        _ if collinear(a[0], a[1], a[2]) => Contact::Apart,
        _ => Contact::Crossing,
    }
}

/// Reorders both triangles so that the vertices that they share come first, in the same order. Also returns the number
/// of shared vertices.
fn shared_first(mut a: [DVec3; 3], mut b: [DVec3; 3]) -> ([DVec3; 3], [DVec3; 3], usize) {
    let mut shared = 0;
    for i in 0..3 {
        if let Some(j) = (shared..3).find(|&j| a[i] == b[j]) {
            a.swap(shared, i);
            b.swap(shared, j);
            shared += 1;
        }
    }
    (a, b, shared)
}

/// The plane of a triangle, on one side of which others mostly lie.
pub(crate) struct Plane {
    origin: DVec3,
    normal: DVec3,
    /// Bound of the rounding error of a point's height, per distance of the point from `origin`.
    error: f64,
}

impl Plane {
    pub(crate) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        Plane {
            origin: a,
            normal: u.cross(v),
            // 45 times the rounding error of one operation; the determinant takes 14 operations.
            error: 1e-14 * u.abs().element_sum() * v.abs().element_sum(),
        }
    }

    /// Whether there are points, and all lie so far on one side that rounding cannot matter. Decides most pairs of triangles
    /// at a fraction of the cost of the exact predicate.
    #[inline]
    pub(crate) fn is_clearly_beside(&self, points: impl IntoIterator<Item = DVec3>) -> bool {
        let (mut above, mut below, mut any) = (true, true, false);
        for p in points {
            let w = p - self.origin;
            let (value, bound) = (
                self.normal.dot(w),
                self.error * w.abs().element_sum() + f64::MIN_POSITIVE,
            );
            above &= value > bound;
            below &= value < -bound;
            any = true;
        }
        any && (above || below)
    }

    /// As [`Plane::is_clearly_beside`], of the points that are not marked. Without branches: of most pairs it is called for nothing
    /// else is asked.
    #[inline]
    pub(crate) fn is_clearly_beside_but(&self, points: [(DVec3, bool); 3]) -> bool {
        let (mut above, mut below, mut any) = (true, true, false);
        for (p, left_out) in points {
            let w = p - self.origin;
            let (value, bound) = (
                self.normal.dot(w),
                self.error * w.abs().element_sum() + f64::MIN_POSITIVE,
            );
            above &= left_out | (value > bound);
            below &= left_out | (value < -bound);
            any |= !left_out;
        }
        any & (above | below)
    }
}

/// Whether all corners of `of` (but the first, if it is shared) lie clearly on one side of the plane of `plane`.
fn clearly_on_one_side(plane: &[DVec3; 3], of: &[DVec3; 3], share_vertex: bool) -> bool {
    Plane::new(*plane).is_clearly_beside(of[usize::from(share_vertex)..].iter().copied())
}

/// The contact of triangles that share the edge from their first to their second vertex.
fn contact_across_edge(a: &[DVec3; 3], b: &[DVec3; 3]) -> Contact {
    if clearly_on_one_side(a, &[b[2]; 3], false) || coplanar::separated_by_edge(a, b) {
        return Contact::Apart;
    }
    if orient3d(a[0], a[1], a[2], b[2]) != 0.0 {
        return Contact::Apart;
    }
    let Some(drop) = projection::dropped_axis(a).filter(|_| projection::dropped_axis(b).is_some())
    else {
        return Contact::Apart;
    };
    let side = |p: DVec3| {
        orient2d(
            projection::flatten(a[0], drop),
            projection::flatten(a[1], drop),
            projection::flatten(p, drop),
        )
    };
    if (side(a[2]) > 0.0) == (side(b[2]) > 0.0) {
        Contact::Crossing
    } else {
        Contact::Apart
    }
}

/// The sides of the plane of `plane` on which the corners of `of` lie: −1, 0 or 1; 0 for the vertex they share.
fn sides(plane: &[DVec3; 3], of: &[DVec3; 3], share_vertex: bool) -> [i8; 3] {
    let side = |p: DVec3| {
        let o = orient3d(plane[0], plane[1], plane[2], p);
        i8::from(o > 0.0) - i8::from(o < 0.0)
    };
    [
        if share_vertex { 0 } else { side(of[0]) },
        side(of[1]),
        side(of[2]),
    ]
}

/// Whether all corners that are not shared lie strictly on one side.
fn on_one_side(s: [i8; 3], share_vertex: bool) -> bool {
    let others = &s[usize::from(share_vertex)..];
    others.iter().all(|&x| x > 0) || others.iter().all(|&x| x < 0)
}

/// The contact of triangles that share no vertex, or only their first one.
fn contact_without_shared_edge(a: &[DVec3; 3], b: &[DVec3; 3], share_vertex: bool) -> Contact {
    if clearly_on_one_side(a, b, share_vertex)
        || clearly_on_one_side(b, a, share_vertex)
        || coplanar::separated(a, b, share_vertex)
    {
        return Contact::Apart;
    }
    let sa = sides(b, a, share_vertex);
    if on_one_side(sa, share_vertex) {
        return Contact::Apart;
    }
    let sb = sides(a, b, share_vertex);
    if on_one_side(sb, share_vertex) {
        return Contact::Apart;
    }
    if sa == [0; 3] || sb == [0; 3] {
        return match (projection::dropped_axis(a), projection::dropped_axis(b)) {
            (Some(drop), Some(_)) => coplanar::contact(a, b, drop, share_vertex),
            _ => Contact::Apart,
        };
    }
    match (lone_corner(sa), lone_corner(sb)) {
        (Some(i), Some(j)) => compare_intervals(a, i, b, j, share_vertex),
        // One of them reaches the plane of the other without crossing it.
        _ if edge_meets(a, sa, b, share_vertex) || edge_meets(b, sb, a, share_vertex) => {
            Contact::Touching
        }
        _ => Contact::Apart,
    }
}

/// The corner that is alone on its side, if corners lie on both sides.
fn lone_corner(s: [i8; 3]) -> Option<usize> {
    if !(s.contains(&1) && s.contains(&-1)) {
        return None;
    }
    let alone = |side: i8| s.iter().filter(|&&x| x == side).count() == 1;
    let side = if alone(1) { 1 } else { -1 };
    s.iter().position(|&x| x == side)
}

/// The contact of triangles that both have corners strictly on both sides of the other's plane; `i` and `j` are the
/// corners alone on their side. Each triangle meets the intersection line of the planes in an interval, between the edges
/// from its lone corner. For an edge of `a` that meets the line at p and one of `b` that meets it at q, the sign of
/// `orient3d` of the four end points is that of q − p, or its opposite for all pairs.
fn compare_intervals(
    a: &[DVec3; 3],
    i: usize,
    b: &[DVec3; 3],
    j: usize,
    share_vertex: bool,
) -> Contact {
    let (mut less, mut equal, mut more) = (false, false, false);
    for k in [(i + 1) % 3, (i + 2) % 3] {
        for l in [(j + 1) % 3, (j + 2) % 3] {
            let order = if share_vertex && k == 0 && l == 0 {
                0.0
            } else {
                orient3d(a[i], a[k], b[j], b[l])
            };
            less |= order < 0.0;
            more |= order > 0.0;
            equal |= order == 0.0;
        }
    }
    match (less && more, equal && !share_vertex) {
        (true, _) => Contact::Crossing,
        (_, true) => Contact::Touching,
        _ => Contact::Apart,
    }
}

/// Whether an edge of `a`, whose corners lie on the sides `s` of the plane of `b`, meets `b`. Edges in that plane are
/// skipped, because their ends belong to other edges, and so are edges at the shared vertex.
fn edge_meets(a: &[DVec3; 3], s: [i8; 3], b: &[DVec3; 3], share_vertex: bool) -> bool {
    let first = usize::from(share_vertex);
    (first..if share_vertex { 2 } else { 3 }).any(|i| {
        let j = (i + 1) % 3;
        if s[i] == s[j] {
            return false;
        }
        let turns = [0, 1, 2].map(|k| orient3d(a[i], a[j], b[k], b[(k + 1) % 3]));
        turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
    })
}
