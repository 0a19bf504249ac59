//! Whether the edges of rings meet only at common ends, and the orientation of rings.

use crate::intersect::orient2d;
use glam::DVec2;

/// Most points of polygons whose edges are all compared with each other: sorting does not pay.
const MAX_EXHAUSTIVE: usize = 24;

/// The index of the point after `i` in its ring.
pub(super) fn next_in_ring(i: usize, count: usize, hole_starts: &[usize]) -> usize {
    // There are few rings: a linear search is faster than a table.
    let mut start = 0;
    for &hole in hole_starts {
        if i + 1 == hole {
            return start;
        }
        if i < hole {
            break;
        }
        start = hole;
    }
    if i + 1 == count { start } else { i + 1 }
}

/// Finds two edges, given by their first points, that meet elsewhere than at a common end.
pub(super) fn find_crossing(
    points: &[DVec2],
    hole_starts: &[usize],
    by_left: &mut Vec<u32>,
) -> Option<(usize, usize)> {
    let count = points.len();
    let edge = |i: usize| {
        let j = if hole_starts.is_empty() && i + 1 < count {
            i + 1
        } else {
            next_in_ring(i, count, hole_starts)
        };
        Edge {
            first: i,
            last: j,
            from: points[i],
            to: points[j],
        }
    };
    if count <= MAX_EXHAUSTIVE {
        return (0..count).find_map(|i| {
            (0..i)
                .find(|&j| meet_wrongly(&edge(i), &edge(j)))
                .map(|j| (j, i))
        });
    }
    let left = |i: usize| {
        let Edge { from, to, .. } = edge(i);
        from.x.min(to.x)
    };
    by_left.clear();
    by_left.extend(0..count as u32);
    by_left.sort_unstable_by(|&a, &b| {
        left(a as usize)
            .total_cmp(&left(b as usize))
            .then(a.cmp(&b))
    });
    for (k, &i) in by_left.iter().enumerate() {
        let i = i as usize;
        let Edge { from, to, .. } = edge(i);
        let right = from.x.max(to.x);
        for &j in &by_left[k + 1..] {
            let j = j as usize;
            if left(j) > right {
                break;
            }
            if meet_wrongly(&edge(i), &edge(j)) {
                return Some((i.min(j), i.max(j)));
            }
        }
    }
    None
}

/// An edge of a ring.
struct Edge {
    /// Indices of its end points.
    first: usize,
    last: usize,
    /// Their positions.
    from: DVec2,
    to: DVec2,
}

/// Whether two different edges meet elsewhere than at a common end.
fn meet_wrongly(first: &Edge, second: &Edge) -> bool {
    let ([a, b], [c, d]) = ([first.from, first.to], [second.from, second.to]);
    if a.x.max(b.x) < c.x.min(d.x)
        || c.x.max(d.x) < a.x.min(b.x)
        || a.y.max(b.y) < c.y.min(d.y)
        || c.y.max(d.y) < a.y.min(b.y)
    {
        return false;
    }
    if a == b || c == d {
        return true;
    }
    match (first.last == second.first, second.last == first.first) {
        // Two edges that each start where the other ends coincide.
        (true, true) => true,
        (true, false) => folds_back(a, b, d),
        (false, true) => folds_back(c, d, b),
        _ => segments_meet(a, b, c, d),
    }
}

/// Whether the edge from `b` to `c` runs back along that from `a` to `b`.
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    let direction = |to: DVec2| (to.x.partial_cmp(&b.x), to.y.partial_cmp(&b.y));
    direction(a) == direction(c) && orient2d(a, b, c) == 0.0
}

/// Whether two segments share a point.
pub(super) fn segments_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let (s, t) = (orient2d(a, b, c), orient2d(a, b, d));
    if (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0) {
        return false;
    }
    let (u, v) = (orient2d(c, d, a), orient2d(c, d, b));
    if (u > 0.0 && v > 0.0) || (u < 0.0 && v < 0.0) {
        return false;
    }
    // On one line they meet if their boxes do; otherwise each reaches the line of the other.
    a.x.min(b.x) <= c.x.max(d.x)
        && c.x.min(d.x) <= a.x.max(b.x)
        && a.y.min(b.y) <= c.y.max(d.y)
        && c.y.min(d.y) <= a.y.max(b.y)
}

/// Finds two points at one position.
pub(super) fn find_repeated(points: &[DVec2]) -> Option<(usize, usize)> {
    (0..points.len()).find_map(|i| (0..i).find(|&j| points[i] == points[j]).map(|j| (j, i)))
}

/// Whether a simple ring runs clockwise, decided exactly by the turn at its leftmost point.
pub(super) fn is_clockwise(ring: &[DVec2]) -> bool {
    let n = ring.len();
    let left_of = |&a: &usize, &b: &usize| {
        ring[a]
            .x
            .total_cmp(&ring[b].x)
            .then(ring[a].y.total_cmp(&ring[b].y))
    };
    let Some(leftmost) = (0..n).min_by(left_of) else {
        return false;
    };
    // No straight run passes through the leftmost point.
    orient2d(
        ring[(leftmost + n - 1) % n],
        ring[leftmost],
        ring[(leftmost + 1) % n],
    ) < 0.0
}

/// Whether a ring runs clockwise, if it consists of two chains that each run from its leftmost point to its rightmost (of
/// points above each other, the lower counts as left) and meet at these two points only; `None` if it does not. No two
/// edges of such a ring meet but at common ends.
///
/// Chains are compared where either has a point. Between two of these both are straight, so that they do not meet there
/// unless they change sides.
pub(super) fn monotone_orientation(ring: &[DVec2]) -> Option<bool> {
    let n = ring.len();
    let is_left = |a: DVec2, b: DVec2| a.x < b.x || (a.x == b.x && a.y < b.y);
    let (mut leftmost, mut rightmost) = (None, None);
    let mut rose = is_left(ring[n - 2], ring[n - 1]);
    let mut at = n - 1;
    for next in 0..n {
        if ring[at] == ring[next] {
            return None;
        }
        let rises = is_left(ring[at], ring[next]);
        if rises != rose {
            let end = if rises { &mut leftmost } else { &mut rightmost };
            if end.replace(at).is_some() {
                return None;
            }
        }
        (at, rose) = (next, rises);
    }
    let (leftmost, rightmost) = (leftmost?, rightmost?);
    let after = |i: usize| if i + 1 == n { 0 } else { i + 1 };
    let before = |i: usize| if i == 0 { n - 1 } else { i - 1 };
    // The last points passed, and the next, of the chain that runs forward and of the one that runs back.
    let (mut forward, mut back) = (ring[leftmost], ring[leftmost]);
    let (mut i, mut j) = (after(leftmost), before(leftmost));
    let mut clockwise = None;
    while i != rightmost || j != rightmost {
        let (p, q) = (ring[i], ring[j]);
        // Above zero where the chain that runs back lies above the other.
        let side = if is_left(p, q) {
            let side = -orient2d(back, q, p);
            (forward, i) = (p, after(i));
            side
        } else if is_left(q, p) {
            let side = orient2d(forward, p, q);
            (back, j) = (q, before(j));
            side
        } else {
            return None;
        };
        if side == 0.0 || clockwise.is_some_and(|known| known != (side < 0.0)) {
            return None;
        }
        clockwise = Some(side < 0.0);
    }
    clockwise
}

/// Whether all points lie exactly on one line.
pub(super) fn are_collinear(points: &[DVec2]) -> bool {
    let Some(&other) = points.iter().find(|&&p| p != points[0]) else {
        return true;
    };
    points.iter().all(|&p| orient2d(points[0], other, p) == 0.0)
}
