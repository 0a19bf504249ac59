//! Voronoi cells of rod points in a section, cut by its outline, with the widths of the facets between neighbours.

use glam::DVec2;

/// The cell of a rod point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cell {
    /// Corners, counter-clockwise, m.
    pub corners: Vec<DVec2>,
    /// Area, m².
    pub area: f64,
    /// Centroid, m.
    pub centroid: DVec2,
    /// Neighbours by ascending number, each with the facet's width, m.
    pub facets: Vec<(u32, f64)>,
}

/// Whether a point is inside a closed outline.
pub fn inside(outline: &[DVec2], p: DVec2) -> bool {
    let mut odd = false;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)) {
            odd = !odd;
        }
    }
    odd
}

/// Twice the signed area and the centroid of a closed polygon.
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

/// Points in square boxes, to find those that are near.
pub(super) struct Grid {
    low: DVec2,
    size: f64,
    columns: usize,
    rows: usize,
    boxes: Vec<Vec<u32>>,
}

impl Grid {
    pub(super) fn new(outline: &[DVec2], size: f64) -> Self {
        let (low, high) = outline
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), &p| {
                (l.min(p), h.max(p))
            });
        // No more boxes than memory has room for, whatever the size.
        let size = size.max((high - low).max_element() / 4000.0);
        let count = |x: f64| (x / size) as usize + 1;
        let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
        Grid {
            low,
            size,
            columns,
            rows,
            boxes: vec![Vec::new(); columns * rows],
        }
    }

    fn place(&self, p: DVec2) -> (usize, usize) {
        let d = (p - self.low) / self.size;
        (
            (d.x.max(0.0) as usize).min(self.columns - 1),
            (d.y.max(0.0) as usize).min(self.rows - 1),
        )
    }

    pub(super) fn insert(&mut self, number: usize, p: DVec2) {
        let (x, y) = self.place(p);
        self.boxes[y * self.columns + x].push(number as u32);
    }

    /// Calls `visit` for all in the boxes up to `reach` boxes away.
    fn near(&self, p: DVec2, reach: usize, mut visit: impl FnMut(u32)) {
        let (x, y) = self.place(p);
        for row in y.saturating_sub(reach)..=(y + reach).min(self.rows - 1) {
            for column in x.saturating_sub(reach)..=(x + reach).min(self.columns - 1) {
                self.boxes[row * self.columns + column]
                    .iter()
                    .for_each(|&i| visit(i));
            }
        }
    }

    pub(super) fn any_within(&self, points: &[DVec2], p: DVec2, distance: f64) -> bool {
        let mut any = false;
        let reach = (distance / self.size).ceil() as usize;
        self.near(p, reach, |i| {
            any |= points[i as usize].distance_squared(p) < distance * distance
        });
        any
    }
}

/// The side of a cell that lies on the outline.
const OUTLINE: u32 = u32::MAX;

/// The cells of all points.
pub fn cells(outline: &[DVec2], points: &[DVec2]) -> Vec<Cell> {
    let area = area_and_centroid(&closed(outline)).0.abs();
    let mut grid = Grid::new(outline, (area / points.len().max(1) as f64).sqrt());
    for (i, &p) in points.iter().enumerate() {
        grid.insert(i, p);
    }
    points
        .iter()
        .enumerate()
        .map(|(i, &p)| cell(outline, points, &grid, i, p))
        .collect()
}

fn closed(corners: &[DVec2]) -> Vec<DVec2> {
    corners.iter().chain(corners.first()).copied().collect()
}

fn cell(outline: &[DVec2], points: &[DVec2], grid: &Grid, number: usize, p: DVec2) -> Cell {
    // Corners, each with the name of the side that begins there.
    let mut polygon: Vec<(DVec2, u32)> = outline.iter().map(|&c| (c, OUTLINE)).collect();
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
        // Points beyond twice the farthest corner cut nothing.
        let farthest = polygon.iter().fold(0.0f64, |a, c| a.max(c.0.distance(p)));
        if 2.0 * farthest <= limit || reach > grid.columns.max(grid.rows) {
            break;
        }
        done = limit;
        reach *= 2;
    }
    let corners: Vec<DVec2> = polygon.iter().map(|c| c.0).collect();
    let (area, centroid) = area_and_centroid(&closed(&corners));
    let mut facets: Vec<(u32, f64)> = Vec::new();
    for (k, &(corner, side)) in polygon.iter().enumerate() {
        if side != OUTLINE {
            let width = corner.distance(polygon[(k + 1) % polygon.len()].0);
            match facets.iter_mut().find(|f| f.0 == side) {
                Some(f) => f.1 += width,
                None => facets.push((side, width)),
            }
        }
    }
    facets.sort_unstable_by_key(|f| f.0);
    Cell {
        corners,
        area,
        centroid,
        facets,
    }
}

/// The part of a polygon that is nearer to `p` than to `other`.
fn clipped(polygon: &[(DVec2, u32)], p: DVec2, other: DVec2, side: u32) -> Vec<(DVec2, u32)> {
    let (middle, normal) = (p.midpoint(other), other - p);
    let depth = |c: DVec2| (c - middle).dot(normal);
    if polygon.iter().all(|c| depth(c.0) <= 0.0) {
        return polygon.to_vec();
    }
    let mut made = Vec::with_capacity(polygon.len() + 1);
    for (k, &(a, name)) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()].0;
        let (u, v) = (depth(a), depth(b));
        let cut = || a.lerp(b, u / (u - v));
        match (u <= 0.0, v <= 0.0) {
            (true, true) => made.push((a, name)),
            (true, false) => {
                made.push((a, name));
                made.push((cut(), side));
            }
            (false, true) => made.push((cut(), name)),
            (false, false) => {}
        }
    }
    made
}
