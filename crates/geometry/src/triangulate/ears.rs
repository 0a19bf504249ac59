//! Ear clipping, followed by flips of diagonals.

use super::error::TriangulateError;
use super::quad::better_flipped;
use crate::intersect::orient2d;
use glam::DVec2;

/// No triangle lies behind this edge: it is an edge of the polygon.
const OUTSIDE: u32 = u32::MAX;

/// A corner of the remaining ring, linked to its neighbours.
#[derive(Debug, Clone, Copy)]
struct Corner {
    point: u32,
    before: u32,
    after: u32,
    /// The half-edge (three times the triangle plus the edge) behind the ring's edge from here to the next corner.
    behind: u32,
    /// Whether the ring turns left here, by less than half a turn.
    convex: bool,
}

/// Working memory of the clipping.
#[derive(Debug, Clone, Default)]
pub(super) struct Ears {
    ring: Vec<Corner>,
    /// For each half-edge of the new triangles its twin on the other side.
    twins: Vec<u32>,
    /// Half-edges that may have to be flipped.
    pending: Vec<u32>,
}

impl Ears {
    /// Triangulates the ring of `points` in `order`, which must be counter-clockwise. `bridged` says that points may occur
    /// several times.
    pub fn fill(
        &mut self,
        points: &[DVec2],
        order: &[u32],
        bridged: bool,
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), TriangulateError> {
        let first = triangles.len();
        let n = order.len() as u32;
        self.ring.clear();
        self.ring.extend((0..n).map(|i| Corner {
            point: order[i as usize],
            before: (i + n - 1) % n,
            after: (i + 1) % n,
            behind: OUTSIDE,
            convex: false,
        }));
        self.twins.clear();
        for i in 0..n {
            self.update_convexity(points, i);
        }
        let mut at = 0;
        // Corners examined since the last ear.
        let mut idle = 0;
        let mut remaining = n;
        while remaining > 3 {
            if self.is_ear(points, at, bridged) {
                let Corner { before, after, .. } = self.ring[at as usize];
                self.clip(at, first, triangles);
                self.update_convexity(points, before);
                self.update_convexity(points, after);
                remaining -= 1;
                idle = 0;
                // Continuing beyond the new edge spreads the ears around the ring.
                at = self.ring[after as usize].after;
            } else {
                at = self.ring[at as usize].after;
                idle += 1;
                if idle > remaining {
                    triangles.truncate(first);
                    return Err(TriangulateError::Stuck(points.len()));
                }
            }
        }
        if !self.ring[at as usize].convex {
            triangles.truncate(first);
            return Err(TriangulateError::Stuck(points.len()));
        }
        let after = self.ring[at as usize].after;
        self.clip(at, first, triangles);
        // The diagonal of the last ear is the last edge of the ring.
        let diagonal = self.twins.len() as u32 - 1;
        self.pair(diagonal, self.ring[after as usize].behind);
        self.flip(points, &mut triangles[first..]);
        Ok(())
    }

    /// Updates whether the corner is convex.
    fn update_convexity(&mut self, points: &[DVec2], at: u32) {
        let corner = self.ring[at as usize];
        let point = |i: u32| points[self.ring[i as usize].point as usize];
        self.ring[at as usize].convex =
            orient2d(point(corner.before), point(at), point(corner.after)) > 0.0;
    }

    /// Whether the corner can be clipped: it is convex, and its closed triangle contains no other corner. In a simple ring
    /// it suffices to test the corners that are not convex.
    fn is_ear(&self, points: &[DVec2], at: u32, bridged: bool) -> bool {
        let corner = &self.ring[at as usize];
        if !corner.convex {
            return false;
        }
        let point = |i: u32| points[self.ring[i as usize].point as usize];
        let (a, b, c) = (point(corner.before), point(at), point(corner.after));
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let mut other = self.ring[corner.after as usize].after;
        while other != corner.before {
            let entry = &self.ring[other as usize];
            let p = points[entry.point as usize];
            if bridged && (p == a || p == c || p == b) {
                // A bridge already joins the ends of the diagonal: the ring beyond would have no area.
                let next = point(entry.after);
                if (p == a && next == c) || (p == c && next == a) {
                    return false;
                }
            } else if (bridged || !entry.convex)
                && p.cmpge(low).all()
                && p.cmple(high).all()
                && orient2d(a, b, p) >= 0.0
                && orient2d(b, c, p) >= 0.0
                && orient2d(c, a, p) >= 0.0
            {
                return false;
            }
            other = entry.after;
        }
        true
    }

    /// Appends the triangle of a corner and removes the corner from the ring.
    fn clip(&mut self, at: u32, first: usize, triangles: &mut Vec<[u32; 3]>) {
        let Corner {
            point,
            before,
            after,
            behind,
            ..
        } = self.ring[at as usize];
        let half_edge = 3 * (triangles.len() - first) as u32;
        triangles.push([
            self.ring[before as usize].point,
            point,
            self.ring[after as usize].point,
        ]);
        self.twins.extend([OUTSIDE; 3]);
        self.pair(half_edge, self.ring[before as usize].behind);
        self.pair(half_edge + 1, behind);
        self.ring[before as usize].after = after;
        self.ring[before as usize].behind = half_edge + 2;
        self.ring[after as usize].before = before;
    }

    /// Makes two half-edges twins.
    fn pair(&mut self, a: u32, b: u32) {
        if b != OUTSIDE {
            self.twins[a as usize] = b;
            self.twins[b as usize] = a;
        }
    }

    /// Flips diagonals until, wherever a flip is possible, the circumcircle of either triangle does not contain the
    /// opposite corner. This terminates because every flip lowers the surface lifted to the paraboloid.
    fn flip(&mut self, points: &[DVec2], triangles: &mut [[u32; 3]]) {
        self.pending.clear();
        self.pending
            .extend((0..self.twins.len() as u32).filter(|&h| {
                let twin = self.twins[h as usize];
                twin != OUTSIDE && h < twin
            }));
        while let Some(h) = self.pending.pop() {
            let twin = self.twins[h as usize];
            if twin == OUTSIDE {
                continue;
            }
            let (s, i) = ((h / 3) as usize, (h % 3) as usize);
            let (t, j) = ((twin / 3) as usize, (twin % 3) as usize);
            // The diagonal from a to c, its triangles a, c, d and c, a, b.
            let [a, c, d] = [0, 1, 2].map(|k| triangles[s][(i + k) % 3]);
            let b = triangles[t][(j + 2) % 3];
            let [pa, pb, pc, pd] = [a, b, c, d].map(|k| points[k as usize]);
            if !better_flipped(pa, pb, pc, pd)
                || orient2d(pb, pc, pd) <= 0.0
                || orient2d(pd, pa, pb) <= 0.0
            {
                continue;
            }
            let outer = |t: usize, k: usize| self.twins[3 * t + k % 3];
            let (cd, da) = (outer(s, i + 1), outer(s, i + 2));
            let (ab, bc) = (outer(t, j + 1), outer(t, j + 2));
            triangles[s] = [b, c, d];
            triangles[t] = [d, a, b];
            let (s, t) = (3 * s as u32, 3 * t as u32);
            for (here, there) in [(s, bc), (s + 1, cd), (s + 2, t + 2), (t, da), (t + 1, ab)] {
                self.twins[here as usize] = OUTSIDE;
                self.pair(here, there);
            }
            self.pending.extend([s, s + 1, t, t + 1]);
        }
    }
}
