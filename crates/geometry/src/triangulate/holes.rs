//! Joining holes to the outer ring by bridges, so that one ring runs around everything.

use super::simple::{clockwise, crossing, next, segments_meet};
use super::{TriangulateError, on_a_line};
use crate::intersect::orient2d;
use glam::DVec2;

/// One counter-clockwise ring through all points, along every bridge twice.
pub(super) fn joined(
    points: &[DVec2],
    hole_starts: &[usize],
    by_left: &mut Vec<u32>,
) -> Result<Vec<u32>, TriangulateError> {
    let rings = rings(points, hole_starts)?;
    if let Some((i, j)) = crossing(points, hole_starts, by_left) {
        return Err(TriangulateError::Crossing(i, j));
    }
    for (k, ring) in rings.iter().enumerate().skip(1) {
        let p = points[ring.start];
        let within_another =
            (1..rings.len()).any(|l| l != k && inside(p, &points[rings[l].clone()]));
        if within_another || !inside(p, &points[rings[0].clone()]) {
            return Err(TriangulateError::HoleOutside(ring.start));
        }
    }
    let walk = |k: usize| -> Vec<u32> {
        let mut order: Vec<u32> = rings[k].clone().map(|i| i as u32).collect();
        // The outer ring runs counter-clockwise, holes clockwise.
        if clockwise(&points[rings[k].clone()]) == (k == 0) {
            order.reverse();
        }
        order
    };
    let mut order = walk(0);
    let mut left: Vec<usize> = (1..rings.len()).collect();
    let mut bridges: Vec<[DVec2; 2]> = Vec::new();
    while !left.is_empty() {
        let (from, hole, to) = bridge(points, hole_starts, &order, &rings, &left, &bridges)
            .ok_or(TriangulateError::Stuck(points.len()))?;
        let mut tour = walk(hole);
        let start = tour.iter().position(|&i| i == to).unwrap_or(0);
        tour.rotate_left(start);
        bridges.push([points[order[from] as usize], points[to as usize]]);
        let back = [to, order[from]];
        order.splice(from + 1..from + 1, tour.into_iter().chain(back));
        left.retain(|&k| k != hole);
    }
    Ok(order)
}

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
        if on_a_line(&points[start..end]) {
            return Err(TriangulateError::NoArea(start));
        }
        rings.push(start..end);
        start = end;
    }
    Ok(rings)
}

/// Whether `p`, which lies on no edge, is inside the ring: by the crossings of a ray to the right.
fn inside(p: DVec2, ring: &[DVec2]) -> bool {
    let crossings = (0..ring.len()).filter(|&i| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (a.y > p.y) != (b.y > p.y) && (orient2d(a, b, p) > 0.0) == (b.y > a.y)
    });
    crossings.count() % 2 == 1
}

/// The shortest bridge from the ring so far to a hole that is left: the place in the ring, the hole and its point.
fn bridge(
    points: &[DVec2],
    hole_starts: &[usize],
    order: &[u32],
    rings: &[std::ops::Range<usize>],
    left: &[usize],
    bridges: &[[DVec2; 2]],
) -> Option<(usize, usize, u32)> {
    let mut candidates: Vec<(f64, usize, usize, u32)> = Vec::new();
    for (at, &from) in order.iter().enumerate() {
        for &hole in left {
            for to in rings[hole].clone() {
                let length = points[from as usize].distance_squared(points[to]);
                candidates.push((length, at, hole, to as u32));
            }
        }
    }
    candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.3).cmp(&(b.1, b.3))));
    let fits = |&(_, at, _, to): &(f64, usize, usize, u32)| {
        let n = order.len();
        let point = |i: usize| points[order[i % n] as usize];
        let (p, q) = (point(at), points[to as usize]);
        in_corner(point(at + n - 1), p, point(at + 1), q)
            && (0..points.len()).all(|i| {
                let (a, b) = (points[i], points[next(i, points.len(), hole_starts)]);
                clear(p, q, a, b)
            })
            && bridges.iter().all(|&[a, b]| clear(p, q, a, b))
    };
    candidates
        .iter()
        .find(|c| fits(c))
        .map(|&(_, at, hole, to)| (at, hole, to))
}

/// Whether the way from `p` to `q` meets the edge from `a` to `b` at most where they have an end in common.
fn clear(p: DVec2, q: DVec2, a: DVec2, b: DVec2) -> bool {
    let ends = [a, b];
    let common = ends.iter().filter(|&&e| e == p || e == q).count();
    match common {
        0 => !segments_meet(p, q, a, b),
        // From a common end both go on; they overlap where one of the other ends lies on the other segment.
        1 => {
            let (e, other) = if a == p || a == q { (a, b) } else { (b, a) };
            let far = if e == p { q } else { p };
            orient2d(e, far, other) != 0.0 || (far - e).dot(other - e) < 0.0
        }
        _ => false,
    }
}

/// Whether `q` lies within the corner from `before` over `p` to `after`, the inside being on the left.
fn in_corner(before: DVec2, p: DVec2, after: DVec2, q: DVec2) -> bool {
    let (enters, leaves) = (orient2d(before, p, q) > 0.0, orient2d(p, after, q) > 0.0);
    if orient2d(before, p, after) > 0.0 {
        enters && leaves
    } else {
        enters || leaves
    }
}
