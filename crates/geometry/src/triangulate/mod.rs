//! Triangles that fill a polygon in the plane, with all of its vertices and edges and no others.
//!
//! Ears are clipped under exact predicates (Meisters 1975, Polygons Have Ears), then diagonals are flipped until the
//! triangulation is the constrained Delaunay one (Lawson 1977), which has the largest smallest angle: slivers stay
//! only where the polygon forces them. A vertex in the middle of a straight run is a vertex like any other.

mod ears;
mod holes;
mod simple;

use crate::intersect::orient2d;
use glam::DVec2;

/// Why a polygon cannot be triangulated. Nothing is written then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TriangulateError {
    /// Fewer than three points in a ring.
    #[error("a ring of {count} points from point {start} on; a ring needs at least 3")]
    TooFew {
        /// First point of the ring.
        start: usize,
        /// Its number of points.
        count: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// Two edges meet elsewhere than in their common end, or two points coincide.
    #[error(
        "the edges from points {0} and {1} cross or touch; a polygon's edges may only meet at their ends"
    )]
    Crossing(usize, usize),
    /// All points of a ring with holes, or of a hole, lie on one line.
    #[error("the ring from point {0} on has no area")]
    NoArea(usize),
    /// A hole lies outside the outer ring or inside another hole.
    #[error("the hole from point {0} on lies outside the polygon or within another hole")]
    HoleOutside(usize),
    /// The starts of the holes do not rise within the points.
    #[error("holes start at point {0}, which is not beyond the ring before or within the points")]
    BadHoleStart(usize),
    /// No triangulation was found although the edges are sound.
    #[error("no triangulation found of the polygon of {0} points")]
    Stuck(usize),
}

/// Triangulates polygons one after another, keeping its memory.
#[derive(Debug, Clone, Default)]
pub struct Triangulator {
    ears: ears::Ears,
    order: Vec<u32>,
    by_left: Vec<u32>,
}

/// [`Triangulator::polygon`] for a single polygon.
///
/// # Errors
/// As there.
pub fn triangulate(
    points: &[DVec2],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), TriangulateError> {
    Triangulator::default().polygon(points, triangles)
}

impl Triangulator {
    /// Appends the triangles that fill the simple polygon `points` to `triangles`, as indices into `points`: always
    /// `points.len() - 2`, counter-clockwise whichever way the polygon runs, every vertex and edge of the polygon
    /// among theirs. Where all points lie exactly on one line the triangles have no area, a fan in the polygon's order.
    ///
    /// # Errors
    /// Where an edge crosses or touches another, points coincide, are not finite or fewer than three.
    pub fn polygon(
        &mut self,
        points: &[DVec2],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), TriangulateError> {
        if points.len() < 3 {
            return Err(TriangulateError::TooFew {
                start: 0,
                count: points.len(),
            });
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(TriangulateError::NotFinite(i));
        }
        match *points {
            [a, b, c] => {
                if a == b || b == c || c == a {
                    return Err(TriangulateError::Crossing(0, 1 + usize::from(b == c)));
                }
                triangles.push(if orient2d(a, b, c) < 0.0 {
                    [0, 2, 1]
                } else {
                    [0, 1, 2]
                });
                Ok(())
            }
            [a, b, c, d] if quad([a, b, c, d], triangles) => Ok(()),
            _ => self.general(points, triangles),
        }
    }

    fn general(
        &mut self,
        points: &[DVec2],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), TriangulateError> {
        if on_a_line(points) {
            if let Some((i, j)) = simple::repeated(points) {
                return Err(TriangulateError::Crossing(i, j));
            }
            triangles.extend((1..points.len() as u32 - 1).map(|i| [0, i, i + 1]));
            return Ok(());
        }
        if let Some((i, j)) = simple::crossing(points, &[], &mut self.by_left) {
            return Err(TriangulateError::Crossing(i, j));
        }
        self.order.clear();
        self.order.extend(0..points.len() as u32);
        if simple::clockwise(points) {
            self.order.reverse();
        }
        self.ears.fill(points, &self.order, false, triangles)
    }

    /// [`Triangulator::polygon`] for a polygon with holes: `points` are those of the outer ring and then of each hole,
    /// `hole_starts` the first point of each hole. Gives `points.len() + 2 · holes − 2` triangles.
    ///
    /// # Errors
    /// As there, and where a hole is not inside.
    pub fn polygon_with_holes(
        &mut self,
        points: &[DVec2],
        hole_starts: &[usize],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), TriangulateError> {
        if hole_starts.is_empty() {
            return self.polygon(points, triangles);
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(TriangulateError::NotFinite(i));
        }
        let order = holes::joined(points, hole_starts, &mut self.by_left)?;
        self.ears.fill(points, &order, true, triangles)
    }
}

/// Whether all points lie exactly on one line.
fn on_a_line(points: &[DVec2]) -> bool {
    let Some(&other) = points.iter().find(|&&p| p != points[0]) else {
        return true;
    };
    points.iter().all(|&p| orient2d(points[0], other, p) == 0.0)
}

/// Whether the diagonal of the quadrilateral a, b, c, d (counter-clockwise, convex) should run from b to d instead of
/// from a to c: whether d lies within the circle through a, b, c, clearly beyond rounding. Without the exact predicate:
/// it is slow for the frequent points on one circle, and only a flip that is certain must lower the lifted surface.
fn better_flipped(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let [a, b, c] = [a - d, b - d, c - d];
    let (bc, ca, ab) = (b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
    let [la, lb, lc] = [a, b, c].map(DVec2::length_squared);
    let products = |p: DVec2, q: DVec2| (p.x * q.y).abs() + (p.y * q.x).abs();
    // Shewchuk's bound is 10 roundings of 1.1e-16.
    let bound = 4e-15 * (products(b, c) * la + products(c, a) * lb + products(a, b) * lc);
    la * bc + lb * ca + lc * ab > bound
}

/// Two triangles for a quadrilateral without a straight angle or with one that a diagonal ends in; false where neither
/// diagonal leaves two triangles that turn the same way, which is so where edges cross or all points lie on a line.
fn quad([a, b, c, d]: [DVec2; 4], triangles: &mut Vec<[u32; 3]>) -> bool {
    let same = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    let (abc, acd) = (orient2d(a, b, c), orient2d(a, c, d));
    let (bcd, bda) = (orient2d(b, c, d), orient2d(b, d, a));
    let (first, second) = (same(abc, acd), same(bcd, bda));
    if !first && !second {
        return false;
    }
    let clockwise = if first { abc < 0.0 } else { bcd < 0.0 };
    // The sign of the circle test turns with the orientation.
    let flip = !first
        || second
            && if clockwise {
                better_flipped(a, d, c, b)
            } else {
                better_flipped(a, b, c, d)
            };
    let pair = if flip {
        [[1, 2, 3], [1, 3, 0]]
    } else {
        [[0, 1, 2], [0, 2, 3]]
    };
    triangles.extend(pair.map(|[i, j, k]| if clockwise { [i, k, j] } else { [i, j, k] }));
    true
}

#[cfg(test)]
mod tests;
