//! Where to begin following a stem: a first section across it.

use super::polygon;
use super::surface::Surface;
use super::trace::{Cut, Trace, section, settle, trace};
use glam::{DMat3, DVec2, DVec3};

/// Stations along a shell's longest direction at which a first section is tried.
const STATIONS: [f64; 7] = [0.5, 0.25, 0.75, 0.1, 0.9, 0.38, 0.62];
/// A trace over this part of the shell's extent is the whole stem; no other start is tried.
const WHOLE: f64 = 0.8;

/// Eigenvector of the largest eigenvalue of a symmetric matrix, by squaring.
fn strongest(mut matrix: DMat3) -> DVec3 {
    for _ in 0..12 {
        let size = matrix
            .to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        if size == 0.0 {
            return DVec3::Y;
        }
        matrix *= 1.0 / size;
        matrix *= matrix;
    }
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let mut best = columns[0];
    for c in columns {
        if c.length_squared() > best.length_squared() {
            best = c;
        }
    }
    best.try_normalize().unwrap_or(DVec3::Y)
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Middle of a shell and its directions by area, the longest first.
fn directions(surface: &Surface) -> (DVec3, [DVec3; 3]) {
    // Some ten thousand triangles, evenly taken, tell the directions of any mesh.
    let stride = (surface.count() / 20_000).max(1);
    let (mut weight, mut mean) = (0.0, DVec3::ZERO);
    for i in (0..surface.count()).step_by(stride) {
        let [a, b, c] = surface.corners(i);
        let area = (b - a).cross(c - a).length();
        weight += area;
        mean += (a + b + c) * (area / 3.0);
    }
    mean /= weight.max(f64::MIN_POSITIVE);
    let mut spread = DMat3::ZERO;
    for i in (0..surface.count()).step_by(stride) {
        let [a, b, c] = surface.corners(i).map(|p| p - mean);
        let area = (b - a).cross(c - a).length();
        // Second moment of a triangle from its corners and its middle, so that coarse meshes count right.
        let m = (a + b + c) / 3.0;
        spread += (outer(a) + outer(b) + outer(c) + outer(m) * 9.0) * (area / 12.0);
    }
    let longest = strongest(spread);
    let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    let shortest = strongest(DMat3::from_diagonal(DVec3::splat(trace)) - spread);
    let shortest = shortest.reject_from(longest).try_normalize();
    let shortest = shortest.unwrap_or_else(|| longest.any_orthonormal_vector());
    (mean, [longest, shortest.cross(longest), shortest])
}

/// The stem that runs along a shell: of the traces from several starts the one of largest volume.
pub(crate) fn main_stem(surface: &Surface) -> Option<Trace> {
    let (mean, directions) = directions(surface);
    // A stump with its roots is wider than high: the other directions count where the longest does not show it whole.
    let mut best: Option<Trace> = None;
    for direction in directions {
        let Some((found, whole)) = along(surface, mean, direction) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| found.volume() > b.volume()) {
            best = Some(found);
        }
        if whole {
            break;
        }
    }
    best.or_else(|| from_places(surface))
}

/// The best trace from starts along one direction, and whether it runs along the whole shell.
fn along(surface: &Surface, mean: DVec3, direction: DVec3) -> Option<(Trace, bool)> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (middle, half, _) in surface.cells() {
        let (at, by) = ((middle - mean).dot(direction), half.dot(direction.abs()));
        (low, high) = (low.min(at - by), high.max(at + by));
    }
    let mut best: Option<Trace> = None;
    let mut whole = false;
    for station in STATIONS {
        let origin = mean + direction * (low + (high - low) * station);
        let Some(start) = thickest(surface, origin, direction) else {
            continue;
        };
        // Where the direction does not settle, as in a stump with its roots, that of the spread has to do.
        let seed = settle(surface, start, direction).or_else(|| {
            let cut = section(surface, start, direction, 0.0)?;
            (cut.radius > 0.2 * surface.shortest_side()).then_some(cut)
        });
        let Some(seed) = seed else { continue };
        let found = trace(surface, seed, true);
        whole = (found.tips[1] - found.tips[0]).dot(direction).abs() > WHOLE * (high - low);
        let better = best.as_ref().is_none_or(|b| found.volume() > b.volume());
        if better {
            best = Some(found);
        }
        if whole {
            break;
        }
    }
    best.map(|trace| (trace, whole))
}

/// The best trace from places on the surface: for what is curled so that no plane across its extent meets it well.
fn from_places(surface: &Surface) -> Option<Trace> {
    const PLACES: usize = 5;
    let mut best: Option<Trace> = None;
    let count = surface.count();
    for k in 0..PLACES {
        if count == 0 {
            break;
        }
        let [a, b, c] = surface.corners((2 * k + 1) * count / (2 * PLACES));
        let Some(seed) = at_point(surface, (a + b + c) / 3.0) else {
            continue;
        };
        let found = trace(surface, seed, true);
        if best.as_ref().is_none_or(|b| found.volume() > b.volume()) {
            best = Some(found);
        }
    }
    best
}

/// The box of a straight piece of sawn wood.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plank {
    /// Middle of the end with the smaller coordinate along `direction`, m.
    pub end: DVec3,
    /// Along the longest side (unit).
    pub direction: DVec3,
    /// Along the second longest side (unit).
    pub wide: DVec3,
    /// Lengths of the sides, the longest first, m.
    pub size: [f64; 3],
}

/// The smallest box about a shell whose shortest side is that of its spread.
pub(crate) fn plank(surface: &Surface) -> Option<Plank> {
    let (mean, [_, _, thin]) = directions(surface);
    let (x, y) = super::trace::across(thin);
    let mut flat = Vec::with_capacity(3 * surface.count());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..surface.count() {
        for p in surface.corners(i).map(|p| p - mean) {
            flat.push(DVec2::new(p.dot(x), p.dot(y)));
            (low, high) = (low.min(p.dot(thin)), high.max(p.dot(thin)));
        }
    }
    let r = polygon::smallest_rectangle(&flat)?;
    let direction = x * r.wide.x + y * r.wide.y;
    let middle = mean + x * r.centre.x + y * r.centre.y + thin * (0.5 * (low + high));
    let other = thin.cross(direction);
    let thickness = high - low;
    let (wide, width, thickness) = if r.thickness >= thickness {
        (other, r.thickness, thickness)
    } else {
        (thin, thickness, r.thickness)
    };
    let end = middle - direction * (0.5 * r.width);
    Some(Plank {
        end,
        direction,
        wide,
        size: [r.width, width, thickness],
    })
}

/// Parts of a rectangle and of a box that a board fills at least: an octagon fills 0.83 of its rectangle, one whose
/// corners are rounded by a sixth of its width 0.98; a limb of four sides that tapers to half fills 0.58 of its box.
const RECTANGULAR: f64 = 0.93;
const BOX_FILLED: f64 = 0.7;

/// Whether sections along the box are rectangles that mostly fill it.
pub(crate) fn is_board(surface: &Surface, plank: &Plank) -> bool {
    const PLANES: usize = 21;
    let (mut filled, mut rectangles) = (0.0, 0);
    for k in 0..PLANES {
        let s = plank.size[0] * (k as f64 + 0.5) / PLANES as f64;
        let Some(cut) = section(
            surface,
            plank.end + plank.direction * s,
            plank.direction,
            plank.size[1],
        ) else {
            continue;
        };
        let (x, y) = super::trace::across(cut.normal);
        let flat: Vec<DVec2> = cut
            .points
            .iter()
            .map(|p| DVec2::new(p.dot(x), p.dot(y)))
            .collect();
        let Some(r) = polygon::smallest_rectangle(&flat) else {
            continue;
        };
        filled += cut.area / (plank.size[1] * plank.size[2]);
        rectangles += usize::from(cut.area > RECTANGULAR * r.width * r.thickness);
    }
    // Grooves, notches and handles may cut into more than half of the length.
    filled > BOX_FILLED * PLANES as f64 && rectangles * 5 > PLANES * 2
}

/// Centre of the largest closed loop of a plane.
fn thickest(surface: &Surface, origin: DVec3, normal: DVec3) -> Option<DVec3> {
    let mut best: Option<(f64, DVec3)> = None;
    for line in surface.slice(origin, normal) {
        if !line.closed {
            continue;
        }
        let first = line.points[0];
        let (mut area, mut middle) = (DVec3::ZERO, DVec3::ZERO);
        for (i, &p) in line.points.iter().enumerate() {
            let next = line.points[(i + 1) % line.points.len()];
            area += (p - first).cross(next - first);
            middle += p;
        }
        let area = area.length();
        if best.is_none_or(|(a, _)| area > a) {
            best = Some((area, middle / line.points.len() as f64));
        }
    }
    best.map(|(_, middle)| middle)
}

/// The section of the limb at a point on the surface. Of planes in many directions the one with the smallest closed
/// loop at the point is nearly across the limb.
pub(crate) fn at_point(surface: &Surface, point: DVec3) -> Option<Cut> {
    let mut directions: Vec<DVec3> = Vec::new();
    for x in -2i32..=2 {
        for y in -2i32..=2 {
            for z in 0i32..=2 {
                let edge = x.abs().max(y.abs()).max(z.abs()) == 2;
                let half = z > 0 || y > 0 || (y == 0 && x > 0);
                if edge && half {
                    directions.push(DVec3::new(x.into(), y.into(), z.into()).normalize());
                }
            }
        }
    }
    let mut cuts: Vec<Cut> = directions
        .into_iter()
        .filter_map(|d| section(surface, point, d, 0.0).or_else(|| nearby(surface, point, d)))
        .collect();
    cuts.sort_by(|a, b| a.area.total_cmp(&b.area));
    cuts.iter().take(6).find_map(|cut| {
        let settled = settle(surface, cut.centre, cut.normal)?;
        (settled.centre.distance(point) < 2.0 * settled.reach).then_some(settled)
    })
}

/// The loop through a surface point, which lies on it only up to rounding.
fn nearby(surface: &Surface, point: DVec3, direction: DVec3) -> Option<Cut> {
    let cut = section(surface, point, direction, f64::INFINITY)?;
    let near = cut
        .points
        .iter()
        .map(|p| p.distance(point))
        .fold(f64::INFINITY, f64::min);
    (near < cut.reach).then_some(cut)
}
