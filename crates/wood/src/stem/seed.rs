//! Where to begin following a stem: a first section across it.

use super::principal::PrincipalAxes;
use super::section::{ShellSection, aligned_section, section};
use super::surface::Surface;
use super::trace::{AtForks, Trace, trace};
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Stations along a shell's longest direction at which a first section is tried.
const STATIONS: [f64; 7] = [0.5, 0.25, 0.75, 0.1, 0.9, 0.38, 0.62];
/// A trace over this part of the shell's extent is the whole stem; no other start is tried.
const WHOLE_EXTENT: f64 = 0.8;

/// The stem that runs along a shell: of the traces from several starts the one of largest volume.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn main_stem(surface: &Surface, context: &Context) -> Result<Option<Trace>, Cancelled> {
    context.check()?;
    let axes = PrincipalAxes::new(surface);
    // A stump with its roots is wider than high: the other directions count where the longest does not show it whole.
    let mut best: Option<Trace> = None;
    for direction in axes.directions {
        let Some((found, whole)) = trace_along(surface, axes.centroid, direction, context)? else {
            continue;
        };
        keep_larger(&mut best, found);
        if whole {
            break;
        }
    }
    match best {
        Some(best) => Ok(Some(best)),
        None => trace_from_places(surface, context),
    }
}

fn keep_larger(best: &mut Option<Trace>, found: Trace) {
    if best.as_ref().is_none_or(|b| found.volume() > b.volume()) {
        *best = Some(found);
    }
}

/// The best trace from starts along one direction, and whether it runs along the whole shell.
fn trace_along(
    surface: &Surface,
    mean: DVec3,
    direction: DVec3,
    context: &Context,
) -> Result<Option<(Trace, bool)>, Cancelled> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for cell in surface.cells() {
        let at = (cell.middle - mean).dot(direction);
        let by = cell.half.dot(direction.abs());
        (low, high) = (low.min(at - by), high.max(at + by));
    }
    let mut best: Option<Trace> = None;
    let mut whole = false;
    for station in STATIONS {
        context.check()?;
        let origin = mean + direction * (low + (high - low) * station);
        let Some(start) = centre_of_largest_loop(surface, origin, direction) else {
            continue;
        };
        // Where the direction does not converge, as in a stump with its roots, that of the spread has to do.
        let seed = aligned_section(surface, start, direction).or_else(|| {
            let cut = section(surface, start, direction, 0.0)?;
            (cut.radius > 0.2 * surface.shortest_side()).then_some(cut)
        });
        let Some(seed) = seed else { continue };
        let found = trace(surface, seed, AtForks::GoOn, context)?;
        let extent = (found.tips[1] - found.tips[0]).dot(direction).abs();
        whole = extent > WHOLE_EXTENT * (high - low);
        keep_larger(&mut best, found);
        if whole {
            break;
        }
    }
    Ok(best.map(|trace| (trace, whole)))
}

/// The best trace from places on the surface: for what is curled so that no plane across its extent meets it well.
fn trace_from_places(surface: &Surface, context: &Context) -> Result<Option<Trace>, Cancelled> {
    const PLACES: usize = 5;
    let mut best: Option<Trace> = None;
    let count = surface.len();
    for k in 0..PLACES {
        if count == 0 {
            break;
        }
        let [a, b, c] = surface.corners((2 * k + 1) * count / (2 * PLACES));
        let Some(seed) = section_of_limb(surface, (a + b + c) / 3.0) else {
            continue;
        };
        keep_larger(&mut best, trace(surface, seed, AtForks::GoOn, context)?);
    }
    Ok(best)
}

/// Centre of the largest closed loop of a plane.
fn centre_of_largest_loop(surface: &Surface, origin: DVec3, normal: DVec3) -> Option<DVec3> {
    let mut best: Option<(f64, DVec3)> = None;
    for line in surface.slice(origin, normal) {
        if !line.closed {
            continue;
        }
        let first = line.points[0];
        let (mut area, mut sum) = (DVec3::ZERO, DVec3::ZERO);
        for (i, &p) in line.points.iter().enumerate() {
            let next = line.points[(i + 1) % line.points.len()];
            area += (p - first).cross(next - first);
            sum += p;
        }
        let area = area.length();
        if best.is_none_or(|(a, _)| area > a) {
            best = Some((area, sum / line.points.len() as f64));
        }
    }
    best.map(|(_, centre)| centre)
}

/// The section of the limb at a point on the surface. Of planes in many directions the one with the smallest closed
/// loop at the point is nearly across the limb.
pub(crate) fn section_of_limb(surface: &Surface, point: DVec3) -> Option<ShellSection> {
    /// Smallest sections that are aligned with the stem.
    const ALIGNED: usize = 6;
    let mut sections: Vec<ShellSection> = half_sphere()
        .into_iter()
        .filter_map(|d| section(surface, point, d, 0.0).or_else(|| loop_through(surface, point, d)))
        .collect();
    sections.sort_by(|a, b| a.area.total_cmp(&b.area));
    sections.iter().take(ALIGNED).find_map(|cut| {
        let aligned = aligned_section(surface, cut.centre, cut.normal)?;
        (aligned.centre.distance(point) < 2.0 * aligned.reach).then_some(aligned)
    })
}

/// Directions over half a sphere, through the lattice points on the surface of a cube.
fn half_sphere() -> Vec<DVec3> {
    let mut directions: Vec<DVec3> = Vec::new();
    for x in -2i32..=2 {
        for y in -2i32..=2 {
            for z in 0i32..=2 {
                let on_cube = x.abs().max(y.abs()).max(z.abs()) == 2;
                let half = z > 0 || y > 0 || (y == 0 && x > 0);
                if on_cube && half {
                    directions.push(DVec3::new(x.into(), y.into(), z.into()).normalize());
                }
            }
        }
    }
    directions
}

/// The loop through a surface point, which lies on it only up to rounding.
fn loop_through(surface: &Surface, point: DVec3, direction: DVec3) -> Option<ShellSection> {
    let cut = section(surface, point, direction, f64::INFINITY)?;
    let distance = cut
        .points
        .iter()
        .map(|p| p.distance(point))
        .fold(f64::INFINITY, f64::min);
    (distance < cut.reach).then_some(cut)
}
