//! Whether a round stem is so plain that it was turned, not grown: a dowel or a pole.

use super::model::{Stem, StemKind};
use glam::DVec2;

/// Greatest distance of a point of an outline from the circle about its middle, in radii. The sides of a polygon of 24 corners lie
/// 0.009 within its circle; branches that were modelled or scanned are out of round by several hundredths.
const MAX_OUT_OF_ROUND: f64 = 0.015;
/// Greatest difference of the radius of a section from the mean, in radii, and of its middle from the chord of the axis.
const MAX_TAPER: f64 = 0.008;
const MAX_BEND: f64 = 0.02;
/// Least length, in radii: what is shorter is a disc.
const MIN_LENGTH: f64 = 8.0;
/// How far from its ends a rod may end to be free for a break, in radii: farther, and something is attached there.
const MAX_END: f64 = 1.0;
/// Fewest sections and fewest corners of one that say anything.
const MIN_SECTIONS: usize = 4;
const MIN_CORNERS: usize = 16;
/// Radius up to which such a rod is turned from a board, m. Thicker ones are trunks without bark.
const MAX_DOWEL_RADIUS: f64 = 0.03;

impl Stem {
    /// Returns what a round stem is where its surface is plain, a dowel or a pole; `None` where it looks grown: out of round, bent,
    /// tapered, or part of a tree. That its surface has no texture is for the caller to see.
    ///
    /// ```
    /// use greenstick_geometry::Context;
    /// use greenstick_wood::primitive;
    /// use greenstick_wood::stem::{StemKind, StemOptions, find_stem};
    ///
    /// let rod = primitive::cylinder(0.01, 0.4, 48);
    /// let found = find_stem(&[rod], &"0.5".parse()?, &StemOptions::default(), &Context::quiet())?;
    /// assert_eq!(found.stem.plain_kind(), Some(StemKind::Dowel));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn plain_kind(&self) -> Option<StemKind> {
        let sections = &self.sections;
        let mean = sections.iter().map(|s| radius(s.area)).sum::<f64>() / sections.len() as f64;
        let free = self.kind == StemKind::Round
            && self.usable.0 < MAX_END * mean
            && self.usable.1 > self.length - MAX_END * mean
            && sections.len() >= MIN_SECTIONS
            && self.length >= MIN_LENGTH * mean;
        if !free {
            return None;
        }
        let axis = self.grain.axis();
        let [first, last] = [0.0, self.length].map(|s| axis.frame(s).origin);
        let chord = (last - first).normalize_or_zero();
        let is_plain = sections.iter().all(|section| {
            let off = |p: DVec2| (p.distance(section.centroid) - radius(section.area)).abs();
            let frame = axis.frame(section.length);
            let middle = frame.origin + frame.x * section.centroid.x + frame.y * section.centroid.y;
            section.contour.len() >= MIN_CORNERS
                && (radius(section.area) - mean).abs() <= MAX_TAPER * mean
                && (middle - first).reject_from(chord).length() <= MAX_BEND * mean
                && (section.contour.iter()).all(|&p| off(p) <= MAX_OUT_OF_ROUND * mean)
        });
        let kind = match mean <= MAX_DOWEL_RADIUS {
            true => StemKind::Dowel,
            false => StemKind::Pole,
        };
        (is_plain && chord != glam::DVec3::ZERO).then_some(kind)
    }
}

/// Radius of the circle of an area.
fn radius(area: f64) -> f64 {
    (area.abs() / std::f64::consts::PI).sqrt()
}
