//! The size of one section of a stem.

use super::super::sections::TransverseSection;
use crate::polygon;
use glam::DVec3;
use std::f64::consts::PI;

/// Points of the line around a part of a section.
const EDGE_POINTS: usize = 256;

/// The size of a section, square to the stem's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionSize {
    /// Length along the axis from the butt, m.
    pub length: f64,
    /// Its centroid in the world, m.
    pub centroid: DVec3,
    /// The pith in the world, m.
    pub pith: DVec3,
    /// Distance of the pith from the centroid, m.
    pub pith_offset: f64,
    /// Direction of the pith from the centroid, rad: about the axis, counted from the section's first axis.
    pub pith_direction: f64,
    /// Area over bark, m².
    pub area: f64,
    /// Area under bark, m².
    pub area_under_bark: f64,
    /// Length of the outline with its relief, m.
    pub girth: f64,
    /// Length of the convex hull, as a tape lies, m.
    pub tape_girth: f64,
    /// Least and greatest calliper diameter, m.
    pub calliper_diameters: [f64; 2],
    /// The part of the girth that was bridged across holes of the mesh, 0 to 1.
    pub bridged: f64,
}

impl SectionSize {
    /// Measures a section in which the wood ends at the ring coordinate `cambium`; 1 where there is no bark.
    pub fn new(section: &TransverseSection, cambium: f64) -> Self {
        let outline = &section.outline;
        let points: Vec<_> = outline.points().collect();
        let (least, greatest) = polygon::calliper_widths(&points);
        let offset = section.field.pith() - outline.centroid;
        SectionSize {
            length: section.length,
            centroid: section.world(outline.centroid),
            pith: section.world(section.field.pith()),
            pith_offset: offset.length(),
            pith_direction: libm::atan2(offset.y, offset.x),
            area: outline.area,
            area_under_bark: outline.area * share_within(section, cambium),
            girth: outline.girth,
            tape_girth: polygon::perimeter(&polygon::convex_hull(&points)),
            calliper_diameters: [least, greatest],
            bridged: outline.bridged,
        }
    }

    /// Diameter of the circle of the same area, m.
    pub fn diameter_by_area(&self) -> f64 {
        2.0 * (self.area / PI).sqrt()
    }

    /// Diameter under bark of the circle of the same area, m.
    pub fn diameter_under_bark(&self) -> f64 {
        2.0 * (self.area_under_bark / PI).sqrt()
    }

    /// Diameter of the circle of the same girth, m.
    pub fn diameter_by_girth(&self) -> f64 {
        self.girth / PI
    }

    /// Diameter that a diameter tape shows, m.
    pub fn diameter_by_tape(&self) -> f64 {
        self.tape_girth / PI
    }

    /// By how much the least calliper diameter is below the greatest, as a share of it.
    pub fn ovality(&self) -> f64 {
        let [least, greatest] = self.calliper_diameters;
        1.0 - least / greatest
    }
}

/// The part of a section's area that lies within a ring coordinate.
pub(super) fn share_within(section: &TransverseSection, ring: f64) -> f64 {
    if ring >= 1.0 {
        return 1.0;
    }
    let area = |ring: f64| {
        let curve = section.field.curve(ring, EDGE_POINTS);
        polygon::area_and_centroid(&curve).0.abs()
    };
    let whole = area(1.0);
    if whole > 0.0 {
        (area(ring) / whole).min(1.0)
    } else {
        1.0
    }
}
