//! How a break keeps clear of the one beyond it.

use super::values::BreakStages;
use crate::prepared::PreparedStem;
use glam::DVec3;

/// The least length of whole stem between two breaks, radii.
const MIN_GAP_BETWEEN_BREAKS: f64 = 0.1;

/// The lowest point of a broken face, which a break nearer to the base stays clear of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowestAbove {
    /// The point of the axis at that length, m.
    point: DVec3,
    /// The length of stem between the two breaks, m.
    margin: f64,
}

impl LowestAbove {
    /// Returns the lowest point of a break.
    pub fn new(stages: &BreakStages) -> Self {
        let stem = &stages.stem.stem().found.stem;
        let low = stages.heights.heights.range.0;
        LowestAbove {
            point: stem.grain.axis().frame(stem.location + low).origin,
            margin: MIN_GAP_BETWEEN_BREAKS * stem.radius,
        }
    }

    /// Limits the usable length of a stem so that a break stays clear of the point.
    pub fn limit(self, stem: &mut PreparedStem) {
        let stem = &mut stem.found.stem;
        let length = stem.grain.axis().length_at(self.point) - self.margin;
        stem.usable.1 = stem.usable.1.min(length).max(stem.location);
    }
}
