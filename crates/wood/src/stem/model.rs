//! The stem as a value: its kind, its cross-sections, its grain and its rings.

use super::GrainSpace;
use crate::rings::RingField;
use glam::DVec2;

greenstick_schema::choices! {
    /// Whether a stem is a log or was made from one.
    pub enum StemKind {
        /// A trunk, branch, log or pole: rings about a pith inside the section.
        Round = "round",
        /// A board or beam, sawn from a trunk: straight grain along its longest axis, rings are arcs about a pith that may
        /// lie outside.
        Board = "board",
        /// A round rod made of sawn wood, without bark: its rings are arcs about a pith outside of it.
        Dowel = "dowel",
        /// A trunk or branch whose bark is gone and whose wood is weathered: rings about a pith inside the section.
        Pole = "pole",
    }
}

impl StemKind {
    /// Whether it was sawn from a trunk, so that its pith usually lies outside.
    pub const fn is_sawn(self) -> bool {
        matches!(self, StemKind::Board | StemKind::Dowel)
    }

    /// Whether there is bark around it.
    pub const fn has_bark(self) -> bool {
        matches!(self, StemKind::Round)
    }
}

/// A section across the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Length along the axis, m.
    pub length: f64,
    /// Outline: closed, counter-clockwise, m, in the axis frame's (x, y) at `length`; not scaled with the taper.
    pub contour: Vec<DVec2>,
    /// Centroid in the same frame, m.
    pub centroid: DVec2,
    /// Area, m².
    pub area: f64,
    /// Length of the outline, m.
    pub perimeter: f64,
}

/// A stem and the location on it that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Stem {
    /// Grain space about the axis; its scale is 1 at the location.
    pub grain: GrainSpace,
    /// Log or board.
    pub kind: StemKind,
    /// Plain cross-sections in rising length, the one at the location among them.
    pub sections: Vec<CrossSection>,
    /// Length along the axis at the location, m.
    pub location: f64,
    /// Range of length (m) about the location that is free for the surface of a break.
    pub usable: (f64, f64),
    /// Rings of the section at the location.
    pub rings: RingField,
    /// Radius of the circle of the same area as the section at the location, m.
    pub radius: f64,
    /// Whether `usable` ends at a real end of the stem, as opposed to a fork or another limb.
    pub ends: (bool, bool),
    /// Length of the axis, m.
    pub length: f64,
}
