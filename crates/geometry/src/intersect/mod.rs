//! Whether two triangles meet, and whether they cross or only touch, decided exactly.
//!
//! All decisions are signs of Shewchuk's adaptive predicates (1997, Adaptive Precision Floating-Point Arithmetic), so
//! there is no tolerance. The intervals that two triangles cut out of the line common to their planes (Möller 1997, A
//! Fast Triangle-Triangle Intersection Test) are compared by the same predicates instead of by computed numbers.

mod flat;
mod mesh;
mod predicates;

pub use mesh::{contact_tree, contacts_between, self_contacts};
pub use predicates::{collinear, orient2d, orient3d};

use glam::DVec3;

/// How two triangles meet apart from what they share as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Contact {
    /// Not at all, or only in the vertex or the edge that they share.
    Apart,
    /// Without either passing through the other: in a point, along an edge.
    Touching,
    /// The insides meet: one passes through the other, or both lie in one plane and overlap.
    Crossing,
}

/// How triangles `a` and `b` meet. Vertices at equal positions are shared: triangles that share a vertex meet only if
/// they do so elsewhere, triangles that share an edge only if they lie folded onto each other. A triangle without area
/// has no inside and meets nothing.
pub fn contact(a: [DVec3; 3], b: [DVec3; 3]) -> Contact {
    let (a, b, shared) = shared_first(a, b);
    match shared {
        0 => apart_from_vertices(&a, &b, false),
        1 => apart_from_vertices(&a, &b, true),
        2 => folded(&a, &b),
        _ if collinear(a[0], a[1], a[2]) => Contact::Apart,
        _ => Contact::Crossing,
    }
}

/// Both triangles with the vertices that they share first, in the same order, and the number of these.
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

/// Whether all corners of `of` (but the first, where that is shared) are so far on one side of the plane of `plane`
/// that rounding cannot matter. Decides most pairs at a fraction of the exact predicate's cost.
fn clearly_on_one_side(plane: &[DVec3; 3], of: &[DVec3; 3], share_vertex: bool) -> bool {
    let (u, v) = (plane[1] - plane[0], plane[2] - plane[0]);
    let normal = u.cross(v);
    // 45 times the rounding error of one operation; the determinant takes 14.
    let size = 1e-14 * u.abs().element_sum() * v.abs().element_sum();
    let (mut above, mut below) = (true, true);
    for &p in &of[usize::from(share_vertex)..] {
        let w = p - plane[0];
        let (value, bound) = (
            normal.dot(w),
            size * w.abs().element_sum() + f64::MIN_POSITIVE,
        );
        above &= value > bound;
        below &= value < -bound;
    }
    above || below
}

/// Triangles that share the edge from their first to their second vertex.
fn folded(a: &[DVec3; 3], b: &[DVec3; 3]) -> Contact {
    if clearly_on_one_side(a, &[b[2]; 3], false) || flat::parted_by_edge(a, b) {
        return Contact::Apart;
    }
    if orient3d(a[0], a[1], a[2], b[2]) != 0.0 {
        return Contact::Apart;
    }
    let Some(drop) = flat::projection(a).filter(|_| flat::projection(b).is_some()) else {
        return Contact::Apart;
    };
    let side = |p: DVec3| {
        orient2d(
            flat::flatten(a[0], drop),
            flat::flatten(a[1], drop),
            flat::flatten(p, drop),
        )
    };
    if (side(a[2]) > 0.0) == (side(b[2]) > 0.0) {
        Contact::Crossing
    } else {
        Contact::Apart
    }
}

/// Sides of the plane of `plane` on which the corners of `of` lie: −1, 0 or 1. The vertex they share lies in it.
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

/// Whether all corners that are not shared lie on one side.
fn on_one_side(s: [i8; 3], share_vertex: bool) -> bool {
    let others = &s[usize::from(share_vertex)..];
    others.iter().all(|&x| x > 0) || others.iter().all(|&x| x < 0)
}

/// Triangles that share no vertex, or their first one.
fn apart_from_vertices(a: &[DVec3; 3], b: &[DVec3; 3], share_vertex: bool) -> Contact {
    if clearly_on_one_side(a, b, share_vertex)
        || clearly_on_one_side(b, a, share_vertex)
        || flat::parted(a, b, share_vertex)
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
        return match (flat::projection(a), flat::projection(b)) {
            (Some(drop), Some(_)) => flat::contact(a, b, drop, share_vertex),
            _ => Contact::Apart,
        };
    }
    match (lone(sa), lone(sb)) {
        (Some(i), Some(j)) => compare_intervals(a, i, b, j, share_vertex),
        // One of them reaches the other's plane without passing it.
        _ if edge_meets(a, sa, b, share_vertex) || edge_meets(b, sb, a, share_vertex) => {
            Contact::Touching
        }
        _ => Contact::Apart,
    }
}

/// The corner that is alone on its side, where corners lie on both sides.
fn lone(s: [i8; 3]) -> Option<usize> {
    if !(s.contains(&1) && s.contains(&-1)) {
        return None;
    }
    let alone = |side: i8| s.iter().filter(|&&x| x == side).count() == 1;
    let side = if alone(1) { 1 } else { -1 };
    s.iter().position(|&x| x == side)
}

/// Triangles that both have corners strictly on both sides of the other's plane. Each cuts an interval out of the
/// common line, between the edges from its lone corner. For an edge of `a` that meets the line at p and one of `b`
/// that meets it at q, the sign of `orient3d` of the four end points is that of q − p, or its opposite for all pairs.
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

/// Whether an edge of `a`, whose corners lie on the sides `s` of the plane of `b`, meets `b`. Edges within that plane
/// are left out, as their ends belong to other edges; so are edges at the shared vertex.
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

#[cfg(test)]
mod tests;
