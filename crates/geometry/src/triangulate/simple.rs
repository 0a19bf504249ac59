//! Whether rings of edges meet nowhere but at common ends.

use crate::intersect::orient2d;
use glam::DVec2;

/// The point after `i` in its ring.
pub(super) fn next(i: usize, count: usize, hole_starts: &[usize]) -> usize {
    // Rings are few: a linear search is quicker than a table.
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

/// Two edges, named by their first points, that meet elsewhere than in a common end.
pub(super) fn crossing(
    points: &[DVec2],
    hole_starts: &[usize],
    by_left: &mut Vec<u32>,
) -> Option<(usize, usize)> {
    let count = points.len();
    let ends = |i: usize| {
        let j = if hole_starts.is_empty() && i + 1 < count {
            i + 1
        } else {
            next(i, count, hole_starts)
        };
        (points[i], points[j], j)
    };
    if count <= 24 {
        return (0..count).find_map(|i| {
            (0..i)
                .find(|&j| meet(i, ends(i), j, ends(j)))
                .map(|j| (j, i))
        });
    }
    let left = |i: usize| {
        let (p, q, _) = ends(i);
        p.x.min(q.x)
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
        let (p, q, _) = ends(i);
        let right = p.x.max(q.x);
        for &j in &by_left[k + 1..] {
            let j = j as usize;
            if left(j) > right {
                break;
            }
            if meet(i, ends(i), j, ends(j)) {
                return Some((i.min(j), i.max(j)));
            }
        }
    }
    None
}

/// Whether edges `i` and `j`, given with their ends and the number of the second one, meet where they should not.
fn meet(
    i: usize,
    (a, b, after_i): (DVec2, DVec2, usize),
    j: usize,
    (c, d, after_j): (DVec2, DVec2, usize),
) -> bool {
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
    match (after_i == j, after_j == i) {
        // A triangle's ring has no such pair; two edges that are both before and after each other are one.
        (true, true) => true,
        (true, false) => folds_back(a, b, d),
        (false, true) => folds_back(c, d, b),
        _ => segments_meet(a, b, c, d),
    }
}

/// Whether the edge from `b` to `c` runs back along that from `a` to `b`.
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    let way = |to: DVec2| (to.x.partial_cmp(&b.x), to.y.partial_cmp(&b.y));
    way(a) == way(c) && orient2d(a, b, c) == 0.0
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
    // On one line they meet where their boxes do; otherwise both have been found to reach the other's line.
    a.x.min(b.x) <= c.x.max(d.x)
        && c.x.min(d.x) <= a.x.max(b.x)
        && a.y.min(b.y) <= c.y.max(d.y)
        && c.y.min(d.y) <= a.y.max(b.y)
}

/// Two points at one position.
pub(super) fn repeated(points: &[DVec2]) -> Option<(usize, usize)> {
    (0..points.len()).find_map(|i| (0..i).find(|&j| points[i] == points[j]).map(|j| (j, i)))
}

/// Whether a simple ring runs clockwise: exactly, by the turn at its lowest point.
pub(super) fn clockwise(ring: &[DVec2]) -> bool {
    let n = ring.len();
    let below = |&a: &usize, &b: &usize| {
        ring[a]
            .x
            .total_cmp(&ring[b].x)
            .then(ring[a].y.total_cmp(&ring[b].y))
    };
    let Some(lowest) = (0..n).min_by(below) else {
        return false;
    };
    // Neighbours in a straight run through the extreme point do not occur: the point would not be extreme.
    orient2d(
        ring[(lowest + n - 1) % n],
        ring[lowest],
        ring[(lowest + 1) % n],
    ) < 0.0
}
