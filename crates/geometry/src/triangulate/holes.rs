//! Bridges that join holes to the outer ring, so that a single ring remains.

use super::error::TriangulateError;
use super::simple::{are_collinear, find_crossing, is_clockwise, next_in_ring, segments_meet};
use crate::intersect::orient2d;
use glam::DVec2;

/// Joins all rings into one counter-clockwise ring through all points that runs along every bridge twice.
pub(super) fn joined_ring(
    points: &[DVec2],
    hole_starts: &[usize],
    by_left: &mut Vec<u32>,
) -> Result<Vec<u32>, TriangulateError> {
    let rings = rings(points, hole_starts)?;
    if let Some((i, j)) = find_crossing(points, hole_starts, by_left) {
        return Err(TriangulateError::Crossing(i, j));
    }
    for (k, ring) in rings.iter().enumerate().skip(1) {
        let p = points[ring.start];
        let within_another =
            (1..rings.len()).any(|l| l != k && is_inside(p, &points[rings[l].clone()]));
        if within_another || !is_inside(p, &points[rings[0].clone()]) {
            return Err(TriangulateError::HoleOutside(ring.start));
        }
    }
    let oriented = |k: usize| -> Vec<u32> {
        let mut order: Vec<u32> = rings[k].clone().map(|i| i as u32).collect();
        // The outer ring runs counter-clockwise, holes clockwise.
        if is_clockwise(&points[rings[k].clone()]) == (k == 0) {
            order.reverse();
        }
        order
    };
    let mut order = oriented(0);
    let mut remaining: Vec<usize> = (1..rings.len()).collect();
    let mut bridges: Vec<[DVec2; 2]> = Vec::new();
    while !remaining.is_empty() {
        let candidates = candidates(points, &order, &rings, &remaining);
        let Bridge { from, hole, to, .. } = candidates
            .into_iter()
            .find(|b| is_free(b, points, hole_starts, &order, &bridges))
            .ok_or(TriangulateError::Stuck(points.len()))?;
        let mut tour = oriented(hole);
        let start = tour.iter().position(|&i| i == to).unwrap_or(0);
        tour.rotate_left(start);
        bridges.push([points[order[from] as usize], points[to as usize]]);
        let back = [to, order[from]];
        order.splice(from + 1..from + 1, tour.into_iter().chain(back));
        remaining.retain(|&k| k != hole);
    }
    Ok(order)
}

/// The ranges of points of all rings.
fn rings(
    points: &[DVec2],
    hole_starts: &[usize],
) -> Result<Vec<std::ops::Range<usize>>, TriangulateError> {
    let mut rings = Vec::with_capacity(hole_starts.len() + 1);
    let mut start = 0;
    for &end in hole_starts.iter().chain([&points.len()]) {
        if end < start || end > points.len() {
            return Err(TriangulateError::BadHoleStart(end));
        }
        if end - start < 3 {
            return Err(TriangulateError::TooFew {
                start,
                count: end - start,
            });
        }
        if are_collinear(&points[start..end]) {
            return Err(TriangulateError::NoArea(start));
        }
        rings.push(start..end);
        start = end;
    }
    Ok(rings)
}

/// Whether `p`, which lies on no edge, is inside the ring, by the crossings of a ray to the right.
fn is_inside(p: DVec2, ring: &[DVec2]) -> bool {
    let crossings = (0..ring.len()).filter(|&i| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (a.y > p.y) != (b.y > p.y) && (orient2d(a, b, p) > 0.0) == (b.y > a.y)
    });
    crossings.count() % 2 == 1
}

/// A possible bridge from the joined ring to a hole.
#[derive(Clone, Copy)]
struct Bridge {
    length_squared: f64,
    /// Place in the order of the joined ring.
    from: usize,
    hole: usize,
    /// Point of the hole.
    to: u32,
}

/// All bridges from the joined ring to the remaining holes, the shortest first.
fn candidates(
    points: &[DVec2],
    order: &[u32],
    rings: &[std::ops::Range<usize>],
    remaining: &[usize],
) -> Vec<Bridge> {
    let mut candidates = Vec::new();
    for (from, &point) in order.iter().enumerate() {
        for &hole in remaining {
            candidates.extend(rings[hole].clone().map(|to| Bridge {
                length_squared: points[point as usize].distance_squared(points[to]),
                from,
                hole,
                to: to as u32,
            }));
        }
    }
    candidates.sort_unstable_by(|a, b| {
        a.length_squared
            .total_cmp(&b.length_squared)
            .then((a.from, a.to).cmp(&(b.from, b.to)))
    });
    candidates
}

/// Whether a bridge runs inside the polygon and meets neither edges nor other bridges.
fn is_free(
    bridge: &Bridge,
    points: &[DVec2],
    hole_starts: &[usize],
    order: &[u32],
    bridges: &[[DVec2; 2]],
) -> bool {
    let n = order.len();
    let point = |i: usize| points[order[i % n] as usize];
    let (p, q) = (point(bridge.from), points[bridge.to as usize]);
    in_corner(point(bridge.from + n - 1), p, point(bridge.from + 1), q)
        && (0..points.len()).all(|i| {
            let (a, b) = (
                points[i],
                points[next_in_ring(i, points.len(), hole_starts)],
            );
            is_clear(p, q, a, b)
        })
        && bridges.iter().all(|&[a, b]| is_clear(p, q, a, b))
}

/// Whether the segment from `p` to `q` meets the edge from `a` to `b` only at a common end.
fn is_clear(p: DVec2, q: DVec2, a: DVec2, b: DVec2) -> bool {
    let ends = [a, b];
    let common = ends.iter().filter(|&&e| e == p || e == q).count();
    match common {
        0 => !segments_meet(p, q, a, b),
        // Both start at the common end; they overlap if they have the same direction.
        1 => {
            let (e, other) = if a == p || a == q { (a, b) } else { (b, a) };
            let far = if e == p { q } else { p };
            orient2d(e, far, other) != 0.0 || (far - e).dot(other - e) < 0.0
        }
        _ => false,
    }
}

/// Whether `q` lies within the corner `before`, `p`, `after` with the inside on the left.
fn in_corner(before: DVec2, p: DVec2, after: DVec2, q: DVec2) -> bool {
    let (enters, leaves) = (orient2d(before, p, q) > 0.0, orient2d(p, after, q) > 0.0);
    if orient2d(before, p, after) > 0.0 {
        enters && leaves
    } else {
        enters || leaves
    }
}
