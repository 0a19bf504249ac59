//! Triangulation of polygons in the plane, with all of their vertices and edges and no others.
//!
//! Ears are clipped with exact predicates (Meisters 1975, Polygons Have Ears), then diagonals are flipped until the
//! triangulation is the constrained Delaunay triangulation (Lawson 1977, Software for C1 Surface Interpolation), which
//! maximises the smallest angle: slivers remain only where the polygon forces them. A vertex in the middle of a straight
//! run is a vertex like any other.

mod ears;
mod error;
mod holes;
mod quad;
mod simple;

pub use error::TriangulateError;

use crate::intersect::orient2d;
use glam::DVec2;
use quad::triangulate_quad;
use simple::are_collinear;

/// Triangulates polygons one after another, reusing its memory.
#[derive(Debug, Clone, Default)]
pub struct Triangulator {
    ears: ears::Ears,
    order: Vec<u32>,
    by_left: Vec<u32>,
}

/// Triangulates a single polygon; see [`Triangulator::polygon`].
///
/// ```
/// use glam::DVec2;
/// use greenstick_geometry::triangulate::triangulate;
///
/// let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
/// let mut triangles = Vec::new();
/// triangulate(&square, &mut triangles)?;
/// assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
/// # Ok::<(), greenstick_geometry::triangulate::TriangulateError>(())
/// ```
///
/// # Errors
/// As [`Triangulator::polygon`].
pub fn triangulate(
    points: &[DVec2],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), TriangulateError> {
    Triangulator::default().polygon(points, triangles)
}

impl Triangulator {
    /// Appends the triangles that fill the simple polygon `points` to `triangles`, as indices into `points`. There are
    /// always `points.len() - 2` of them, counter-clockwise whatever the orientation of the polygon, and they contain every
    /// vertex and edge of the polygon. If all points lie exactly on one line, the triangles are a fan without area.
    ///
    /// # Errors
    /// [`TriangulateError`] if an edge crosses or touches another, or if points coincide, are not finite, or are fewer than
    /// three.
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
            [a, b, c, d] if triangulate_quad([a, b, c, d], triangles) => Ok(()),
            _ => self.general(points, triangles),
        }
    }

    /// Triangulates a polygon of any number of points.
    fn general(
        &mut self,
        points: &[DVec2],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), TriangulateError> {
        let clockwise = match simple::monotone_orientation(points) {
            Some(clockwise) => clockwise,
            None => {
                if are_collinear(points) {
                    if let Some((i, j)) = simple::find_repeated(points) {
                        return Err(TriangulateError::Crossing(i, j));
                    }
                    triangles.extend((1..points.len() as u32 - 1).map(|i| [0, i, i + 1]));
                    return Ok(());
                }
                if let Some((i, j)) = simple::find_crossing(points, &[], &mut self.by_left) {
                    return Err(TriangulateError::Crossing(i, j));
                }
                simple::is_clockwise(points)
            }
        };
        self.order.clear();
        self.order.extend(0..points.len() as u32);
        if clockwise {
            self.order.reverse();
        }
        self.ears.fill(points, &self.order, false, triangles)
    }

    /// Appends the triangles that fill a polygon with holes, `points.len() + 2 · holes − 2` of them. `points` are those of
    /// the outer ring followed by those of each hole, `hole_starts` the index of the first point of each hole.
    ///
    /// # Errors
    /// As [`Triangulator::polygon`], and if a hole is not inside.
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
        let order = holes::joined_ring(points, hole_starts, &mut self.by_left)?;
        self.ears.fill(points, &order, true, triangles)
    }
}

#[cfg(test)]
mod tests;
