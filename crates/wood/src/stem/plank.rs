//! Sawn wood: the box of a board or beam, and whether a shell is one.

use super::principal::PrincipalAxes;
use super::section::{across, section};
use super::surface::Surface;
use crate::polygon::{self, Outermost};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context};

/// Triangles after which the caller may stop.
const CHECK_INTERVAL: usize = 1 << 16;

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

impl Plank {
    /// The smallest box about a shell whose shortest side is that of its spread.
    pub fn around(surface: &Surface, context: &Context) -> Result<Option<Self>, Cancelled> {
        let axes = PrincipalAxes::new(surface);
        let (mean, [_, _, thin]) = (axes.centroid, axes.directions);
        let (x, y) = across(thin);
        let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut outermost = Outermost::of(DVec2::ZERO);
        for i in 0..surface.len() {
            if i % CHECK_INTERVAL == 0 {
                context.check()?;
            }
            for p in surface.corners(i).map(|p| p - mean) {
                outermost.add(flat(p));
                (low, high) = (low.min(p.dot(thin)), high.max(p.dot(thin)));
            }
        }
        let is_inside = outermost.interior();
        let mut outer = Vec::new();
        for i in 0..surface.len() {
            if i % CHECK_INTERVAL == 0 {
                context.check()?;
            }
            let corners = surface.corners(i).map(|p| flat(p - mean));
            outer.extend(corners.into_iter().filter(|&p| !is_inside(p)));
        }
        context.check()?;
        Ok(polygon::smallest_rectangle(&outer).map(|r| {
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
            Plank {
                end,
                direction,
                wide,
                size: [r.width, width, thickness],
            }
        }))
    }
}

/// Parts of a rectangle and of a box that a board fills at least: an octagon fills 0.83 of its rectangle, one whose
/// corners are rounded by a sixth of its width 0.98; a limb of four sides that tapers to half fills 0.58 of its box.
const MIN_RECTANGLE_FILL: f64 = 0.93;
const MIN_BOX_FILL: f64 = 0.7;

/// Whether sections along the box are rectangles that mostly fill it.
pub(crate) fn is_board(surface: &Surface, plank: &Plank) -> bool {
    const PLANES: usize = 21;
    let [length, width, thickness] = plank.size;
    let (mut filled, mut rectangles) = (0.0, 0);
    for k in 0..PLANES {
        let s = length * (k as f64 + 0.5) / PLANES as f64;
        let origin = plank.end + plank.direction * s;
        let Some(cut) = section(surface, origin, plank.direction, width) else {
            continue;
        };
        let (x, y) = across(cut.normal);
        let flat: Vec<DVec2> = cut
            .points
            .iter()
            .map(|p| DVec2::new(p.dot(x), p.dot(y)))
            .collect();
        let Some(r) = polygon::smallest_rectangle(&flat) else {
            continue;
        };
        filled += cut.area / (width * thickness);
        rectangles += usize::from(cut.area > MIN_RECTANGLE_FILL * r.width * r.thickness);
    }
    // Grooves, notches and handles may cut into more than half of the length.
    filled > MIN_BOX_FILL * PLANES as f64 && rectangles * 5 > PLANES * 2
}
