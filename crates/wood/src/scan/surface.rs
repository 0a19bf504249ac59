//! Bark as a surface over (angle, length).

use super::coverage::{MAX_FOLDED_SHARE, Requirements, coverage, mean_coverage, usable_span};
use super::grid::{GridSize, UnrolledGrid};
use super::points::StemPoints;
use super::report::{ScanError, ScanOptions, ScanReport, ScannedBark};
use super::shape::SectionShape;
use super::traced::TracedStem;
use crate::stem::{Frame, StemLocation};
use glam::{DVec2, DVec3};
use greenstick_geometry::triangulate::triangulate;
use greenstick_geometry::{Attribute, Cancelled, Context, Mesh};
use std::ops::Range;

/// Points in a cell on average.
const POINTS_PER_CELL: f64 = 3.0;
/// Noise of a cell's mean over the cell's width: steeper slopes would be the scanner's, not the bark's.
const MAX_NOISE_SLOPE: f64 = 0.12;
/// Greatest width of a cell, in girths.
const MAX_CELL_WIDTH_GIRTHS: f64 = 0.111;
/// Fewest and most cells around.
const CELLS_AROUND: (f64, f64) = (16.0, 720.0);
/// Most cells.
const MAX_CELLS: f64 = 1.0e6;
/// Least coverage that the density of the points is judged by.
const MIN_DENSITY_COVERAGE: f64 = 0.05;

/// The bark about the location at length `at` (m).
pub(super) fn bark(
    points: &StemPoints,
    stem: &TracedStem,
    at: f64,
    options: &ScanOptions,
    context: &Context,
) -> Result<ScannedBark, ScanError> {
    if points.points.is_empty() {
        return Err(ScanError::NoStem { points: 0 });
    }
    let length = stem.axis.length();
    let coverage = coverage(points, stem);
    let required = Requirements {
        min_coverage: options.min_coverage,
        max_folded: MAX_FOLDED_SHARE,
    };
    let span = usable_span(points, &coverage, at, length, required)?;
    let mean_coverage = mean_coverage(&coverage, length);
    let resolved = resolve(points, stem, mean_coverage, context)?;
    let grid = &resolved.grid;
    let size = grid.size;
    let noise_m = noise(points, grid);
    context.check()?;
    let rows: Vec<usize> = (0..size.along)
        .filter(|&i| (span.0..=span.1).contains(&size.length_of(i)))
        .collect();
    let surface = BarkSurface {
        grid,
        rows: &rows,
        stem,
        turns: columns(grid, stem),
    };
    let mesh = surface.mesh(points, options.closed, context)?;
    let in_rows = |k: &usize| rows.contains(&(k / size.around));
    let holes = (0..size.cells())
        .filter(in_rows)
        .filter(|&k| resolved.counts[k] == 0)
        .count();
    let distance = |i: usize| (size.length_of(i) - at).abs();
    let row = rows
        .iter()
        .copied()
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
        .unwrap_or(0);
    let s = size.length_of(row);
    let on_surface = surface.point(&stem.axis.frame(s), 0.0, grid.at(s, 0.0));
    let mean_radius = grid.values.iter().sum::<f64>() / grid.values.len() as f64;
    let report = ScanReport {
        points: points.points.len(),
        foreign_points: points.foreign,
        fracture_points: points.fracture_points,
        stem_length_m: length,
        stem_length_error_m: stem.length_error,
        radius_error_m: stem.radius_error,
        span_m: span.into(),
        radius_m: stem.shape.equal_radius(mean_radius),
        coverage,
        mean_coverage,
        completed: holes as f64 / (rows.len() * size.around).max(1) as f64,
        noise_m,
        cells: [size.around, rows.len()],
        folded: points.folded(0.0, length),
        ..ScanReport::default()
    };
    Ok(ScannedBark {
        mesh,
        centreline: stem.axis.points().to_vec(),
        location: StemLocation::Point(on_surface),
        report,
    })
}

/// Radii over the unrolled bark, and the number of points in each cell.
struct ResolvedRadii {
    grid: UnrolledGrid,
    counts: Vec<usize>,
}

/// The radii at the scan's own resolution: cells so small that noise allows, of some points each.
fn resolve(
    points: &StemPoints,
    stem: &TracedStem,
    coverage: f64,
    context: &Context,
) -> Result<ResolvedRadii, Cancelled> {
    let length = stem.axis.length();
    let girth = stem.shape.girth(stem.mean_radius());
    let area = girth * length;
    let density = points.points.len() as f64 / (area * coverage.max(MIN_DENSITY_COVERAGE));
    let size_of_cells = |width: f64| {
        let width = width.max((area / MAX_CELLS).sqrt());
        let around = (girth / width)
            .round()
            .clamp(CELLS_AROUND.0, CELLS_AROUND.1);
        let along = (length / width).round().clamp(4.0, MAX_CELLS / around);
        GridSize {
            around: around as usize,
            along: along as usize,
            length,
        }
    };
    let fine_width = (POINTS_PER_CELL / density).sqrt();
    let mut resolved = mean_radii(points, size_of_cells(fine_width));
    context.check()?;
    // Points' departures from their own cell's mean: the scanner's noise and relief too fine to be resolved.
    let mut squares = 0.0;
    for p in &points.points {
        let k = resolved.grid.size.cell(p.s, p.turn);
        squares += (p.radius - resolved.grid.values[k]).powi(2);
    }
    let freedoms: usize = resolved.counts.iter().map(|c| c.saturating_sub(1)).sum();
    let sigma = (squares / freedoms.max(1) as f64).sqrt();
    let smooth_width = (sigma / (MAX_NOISE_SLOPE * density.sqrt())).sqrt();
    if smooth_width > fine_width {
        let width = smooth_width.min(MAX_CELL_WIDTH_GIRTHS * girth);
        resolved = mean_radii(points, size_of_cells(width));
    }
    resolved.grid.complete(|s| stem.radius(s), context)?;
    Ok(resolved)
}

/// Mean radius of the points in each cell.
fn mean_radii(points: &StemPoints, size: GridSize) -> ResolvedRadii {
    let mut grid = UnrolledGrid::new(size);
    let mut counts = vec![0usize; size.cells()];
    for p in &points.points {
        let k = size.cell(p.s, p.turn);
        grid.values[k] += p.radius;
        counts[k] += 1;
    }
    for (k, &count) in counts.iter().enumerate().filter(|c| *c.1 > 0) {
        grid.set(k, grid.values[k] / count as f64);
    }
    ResolvedRadii { grid, counts }
}

/// Standard deviation of the points from the surface.
fn noise(points: &StemPoints, grid: &UnrolledGrid) -> f64 {
    let squares: f64 = points
        .points
        .iter()
        .map(|p| (p.radius - grid.at(p.s, p.turn)).powi(2))
        .sum();
    (squares / points.points.len() as f64).sqrt()
}

/// Angles of the surface's lines along the stem, in turns: the cells' middles, and corners in place of those near them.
fn columns(grid: &UnrolledGrid, stem: &TracedStem) -> Vec<f64> {
    /// Middles within this part of a cell of a corner give way to it.
    const CORNER_CLEARANCE: f64 = 0.3;
    let around = grid.size.around as f64;
    let corners = stem.shape.corners();
    let apart = |a: f64, b: f64| ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs();
    let clear = |t: &f64| {
        corners
            .iter()
            .all(|c| apart(*c, *t) > CORNER_CLEARANCE / around)
    };
    let mut turns: Vec<f64> = (0..grid.size.around)
        .map(|j| (j as f64 + 0.5) / around)
        .filter(clear)
        .chain(corners.iter().copied())
        .collect();
    turns.sort_by(f64::total_cmp);
    turns
}

/// Radii over the unrolled bark as a surface in space.
struct BarkSurface<'a> {
    grid: &'a UnrolledGrid,
    /// Rows of the grid that the surface spans.
    rows: &'a [usize],
    stem: &'a TracedStem,
    /// Angles of the lines along the stem, in turns.
    turns: Vec<f64>,
}

impl BarkSurface<'_> {
    /// The point at an angle and a radius of a section.
    fn point(&self, frame: &Frame, turn: f64, radius: f64) -> DVec3 {
        let p = self.stem.shape.point(turn, radius);
        frame.origin + frame.x * p.x + frame.y * p.y
    }

    /// The rows as a mesh, with caps where it is to be closed, and with the points' colours.
    fn mesh(
        &self,
        points: &StemPoints,
        closed: bool,
        context: &Context,
    ) -> Result<Mesh, Cancelled> {
        let around = self.turns.len();
        let size = self.grid.size;
        let mut mesh = Mesh::default();
        for &i in self.rows {
            context.check()?;
            let s = size.length_of(i);
            let frame = self.stem.axis.frame(s);
            let at = |t: &f64| self.point(&frame, *t, self.grid.at(s, *t));
            mesh.positions.extend(self.turns.iter().map(at));
        }
        let vertex = |i: usize, j: usize| (i * around + j % around) as u32;
        for i in 0..self.rows.len().saturating_sub(1) {
            for j in 0..around {
                let [a, b] = [vertex(i, j), vertex(i, j + 1)];
                let [c, d] = [vertex(i + 1, j + 1), vertex(i + 1, j)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        if closed && let (Some(&first), Some(&last)) = (self.rows.first(), self.rows.last()) {
            for (row, index, flipped) in [(first, 0, true), (last, self.rows.len() - 1, false)] {
                let rim = vertex(index, 0)..vertex(index, 0) + around as u32;
                let frame = self.stem.axis.frame(size.length_of(row));
                cap(&mut mesh, self.stem.shape, rim, frame, flipped);
            }
        }
        if !points.cloud.colours.is_empty() {
            let colours = self.colours(points, mesh.positions.len(), context)?;
            mesh.attributes.insert("COLOR_0".to_owned(), colours);
        }
        Ok(mesh)
    }

    /// Colours of the points, averaged by cell and extended into holes; caps have those of the last row.
    fn colours(
        &self,
        points: &StemPoints,
        vertices: usize,
        context: &Context,
    ) -> Result<Attribute, Cancelled> {
        let size = self.grid.size;
        let mut channels: Vec<UnrolledGrid> = Vec::new();
        for channel in 0..3 {
            context.check()?;
            let mut grid = UnrolledGrid::new(size);
            let mut counts = vec![0usize; size.cells()];
            for p in &points.points {
                let k = size.cell(p.s, p.turn);
                let colour = points.cloud.colours[p.number as usize];
                grid.values[k] += f64::from(colour[channel]) / 255.0;
                counts[k] += 1;
            }
            for (k, &count) in counts.iter().enumerate().filter(|c| *c.1 > 0) {
                grid.set(k, grid.values[k] / count as f64);
            }
            grid.complete(|_| 0.0, context)?;
            channels.push(grid);
        }
        let mut data = Vec::with_capacity(3 * vertices);
        for &i in self.rows {
            let s = size.length_of(i);
            for turn in &self.turns {
                data.extend(channels.iter().map(|c| c.at(s, *turn) as f32));
            }
        }
        let tail = data[data.len().saturating_sub(3)..].to_vec();
        while !tail.is_empty() && data.len() < 3 * vertices {
            data.extend(&tail);
        }
        Ok(Attribute { width: 3, data })
    }
}

/// Closes the rim of a section: about its middle where it is round. Of a board's rim not every point is seen from there.
fn cap(mesh: &mut Mesh, shape: SectionShape, rim: Range<u32>, frame: Frame, flipped: bool) {
    let mut triangles = Vec::new();
    if shape != SectionShape::Round {
        let flat: Vec<DVec2> = mesh.positions[rim.start as usize..rim.end as usize]
            .iter()
            .map(|p| *p - frame.origin)
            .map(|d| DVec2::new(d.dot(frame.x), d.dot(frame.y)))
            .collect();
        if triangulate(&flat, &mut triangles).is_err() {
            triangles.clear();
        }
    }
    if triangles.is_empty() {
        let (middle, around) = (mesh.positions.len() as u32 - rim.start, rim.len() as u32);
        mesh.positions.push(frame.origin);
        triangles.extend((0..around).map(|j| [middle, j, (j + 1) % around]));
    }
    mesh.triangles
        .extend(triangles.into_iter().map(|[a, b, c]| {
            let triangle = if flipped { [a, c, b] } else { [a, b, c] };
            triangle.map(|v| v + rim.start)
        }));
}
