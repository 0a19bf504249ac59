//! Where rods pierce a cross-section: Poisson disk samples (Bridson 2007; Sutherland 2012 §3.3.1, corrected) or bundles by
//! ring and sector.
//!
//! The thesis first samples the outline by angles whose least difference it gives as a distance; here the outline is sampled
//! by length, and every point tested against the distance. The thesis also drops a point from the active ones after its first
//! success; Bridson's rule retains it until all of its tries fail.

use super::voronoi::{Grid, is_inside};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::noise::unit;
use greenstick_wood::rings::RingField;
use std::f64::consts::TAU;

/// Tries around an active point (Bridson's k).
const TRIES: i64 = 30;

/// Returns points inside `outline`, no two closer than `distance`, to which no other can be added (except where the tries
/// miss one).
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(crate) fn poisson_disk(
    outline: &[DVec2],
    distance: f64,
    seed: u64,
    context: &Context,
) -> Result<Vec<DVec2>, Cancelled> {
    let mut grid = Grid::new(outline, distance);
    let mut points: Vec<DVec2> = Vec::new();
    sample_outline(outline, distance, seed, |p| {
        if !grid.any_within(&points, p, distance) {
            grid.insert(points.len(), p);
            points.push(p);
        }
    });
    let mut active: Vec<usize> = (0..points.len()).collect();
    let mut draw = 0;
    let mut random = |what: u64| {
        draw += 1;
        unit(seed ^ what, draw, 0, 0)
    };
    while !active.is_empty() {
        context.check()?;
        let k = (random(0xac71) * active.len() as f64) as usize;
        let k = k.min(active.len() - 1);
        let centre = points[active[k]];
        let found = (0..TRIES).find_map(|_| {
            // Uniform over the area of the annulus.
            let r = distance * (1.0 + 3.0 * random(0x7ad1)).sqrt();
            let (sin, cos) = libm::sincos(TAU * random(0xa291));
            let p = centre + DVec2::new(cos, sin) * r;
            (is_inside(outline, p) && !grid.any_within(&points, p, distance)).then_some(p)
        });
        match found {
            Some(p) => {
                grid.insert(points.len(), p);
                active.push(points.len());
                points.push(p);
            }
            None => {
                active.swap_remove(k);
            }
        }
    }
    Ok(points)
}

/// Calls `put` for points along the outline, each between one and two distances along it from the last.
fn sample_outline(outline: &[DVec2], distance: f64, seed: u64, mut put: impl FnMut(DVec2)) {
    let mut next = distance * unit(seed ^ 0x0a11, 0, 0, 0);
    let (mut passed, mut draw) = (0.0, 0);
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let length = a.distance(b);
        while next < passed + length {
            put(a.lerp(b, (next - passed) / length));
            draw += 1;
            next += distance * (1.0 + unit(seed ^ 0x0a12, draw, 0, 0));
        }
        passed += length;
    }
}

/// Returns points in rings `spacing` wide. Each ring has as many sectors as make cells about as wide as they are thick, and is
/// turned at random against the others.
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(super) fn by_ring_and_sector(
    outline: &[DVec2],
    rings: &RingField,
    spacing: f64,
    seed: u64,
    context: &Context,
) -> Result<Vec<DVec2>, Cancelled> {
    let (mut low, mut high, mut radius) = (f64::INFINITY, 0.0f64, 0.0f64);
    for &p in outline {
        let (ring, _) = rings.address(p);
        low = low.min(ring);
        high = high.max(ring);
        radius = radius.max(p.distance(rings.pith()) / ring.max(1e-9));
    }
    if is_inside(outline, rings.pith()) {
        low = 0.0;
        high = 1.0;
        let around = (0..64).map(|k| rings.outer_radius(TAU * f64::from(k) / 64.0));
        radius = around.sum::<f64>() / 64.0;
    }
    let count = ((high - low) * radius / spacing).round().clamp(1.0, 1e5) as i64;
    let mut points = Vec::new();
    for i in 0..count {
        context.check()?;
        let ring = low + (high - low) * (i as f64 + 0.5) / count as f64;
        let sectors = (TAU * ring * radius / spacing).round().clamp(3.0, 1e7) as i64;
        let start = unit(seed ^ 0x5ec7, i, 0, 0);
        for j in 0..sectors {
            let angle = TAU * (j as f64 + start) / sectors as f64;
            let p = rings.point(ring, angle);
            if is_inside(outline, p) {
                points.push(p);
            }
        }
    }
    Ok(points)
}
