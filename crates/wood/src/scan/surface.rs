//! Bark as a surface over (angle, length).

use super::field::Field;
use super::points::Addressed;
use super::report::{Cover, ScanError, ScanOptions, ScanReport, ScannedBark};
use super::section::Section;
use super::{Followed, MOST_FOLDED};
use crate::stem::{Frame, Place};
use glam::{DVec2, DVec3};
use greenstick_geometry::triangulate::triangulate;
use greenstick_geometry::{Attribute, Mesh};
use std::ops::Range;

/// Points in a cell on average.
const PER_CELL: f64 = 3.0;
/// Noise of a cell's mean over the cell's width: steeper slopes would be the scanner's, not the bark's.
const SLOPE: f64 = 0.12;
/// Width of a cell, at most, in girths.
const MOST_WIDTH: f64 = 0.111;
/// Fewest and most cells around.
const AROUND: (f64, f64) = (16.0, 720.0);
/// Most cells.
const MOST_CELLS: f64 = 1.0e6;
/// Cover is told for parts of this length, m.
const PART: f64 = 1.0;

/// The bark about the place at length `at`.
pub(super) fn bark(
    addressed: &Addressed,
    followed: &Followed,
    at: f64,
    options: &ScanOptions,
) -> Result<ScannedBark, ScanError> {
    if addressed.points.is_empty() {
        return Err(ScanError::NoStem { points: 0 });
    }
    let length = followed.axis.length();
    let cover = covers(addressed, followed);
    let least = options.least_cover;
    let span = span(addressed, &cover, at, length, least, MOST_FOLDED)?;
    let mean_cover = cover
        .iter()
        .map(|c| c.share * (c.to_m - c.from_m))
        .sum::<f64>()
        / length;
    let (field, counts) = resolved(addressed, followed, mean_cover);
    let noise_m = noise(addressed, &field);
    let rows = rows_in(&field, span);
    let mesh = mesh(&field, &rows, followed, addressed, options.closed);
    let inside = |k: &usize| rows.contains(&(k / field.around));
    let cells = rows.len() * field.around;
    let holes = (0..field.known.len())
        .filter(inside)
        .filter(|&k| counts[k] == 0)
        .count();
    let row = rows
        .iter()
        .copied()
        .min_by(|a, b| {
            let off = |i: usize| (field.length_of(i) - at).abs();
            off(*a).total_cmp(&off(*b))
        })
        .unwrap_or(0);
    let frame = followed.axis.frame(field.length_of(row));
    let report = ScanReport {
        points: addressed.points.len(),
        strangers: addressed.strangers,
        fracture_points: addressed.face,
        stem_length_m: length,
        span_m: span.into(),
        radius_m: followed
            .section
            .equal_radius(field.values.iter().sum::<f64>() / field.values.len() as f64),
        cover,
        mean_cover,
        completed: holes as f64 / cells.max(1) as f64,
        noise_m,
        cells: [field.around, rows.len()],
        folded: addressed.folded(0.0, length),
        notes: Vec::new(),
    };
    Ok(ScannedBark {
        mesh,
        centreline: followed.axis.points().to_vec(),
        place: Place::Point(on(
            &frame,
            followed,
            0.0,
            field.at(field.length_of(row), 0.0),
        )),
        report,
    })
}

/// Rings of the field whose middles lie in a range.
fn rows_in(field: &Field, span: (f64, f64)) -> Vec<usize> {
    (0..field.along)
        .filter(|&i| (span.0..=span.1).contains(&field.length_of(i)))
        .collect()
}

/// The share of the girth that was seen, part by part: of sectors so wide that chance leaves hardly one empty.
pub(super) fn covers(addressed: &Addressed, followed: &Followed) -> Vec<Cover> {
    let length = followed.axis.length();
    let mean = followed.mean_radius();
    let slabs = ((length / mean).round() as usize).clamp(2, 20_000);
    let mut turns: Vec<Vec<f64>> = vec![Vec::new(); slabs];
    for p in &addressed.points {
        let k = ((p.s / length * slabs as f64) as usize).min(slabs - 1);
        turns[k].push(p.turn);
    }
    let share = |turns: &Vec<f64>| {
        let sectors = (turns.len() / 5).clamp(8, 72);
        let mut seen = vec![false; sectors];
        turns
            .iter()
            .for_each(|t| seen[((t * sectors as f64) as usize).min(sectors - 1)] = true);
        seen.iter().filter(|s| **s).count() as f64 / sectors as f64
    };
    let shares: Vec<f64> = turns.iter().map(share).collect();
    let parts = ((length / PART).ceil() as usize).max(1);
    (0..parts)
        .map(|k| {
            let (from, to) = (k as f64 * PART, ((k + 1) as f64 * PART).min(length));
            let slab = |s: f64| ((s / length * slabs as f64) as usize).min(slabs - 1);
            let part = &shares[slab(from)..=slab(to - 1e-9 * length)];
            Cover {
                from_m: from,
                to_m: to,
                share: part.iter().sum::<f64>() / part.len() as f64,
            }
        })
        .collect()
}

/// The parts about a place of which enough was seen, and of which no more than a share is folded.
pub(super) fn span(
    addressed: &Addressed,
    cover: &[Cover],
    at: f64,
    length: f64,
    least: f64,
    most: f64,
) -> Result<(f64, f64), ScanError> {
    let k = ((at / PART) as usize).min(cover.len() - 1);
    let folded = |k: usize| addressed.folded(cover[k].from_m, cover[k].to_m);
    let enough = |k: usize| cover[k].share >= least && folded(k) <= most;
    if folded(k) > most {
        return Err(ScanError::NotStarShaped {
            from: cover[k].from_m,
            to: cover[k].to_m,
            share: folded(k),
            most,
        });
    }
    if !enough(k) {
        return Err(ScanError::LittleCover {
            cover: cover[k],
            least,
        });
    }
    let first = (0..=k).rev().take_while(|&k| enough(k)).last().unwrap_or(k);
    let last = (k..cover.len())
        .take_while(|&k| enough(k))
        .last()
        .unwrap_or(k);
    Ok((cover[first].from_m, cover[last].to_m.min(length)))
}

/// The surface at the scan's own resolution, and the points in each cell.
fn resolved(addressed: &Addressed, followed: &Followed, cover: f64) -> (Field, Vec<usize>) {
    let length = followed.axis.length();
    let girth = followed.section.girth(followed.mean_radius());
    let area = girth * length;
    let density = addressed.points.len() as f64 / (area * cover.max(0.05));
    let grid = |width: f64| {
        let width = width.max((area / MOST_CELLS).sqrt());
        let around = (girth / width).round().clamp(AROUND.0, AROUND.1);
        let along = (length / width).round().clamp(4.0, MOST_CELLS / around);
        (around as usize, along as usize)
    };
    let fine = (PER_CELL / density).sqrt();
    let (around, along) = grid(fine);
    let (first, counts) = means(addressed, around, along, length);
    // Points' departures from their own cell's mean: the scanner's noise and relief too fine to be resolved.
    let (mut squares, mut freedoms) = (0.0, 0usize);
    for p in &addressed.points {
        let k = Field::cell(p.s, p.turn, around, along, length);
        squares += (p.radius - first.values[k]).powi(2);
    }
    freedoms += counts.iter().map(|c| c.saturating_sub(1)).sum::<usize>();
    let sigma = (squares / freedoms.max(1) as f64).sqrt();
    let calm = (sigma / (SLOPE * density.sqrt())).sqrt();
    let (mut field, counts) = if calm > fine {
        let (around, along) = grid(calm.min(MOST_WIDTH * girth));
        means(addressed, around, along, length)
    } else {
        (first, counts)
    };
    field.complete(|s| followed.radius(s));
    (field, counts)
}

/// Mean radius of the points in each cell.
fn means(addressed: &Addressed, around: usize, along: usize, length: f64) -> (Field, Vec<usize>) {
    let mut field = Field::new(around, along, length);
    let mut counts = vec![0usize; around * along];
    for p in &addressed.points {
        let k = Field::cell(p.s, p.turn, around, along, length);
        field.values[k] += p.radius;
        counts[k] += 1;
    }
    for (k, &count) in counts.iter().enumerate().filter(|c| *c.1 > 0) {
        field.set(k, field.values[k] / count as f64);
    }
    (field, counts)
}

/// Standard deviation of the points from the surface.
fn noise(addressed: &Addressed, field: &Field) -> f64 {
    let squares: f64 = addressed
        .points
        .iter()
        .map(|p| (p.radius - field.at(p.s, p.turn)).powi(2))
        .sum();
    (squares / addressed.points.len() as f64).sqrt()
}

/// The point at an angle and a radius of a section.
fn on(frame: &Frame, followed: &Followed, turn: f64, radius: f64) -> DVec3 {
    let p = followed.section.point(turn, radius);
    frame.origin + frame.x * p.x + frame.y * p.y
}

/// Angles of the surface's lines along the stem, in turns: the cells' middles, and corners in place of those near them.
fn columns(field: &Field, followed: &Followed) -> Vec<f64> {
    const NEAR: f64 = 0.3;
    let corners = followed.section.corners();
    let apart = |a: f64, b: f64| ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs();
    let mut turns: Vec<f64> = (0..field.around)
        .map(|j| (j as f64 + 0.5) / field.around as f64)
        .filter(|t| {
            corners
                .iter()
                .all(|c| apart(*c, *t) > NEAR / field.around as f64)
        })
        .chain(corners.iter().copied())
        .collect();
    turns.sort_by(f64::total_cmp);
    turns
}

/// The field's rings as a mesh, with caps where it is to be closed.
fn mesh(
    field: &Field,
    rows: &[usize],
    followed: &Followed,
    addressed: &Addressed,
    closed: bool,
) -> Mesh {
    let turns = columns(field, followed);
    let around = turns.len();
    let mut mesh = Mesh::default();
    for &i in rows {
        let s = field.length_of(i);
        let frame = followed.axis.frame(s);
        mesh.positions.extend(
            turns
                .iter()
                .map(|t| on(&frame, followed, *t, field.at(s, *t))),
        );
    }
    let vertex = |i: usize, j: usize| (i * around + j % around) as u32;
    for i in 0..rows.len().saturating_sub(1) {
        for j in 0..around {
            let [a, b] = [vertex(i, j), vertex(i, j + 1)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if closed && let (Some(&first), Some(&last)) = (rows.first(), rows.last()) {
        for (row, ring, turned) in [(first, 0, true), (last, rows.len() - 1, false)] {
            let rim = vertex(ring, 0)..vertex(ring, 0) + around as u32;
            let middle = followed.axis.frame(field.length_of(row));
            cap(&mut mesh, followed.section, rim, middle, turned);
        }
    }
    if !addressed.cloud.colours.is_empty() {
        let colours = colours(field, rows, &turns, addressed, mesh.positions.len());
        mesh.attributes.insert("COLOR_0".to_owned(), colours);
    }
    mesh
}

/// Closes the rim of a section: about its middle where it is round. Of a board's rim not every point is seen from there.
fn cap(mesh: &mut Mesh, section: Section, rim: Range<u32>, frame: Frame, turned: bool) {
    let mut triangles = Vec::new();
    if section != Section::Round {
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
            let triangle = if turned { [a, c, b] } else { [a, b, c] };
            triangle.map(|v| v + rim.start)
        }));
}

/// Colours of the points, averaged by cell and carried into holes; caps have the last ring's.
fn colours(
    field: &Field,
    rows: &[usize],
    turns: &[f64],
    addressed: &Addressed,
    vertices: usize,
) -> Attribute {
    let mut parts: Vec<Field> = Vec::new();
    for channel in 0..3 {
        let mut of = Field::new(field.around, field.along, field.length);
        let mut counts = vec![0usize; of.values.len()];
        for p in &addressed.points {
            let k = Field::cell(p.s, p.turn, of.around, of.along, of.length);
            of.values[k] += f64::from(addressed.cloud.colours[p.number as usize][channel]) / 255.0;
            counts[k] += 1;
        }
        for (k, &count) in counts.iter().enumerate().filter(|c| *c.1 > 0) {
            of.set(k, of.values[k] / count as f64);
        }
        of.complete(|_| 0.0);
        parts.push(of);
    }
    let mut data = Vec::with_capacity(3 * vertices);
    for &i in rows {
        let s = field.length_of(i);
        for turn in turns {
            data.extend(parts.iter().map(|c| c.at(s, *turn) as f32));
        }
    }
    let tail = data[data.len().saturating_sub(3)..].to_vec();
    while !tail.is_empty() && data.len() < 3 * vertices {
        data.extend(&tail);
    }
    Attribute { width: 3, data }
}
