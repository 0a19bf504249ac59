//! Voronoi cells of rod points in a cross-section, clipped by its outline, with the widths of the facets between
//! neighbours.

use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};

/// A facet between two cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// The neighbour.
    pub neighbour: u32,
    /// Width of the facet, m.
    pub width: f64,
}

/// The cell of a rod point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VoronoiCell {
    /// Corners, counter-clockwise, m.
    pub corners: Vec<DVec2>,
    /// Area, m².
    pub area: f64,
    /// Centroid, m.
    pub centroid: DVec2,
    /// Facets, by ascending neighbour.
    pub facets: Vec<Facet>,
}

impl VoronoiCell {
    /// Returns points of the cell, and the part of its area that each stands for: the triangles about its centroid, each
    /// divided into equal ones. `divisions` gives the number along an edge of a triangle that reaches so far (m) from the
    /// centroid.
    pub(super) fn samples(
        &self,
        divisions: impl Fn(f64) -> u32,
    ) -> impl Iterator<Item = (DVec2, f64)> {
        let count = self.corners.len();
        (0..count).flat_map(move |i| {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % count]);
            let [p, q] = [a - self.centroid, b - self.centroid];
            let n = divisions(p.length().max(q.length()));
            let weight = 0.5 * p.perp_dot(q) / (self.area * f64::from(n * n));
            let at = move |u: f64, v: f64| self.centroid + (p * u + q * v) / f64::from(n);
            let upright = (0..n).flat_map(move |j| (0..n - j).map(move |k| (j, k, 1.0 / 3.0)));
            let inverted =
                (0..n.max(1) - 1).flat_map(move |j| (0..n - 1 - j).map(move |k| (j, k, 2.0 / 3.0)));
            upright
                .chain(inverted)
                .map(move |(j, k, shift)| (at(f64::from(j) + shift, f64::from(k) + shift), weight))
        })
    }
}

/// Whether a point is inside a closed outline.
pub(super) fn is_inside(outline: &[DVec2], p: DVec2) -> bool {
    let mut odd = false;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)) {
            odd = !odd;
        }
    }
    odd
}

/// Returns the signed area and the centroid of a closed polygon, whose last corner repeats the first.
pub(super) fn area_and_centroid(corners: &[DVec2]) -> (f64, DVec2) {
    let Some(&origin) = corners.first() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in corners.windows(2) {
        let (a, b) = (pair[0] - origin, pair[1] - origin);
        let cross = a.perp_dot(b);
        area += 0.5 * cross;
        moment += (a + b) * (cross / 6.0);
    }
    if area == 0.0 {
        return (0.0, origin);
    }
    (area, origin + moment / area)
}

/// Points in square cells, for finding those that are near.
pub(super) struct Grid {
    low: DVec2,
    size: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<u32>>,
}

impl Grid {
    pub(super) fn new(outline: &[DVec2], size: f64) -> Self {
        let (low, high) = outline
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), &p| {
                (l.min(p), h.max(p))
            });
        let size = size.max((high - low).max_element() / MAX_GRID_CELLS);
        let count = |x: f64| (x / size) as usize + 1;
        let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
        Grid {
            low,
            size,
            columns,
            rows,
            cells: vec![Vec::new(); columns * rows],
        }
    }

    fn cell_of(&self, p: DVec2) -> (usize, usize) {
        let d = (p - self.low) / self.size;
        (
            (d.x.max(0.0) as usize).min(self.columns - 1),
            (d.y.max(0.0) as usize).min(self.rows - 1),
        )
    }

    pub(super) fn insert(&mut self, number: usize, p: DVec2) {
        let (x, y) = self.cell_of(p);
        self.cells[y * self.columns + x].push(number as u32);
    }

    /// Calls `visit` for all points in the cells up to `reach` cells away.
    fn near(&self, p: DVec2, reach: usize, mut visit: impl FnMut(u32)) {
        let (x, y) = self.cell_of(p);
        for row in y.saturating_sub(reach)..=(y + reach).min(self.rows - 1) {
            for column in x.saturating_sub(reach)..=(x + reach).min(self.columns - 1) {
                self.cells[row * self.columns + column]
                    .iter()
                    .for_each(|&i| visit(i));
            }
        }
    }

    /// Whether any point is closer than `distance`.
    pub(super) fn any_within(&self, points: &[DVec2], p: DVec2, distance: f64) -> bool {
        let mut any = false;
        let reach = (distance / self.size).ceil() as usize;
        self.near(p, reach, |i| {
            any |= points[i as usize].distance_squared(p) < distance * distance
        });
        any
    }
}

/// Largest number of grid cells along an axis, which bounds the memory whatever the spacing.
const MAX_GRID_CELLS: f64 = 4000.0;
/// Marks sides of a cell that lie on the outline.
const OUTLINE: u32 = u32::MAX;

/// A corner of a cell, and the neighbour across the side that begins there.
#[derive(Debug, Clone, Copy)]
struct Corner {
    position: DVec2,
    side: u32,
}

/// Returns the cells of all points.
pub fn voronoi_cells(outline: &[DVec2], points: &[DVec2]) -> Vec<VoronoiCell> {
    // A quiet context is never cancelled.
    cells_of_points(outline, points, &Context::quiet()).unwrap_or_default()
}

/// Returns the cells of all points.
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(super) fn cells_of_points(
    outline: &[DVec2],
    points: &[DVec2],
    context: &Context,
) -> Result<Vec<VoronoiCell>, Cancelled> {
    let area = area_and_centroid(&closed(outline)).0.abs();
    let mut grid = Grid::new(outline, (area / points.len().max(1) as f64).sqrt());
    for (i, &p) in points.iter().enumerate() {
        grid.insert(i, p);
    }
    points
        .iter()
        .enumerate()
        .map(|(i, &p)| {
            context.check()?;
            Ok(cell(outline, points, &grid, i, p))
        })
        .collect()
}

fn closed(corners: &[DVec2]) -> Vec<DVec2> {
    corners.iter().chain(corners.first()).copied().collect()
}

fn cell(outline: &[DVec2], points: &[DVec2], grid: &Grid, number: usize, p: DVec2) -> VoronoiCell {
    let corner = |&position: &DVec2| Corner {
        position,
        side: OUTLINE,
    };
    let mut polygon: Vec<Corner> = outline.iter().map(corner).collect();
    let mut reach = 2;
    let mut done = 0.0;
    loop {
        let limit = reach as f64 * grid.size;
        let mut near: Vec<(f64, u32)> = Vec::new();
        grid.near(p, reach, |i| {
            let d = points[i as usize].distance(p);
            if i as usize != number && d > done && d <= limit {
                near.push((d, i));
            }
        });
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, i) in near {
            polygon = clipped(&polygon, p, points[i as usize], i);
        }
        // Points beyond twice the distance of the farthest corner clip nothing.
        let farthest = (polygon.iter()).fold(0.0f64, |a, c| a.max(c.position.distance(p)));
        if 2.0 * farthest <= limit || reach > grid.columns.max(grid.rows) {
            break;
        }
        done = limit;
        reach *= 2;
    }
    let corners: Vec<DVec2> = polygon.iter().map(|c| c.position).collect();
    let (area, centroid) = area_and_centroid(&closed(&corners));
    VoronoiCell {
        facets: facets_of(&polygon),
        corners,
        area,
        centroid,
    }
}

/// Returns the facets of a cell, by ascending neighbour.
fn facets_of(polygon: &[Corner]) -> Vec<Facet> {
    let mut facets: Vec<Facet> = Vec::new();
    for (k, corner) in polygon.iter().enumerate() {
        if corner.side == OUTLINE {
            continue;
        }
        let next = polygon[(k + 1) % polygon.len()].position;
        let width = corner.position.distance(next);
        match facets.iter_mut().find(|f| f.neighbour == corner.side) {
            Some(facet) => facet.width += width,
            None => facets.push(Facet {
                neighbour: corner.side,
                width,
            }),
        }
    }
    facets.sort_unstable_by_key(|f| f.neighbour);
    facets
}

/// Returns the part of a polygon that is nearer to `p` than to `other`, whose number marks the new side.
fn clipped(polygon: &[Corner], p: DVec2, other: DVec2, number: u32) -> Vec<Corner> {
    let (middle, normal) = (p.midpoint(other), other - p);
    let depth = |c: &Corner| (c.position - middle).dot(normal);
    if polygon.iter().all(|c| depth(c) <= 0.0) {
        return polygon.to_vec();
    }
    let mut clipped = Vec::with_capacity(polygon.len() + 1);
    for (k, a) in polygon.iter().enumerate() {
        let b = &polygon[(k + 1) % polygon.len()];
        let (u, v) = (depth(a), depth(b));
        let cut = |side: u32| Corner {
            position: a.position.lerp(b.position, u / (u - v)),
            side,
        };
        match (u <= 0.0, v <= 0.0) {
            (true, true) => clipped.push(*a),
            (true, false) => clipped.extend([*a, cut(number)]),
            (false, true) => clipped.push(cut(a.side)),
            (false, false) => {}
        }
    }
    clipped
}
