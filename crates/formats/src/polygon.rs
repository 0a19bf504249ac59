//! Triangulation of faces: a fan if the polygon is convex, ear clipping in its plane (Meisters 1975, Polygons Have Ears)
//! otherwise.
//!
//! Every corner stays in use, even on a straight edge: without it, the surface would be open where its neighbour uses the
//! corner.

use glam::{DVec2, DVec3};

/// Most corners for ear clipping, which takes cubic time in the worst case; larger polygons become a fan.
const MAX_CLIPPED_CORNERS: usize = 2048;

/// Working memory that is reused from polygon to polygon.
#[derive(Default)]
pub(crate) struct Triangulator {
    flat: Vec<DVec2>,
    ring: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Triangulator {
    /// Triangulates the polygon with the corners `points`. Returns `points.len() − 2` triangles as indices into `points`.
    pub fn triangulate(&mut self, points: &[DVec3]) -> &[[u32; 3]] {
        self.triangles.clear();
        let n = points.len();
        if n < 3 {
            return &self.triangles;
        }
        if n == 3 || n > MAX_CLIPPED_CORNERS || !self.flatten(points) || self.strictly_convex() {
            self.triangles
                .extend((1..n as u32 - 1).map(|i| [0, i, i + 1]));
        } else {
            self.clip_ears();
        }
        &self.triangles
    }

    /// Projects the polygon onto the plane perpendicular to its vector area. Returns false if that is zero.
    fn flatten(&mut self, points: &[DVec3]) -> bool {
        let origin = points[0];
        let area: DVec3 = points[1..]
            .windows(2)
            .map(|w| (w[0] - origin).cross(w[1] - origin))
            .sum();
        let Some(normal) = area.try_normalize() else {
            return false;
        };
        let (u, v) = normal.any_orthonormal_pair();
        // The pair is right-handed with the normal, so the flat polygon runs counter-clockwise.
        self.flat.clear();
        self.flat.extend(
            points
                .iter()
                .map(|p| DVec2::new((p - origin).dot(u), (p - origin).dot(v))),
        );
        self.flat.iter().all(|p| p.is_finite())
    }

    /// Whether the polygon is convex without straight angles.
    fn strictly_convex(&self) -> bool {
        let p = &self.flat;
        let n = p.len();
        // Left turns alone are not enough: a star polygon has only left turns, but winds around twice.
        let mut turns_of_x = 0;
        for i in 0..n {
            let (a, b, c) = (p[i], p[(i + 1) % n], p[(i + 2) % n]);
            if (b - a).perp_dot(c - b) <= 0.0 {
                return false;
            }
            turns_of_x += usize::from(((b - a).x < 0.0) != ((c - b).x < 0.0));
        }
        turns_of_x <= 2
    }

    /// Clips ears until the polygon is used up.
    fn clip_ears(&mut self) {
        self.ring.clear();
        self.ring.extend(0..self.flat.len() as u32);
        let mut start = 0;
        while self.ring.len() > 3 {
            let n = self.ring.len();
            let find = |least_turn: Turn| {
                (0..n)
                    .map(|k| (start + k) % n)
                    .find(|&i| self.is_ear(i, least_turn))
            };
            // An ear without area is clipped only if no ear with an area remains. A polygon that intersects itself may
            // have no ear at all; then any corner is clipped.
            let i = find(Turn::Left)
                .or_else(|| find(Turn::Straight))
                .unwrap_or(start % n);
            self.triangles.push([
                self.ring[(i + n - 1) % n],
                self.ring[i],
                self.ring[(i + 1) % n],
            ]);
            self.ring.remove(i);
            // Continuing behind the ear alternates the clipped corners, which avoids a fan of slivers.
            start = if i < self.ring.len() { i + 1 } else { 0 };
        }
        if let [a, b, c] = self.ring[..] {
            self.triangles.push([a, b, c]);
        }
    }

    /// Whether corner `i` is an ear that turns at least as much as `least`.
    fn is_ear(&self, i: usize, least: Turn) -> bool {
        let n = self.ring.len();
        let at = |k: usize| self.flat[self.ring[k % n] as usize];
        let (a, b, c) = (at(i + n - 1), at(i), at(i + 1));
        let turn = (b - a).perp_dot(c - b);
        if turn < 0.0 || (turn == 0.0 && least == Turn::Left) {
            return false;
        }
        (2..n - 1).all(|k| {
            let p = at(i + k);
            if p == a || p == b || p == c {
                return true;
            }
            let outside = |s: DVec2, t: DVec2| (t - s).perp_dot(p - s) < 0.0;
            if turn == 0.0 {
                // Collinear: only a corner between a and c prevents it.
                return (c - a).perp_dot(p - a) != 0.0 || (p - a).dot(p - c) > 0.0;
            }
            outside(a, b) || outside(b, c) || outside(c, a)
        })
    }
}

/// Counts faces that are not triangles, for the notes of a scene.
#[derive(Default)]
pub(crate) struct FaceStatistics {
    polygons: usize,
    degenerate: usize,
}

impl FaceStatistics {
    /// Counts a face with a number of corners.
    pub fn count(&mut self, corners: usize) {
        self.polygons += usize::from(corners > 3);
        self.degenerate += usize::from(corners < 3);
    }

    /// Adds notes on the faces.
    pub fn add_notes(&self, notes: &mut Vec<String>) {
        if self.polygons > 0 {
            notes.push(format!("{} polygons were triangulated.", self.polygons));
        }
        if self.degenerate > 0 {
            notes.push(format!(
                "{} faces with fewer than three corners were dropped.",
                self.degenerate
            ));
        }
    }
}

/// The turn at a corner.
#[derive(Clone, Copy, PartialEq)]
enum Turn {
    Left,
    Straight,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i as usize]);
                (b - a).cross(c - a).z / 2.0
            })
            .collect()
    }

    fn check(flat: &[[f64; 2]], area: f64) {
        let points: Vec<DVec3> = flat.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect();
        let mut triangulator = Triangulator::default();
        let triangles = triangulator.triangulate(&points).to_vec();
        assert_eq!(triangles.len(), points.len() - 2);
        let areas = areas(&points, &triangles);
        // Non-negative areas that add up to the polygon's: the triangles neither overlap nor leave it.
        assert!(areas.iter().all(|&a| a >= -1e-12), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - area).abs() < 1e-9, "{areas:?}");
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        check(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]], 1.0);
        check(
            &[
                [0.0, 0.0],
                [3.0, 0.0],
                [3.0, 3.0],
                [2.0, 3.0],
                [2.0, 1.0],
                [1.0, 1.0],
                [1.0, 3.0],
                [0.0, 3.0],
            ],
            7.0,
        );
        let comb: Vec<[f64; 2]> = (0..40)
            .map(|i| [f64::from(i), if i % 2 == 0 { 1.0 } else { 5.0 }])
            .chain([[39.0, 0.0], [0.0, 0.0]])
            .rev()
            .collect();
        check(&comb, 39.0 * 3.0);
    }

    #[test]
    fn corners_on_straight_edges_stay_in_use() {
        check(
            &[
                [0.0, 0.0],
                [1.0, 0.0],
                [2.0, 0.0],
                [2.0, 2.0],
                [1.0, 2.0],
                [0.0, 2.0],
                [0.0, 1.0],
            ],
            4.0,
        );
    }
}
