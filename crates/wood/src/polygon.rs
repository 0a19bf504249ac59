//! Plane geometry of closed outlines: area, centroid, enclosing rectangle, largest inscribed circle.

use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Returns the signed area (counter-clockwise positive) and the centroid of a closed polygon; its first point where the
/// area is 0.
///
/// ```
/// use glam::DVec2;
/// use greenstick_wood::polygon::area_and_centroid;
///
/// let triangle = [DVec2::ZERO, DVec2::new(3.0, 0.0), DVec2::new(0.0, 3.0)];
/// assert_eq!(area_and_centroid(&triangle), (4.5, DVec2::ONE));
/// ```
pub fn area_and_centroid(outline: &[DVec2]) -> (f64, DVec2) {
    let Some(&origin) = outline.first() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut twice, mut moment) = (0.0, DVec2::ZERO);
    for (i, &p) in outline.iter().enumerate() {
        let (a, b) = (p - origin, outline[(i + 1) % outline.len()] - origin);
        let cross = a.perp_dot(b);
        twice += cross;
        moment += (a + b) * cross;
    }
    if twice == 0.0 {
        return (0.0, origin);
    }
    (0.5 * twice, origin + moment / (3.0 * twice))
}

/// Length of the closed outline.
pub(crate) fn perimeter(outline: &[DVec2]) -> f64 {
    (0..outline.len())
        .map(|i| outline[i].distance(outline[(i + 1) % outline.len()]))
        .sum()
}

/// Whether the closed outline holds `p` (even–odd rule).
pub(crate) fn contains(outline: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)) {
            inside = !inside;
        }
    }
    inside
}

/// Distance from `p` to the closed outline itself.
pub(crate) fn distance(outline: &[DVec2], p: DVec2) -> f64 {
    let mut best = f64::INFINITY;
    for (i, &a) in outline.iter().enumerate() {
        let edge = outline[(i + 1) % outline.len()] - a;
        let along = edge.length_squared();
        let t = if along > 0.0 {
            ((p - a).dot(edge) / along).clamp(0.0, 1.0)
        } else {
            0.0
        };
        best = best.min((a + edge * t).distance_squared(p));
    }
    best.sqrt()
}

/// The farthest crossing of the ray from `from` along the unit vector `direction` with the outline.
#[cfg(test)]
fn farthest_crossing(outline: &[DVec2], from: DVec2, direction: DVec2) -> Option<f64> {
    let mut best: Option<f64> = None;
    for (i, &p) in outline.iter().enumerate() {
        let (a, b) = (p - from, outline[(i + 1) % outline.len()] - from);
        let (u, v) = (direction.perp_dot(a), direction.perp_dot(b));
        if (u > 0.0) != (v > 0.0) {
            let r = direction.dot(a + (b - a) * (u / (u - v)));
            if r > 0.0 && best.is_none_or(|k| r > k) {
                best = Some(r);
            }
        }
    }
    best
}

/// The same in `count` directions at equal angles, the first at −π. Each edge is tested only against the
/// directions under which it is seen.
pub(crate) fn farthest_crossings(outline: &[DVec2], from: DVec2, count: usize) -> Vec<Option<f64>> {
    let directions: Vec<DVec2> = (0..count)
        .map(|j| {
            let (sin, cos) = libm::sincos(TAU * j as f64 / count as f64 - PI);
            DVec2::new(cos, sin)
        })
        .collect();
    let corners: Vec<(DVec2, f64)> = outline
        .iter()
        .map(|p| *p - from)
        .map(|d| (d, (libm::atan2(d.y, d.x) + PI) * (count as f64 / TAU)))
        .collect();
    let mut best: Vec<Option<f64>> = vec![None; count];
    for (i, &(a, start)) in corners.iter().enumerate() {
        let (b, end) = corners[(i + 1) % corners.len()];
        // An edge subtends less than half a turn.
        let half = 0.5 * count as f64;
        let turn = (end - start + half).rem_euclid(count as f64) - half;
        let (low, high) = (start.min(start + turn), start.max(start + turn));
        if !(low.is_finite() && high.is_finite()) {
            continue;
        }
        for j in low.floor() as i64 - 1..=high.ceil() as i64 + 1 {
            let j = j.rem_euclid(count as i64) as usize;
            let (u, v) = (directions[j].perp_dot(a), directions[j].perp_dot(b));
            if (u > 0.0) != (v > 0.0) {
                let r = directions[j].dot(a + (b - a) * (u / (u - v)));
                if r > 0.0 && best[j].is_none_or(|k| r > k) {
                    best[j] = Some(r);
                }
            }
        }
    }
    best
}

/// Directions in which the outermost of many points are known, in rising angle.
const DIRECTIONS: [DVec2; 8] = [
    DVec2::new(1.0, 0.0),
    DVec2::new(1.0, 1.0),
    DVec2::new(0.0, 1.0),
    DVec2::new(-1.0, 1.0),
    DVec2::new(-1.0, 0.0),
    DVec2::new(-1.0, -1.0),
    DVec2::new(0.0, -1.0),
    DVec2::new(1.0, -1.0),
];

/// The outermost of points, in a few directions.
pub(crate) struct Outermost([DVec2; 8]);

impl Outermost {
    /// The outermost of one point.
    pub fn of(point: DVec2) -> Self {
        Outermost([point; 8])
    }

    pub fn add(&mut self, p: DVec2) {
        for (outermost, direction) in self.0.iter_mut().zip(DIRECTIONS) {
            if p.dot(direction) > outermost.dot(direction) {
                *outermost = p;
            }
        }
    }

    /// A test of points of which those that pass are no corners of the convex hull: they lie within the polygon of the outermost,
    /// made a little smaller (Akl and Toussaint 1978, A Fast Convex Hull Algorithm).
    pub fn interior(&self) -> impl Fn(DVec2) -> bool + use<> {
        /// Size of the polygon, so that no point near the hull is lost to rounding.
        const SHRINKAGE: f64 = 0.95;
        let middle = self.0.iter().sum::<DVec2>() / 8.0;
        let polygon = self.0.map(|p| middle + (p - middle) * SHRINKAGE);
        move |p| {
            (0..8).all(|k| {
                let (a, b) = (polygon[k], polygon[(k + 1) % 8]);
                a == b || (b - a).perp_dot(p - a) > 0.0
            })
        }
    }
}

/// The points that may be corners of the convex hull.
fn outer_points(points: &[DVec2]) -> Vec<DVec2> {
    /// Fewer points are sorted as fast as they are looked through.
    const MIN_POINTS: usize = 1000;
    if points.len() < MIN_POINTS {
        return points.to_vec();
    }
    let mut outermost = Outermost::of(points[0]);
    points.iter().for_each(|&p| outermost.add(p));
    let is_inside = outermost.interior();
    points.iter().copied().filter(|&p| !is_inside(p)).collect()
}

/// The convex hull, counter-clockwise (Andrew 1979, Another Efficient Algorithm for Convex Hulls in Two Dimensions).
pub(crate) fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = outer_points(points);
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut chain: Vec<DVec2> = Vec::new();
    let mut half = |order: &mut dyn Iterator<Item = DVec2>| {
        let start = chain.len();
        for p in order {
            while chain.len() >= start + 2 {
                let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
    };
    half(&mut sorted.iter().copied());
    half(&mut sorted.iter().rev().copied());
    chain
}

/// Least and greatest width of an outline between parallel tangents, as callipers measure it, to 0.02 %.
pub(crate) fn calliper_widths(outline: &[DVec2]) -> (f64, f64) {
    const DIRECTIONS: usize = 180;
    let hull = convex_hull(outline);
    (0..DIRECTIONS)
        .map(|k| {
            let (sin, cos) = libm::sincos(PI * k as f64 / DIRECTIONS as f64);
            let along = hull.iter().map(|p| p.dot(DVec2::new(cos, sin)));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            high - low
        })
        .fold((f64::INFINITY, 0.0), |(least, greatest), width| {
            (least.min(width), greatest.max(width))
        })
}

/// Ovality of an outline: by how much its least calliper width is below the greatest, as a share of it.
pub(crate) fn ovality(outline: &[DVec2]) -> f64 {
    let (least, greatest) = calliper_widths(outline);
    if greatest > 0.0 {
        1.0 - least / greatest
    } else {
        0.0
    }
}

/// A rectangle in any direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectangle {
    /// Its centre.
    pub centre: DVec2,
    /// Direction of its longer side (unit).
    pub wide: DVec2,
    /// Longer side.
    pub width: f64,
    /// Shorter side.
    pub thickness: f64,
}

/// The enclosing rectangle of least area. One of its sides lies on a side of the convex hull (Freeman and Shapira 1975).
pub(crate) fn smallest_rectangle(points: &[DVec2]) -> Option<Rectangle> {
    let hull = convex_hull(points);
    let mut best: Option<(f64, Rectangle)> = None;
    for (i, &a) in hull.iter().enumerate() {
        let Some(u) = (hull[(i + 1) % hull.len()] - a).try_normalize() else {
            continue;
        };
        let v = u.perp();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &p in &hull {
            let q = DVec2::new(p.dot(u), p.dot(v));
            (low, high) = (low.min(q), high.max(q));
        }
        let size = high - low;
        if best.is_none_or(|(area, _)| size.x * size.y < area) {
            let middle = (low + high) * 0.5;
            let centre = u * middle.x + v * middle.y;
            let (wide, width, thickness) = if size.x >= size.y {
                (u, size.x, size.y)
            } else {
                (v, size.y, size.x)
            };
            best = Some((
                size.x * size.y,
                Rectangle {
                    centre,
                    wide,
                    width,
                    thickness,
                },
            ));
        }
    }
    best.map(|(_, r)| r)
}

/// At most `count` of the outline's points, evenly spaced by index.
pub(crate) fn thinned(outline: &[DVec2], count: usize) -> Vec<DVec2> {
    if outline.len() <= count {
        return outline.to_vec();
    }
    (0..count)
        .map(|i| outline[i * outline.len() / count])
        .collect()
}

/// Centre and radius of the largest circle inside the outline, to about 0.1 % of its size.
pub(crate) fn largest_inscribed_circle(outline: &[DVec2]) -> (DVec2, f64) {
    let outline = thinned(outline, 200);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for &p in &outline {
        (low, high) = (low.min(p), high.max(p));
    }
    let depth = |p: DVec2| {
        if contains(&outline, p) {
            distance(&outline, p)
        } else {
            -1.0
        }
    };
    let mut best = (area_and_centroid(&outline).1, 0.0);
    best.1 = depth(best.0);
    const CELLS: i32 = 12;
    for i in 1..CELLS {
        for j in 1..CELLS {
            let t = DVec2::new(f64::from(i), f64::from(j)) / f64::from(CELLS);
            let p = low + (high - low) * t;
            let d = depth(p);
            if d > best.1 {
                best = (p, d);
            }
        }
    }
    let mut step = (high - low).max_element() / f64::from(CELLS);
    while step > 1e-3 * (high - low).max_element() {
        let around = [
            DVec2::X,
            DVec2::Y,
            DVec2::NEG_X,
            DVec2::NEG_Y,
            DVec2::ONE,
            DVec2::NEG_ONE,
        ]
        .map(|d| best.0 + d * step)
        .map(|p| (p, depth(p)));
        match around.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(better) if better.1 > best.1 => best = better,
            _ => step *= 0.5,
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_in_all_directions_are_those_in_each() {
        // A star that folds back, seen from inside, from outside and from a corner.
        let star: Vec<DVec2> = (0..41)
            .map(|i| {
                let a = f64::from(i) * 0.9 + 0.3 * f64::from(i % 5);
                DVec2::new(libm::cos(a), libm::sin(a)) * (1.0 + f64::from(i % 7))
            })
            .collect();
        for from in [
            DVec2::ZERO,
            DVec2::new(0.3, 9.0),
            star[3],
            DVec2::new(-2.0, 0.0),
        ] {
            for (j, found) in farthest_crossings(&star, from, 96).into_iter().enumerate() {
                let (sin, cos) = libm::sincos(TAU * j as f64 / 96.0 - PI);
                let one = farthest_crossing(&star, from, DVec2::new(cos, sin));
                assert_eq!(found, one, "{from} {j}");
            }
        }
    }

    #[test]
    fn a_turned_rectangle_is_measured() {
        let u = DVec2::new(0.6, 0.8);
        let at = |a: f64, b: f64| DVec2::new(3.0, -1.0) + u * a + u.perp() * b;
        let outline = [at(0.0, 0.0), at(4.0, 0.0), at(4.0, 1.0), at(0.0, 1.0)];
        let (area, centroid) = area_and_centroid(&outline);
        assert!((area - 4.0).abs() < 1e-12 && centroid.distance(at(2.0, 0.5)) < 1e-12);
        assert!((perimeter(&outline) - 10.0).abs() < 1e-12);
        let r = smallest_rectangle(&outline).unwrap();
        assert!((r.width - 4.0).abs() < 1e-12 && (r.thickness - 1.0).abs() < 1e-12);
        assert!(r.wide.dot(u).abs() > 1.0 - 1e-12 && r.centre.distance(at(2.0, 0.5)) < 1e-12);
        assert!((largest_inscribed_circle(&outline).1 - 0.5).abs() < 2e-3);
        assert!((farthest_crossing(&outline, at(1.0, 0.5), u).unwrap() - 3.0).abs() < 1e-12);
        assert!(contains(&outline, at(3.9, 0.9)) && !contains(&outline, at(4.1, 0.9)));
    }
}
