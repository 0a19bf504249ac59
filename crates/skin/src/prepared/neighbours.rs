//! How one of several breaks of a stem keeps clear of the others, and runs the way they do.

use glam::DVec3;
use greenstick_wood::stem::FoundStem;

/// What a break must know of the others of its stem.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Neighbours {
    /// The lowest point of the break beyond this one, and the length of stem to keep from it, m.
    above: Option<(DVec3, f64)>,
    /// The point halfway to the next break towards the base, m.
    below: Option<DVec3>,
    /// The direction of the whole stem at the break. What is left of it may be thicker at its other end.
    along: Option<DVec3>,
}

impl Neighbours {
    /// Returns those of a break where the whole stem runs along `along`; the next break towards the base, if there is one, leaves
    /// it the stem down to the point `below` (m).
    pub(crate) fn new(along: DVec3, below: Option<DVec3>) -> Self {
        Neighbours {
            above: None,
            below,
            along: Some(along),
        }
    }

    /// Returns the same with the lowest point of the break beyond (m), which was made before, and the length of stem to keep
    /// from it, m.
    #[must_use]
    pub fn beyond(self, above: Option<(DVec3, f64)>) -> Self {
        Neighbours { above, ..self }
    }

    /// The direction of the whole stem at the break, if it is one of several.
    pub fn along(&self) -> Option<DVec3> {
        self.along
    }

    /// Limits the usable length of a stem so that a break leaves the others room.
    pub fn limit(&self, found: &mut FoundStem) {
        let stem = &mut found.stem;
        let length_at = |p: DVec3| stem.grain.axis().length_at(p);
        let above = self.above.map(|(point, margin)| length_at(point) - margin);
        let below = self.below.map(length_at);
        let (low, high) = stem.usable;
        stem.usable = (
            low.max(below.unwrap_or(low)).min(stem.location),
            high.min(above.unwrap_or(high)).max(stem.location),
        );
    }
}
