//! The tips of slivers: how far they taper, and how frayed they are.

use super::TornRelief;
use crate::ends::TornEnd;
use crate::height_model::purpose;

/// Length of a long sliver from its root and of the taper of it, over the length that is drawn for it.
const SLIVER_LENGTH: f64 = 2.5;
const TAPER: f64 = 1.35;
/// Greatest length of a blade over its width.
const MAX_SLENDERNESS: f64 = 9.0;
/// Share of the slivers that broke off nearly square, their taper over the usual one, and the least and the greatest taper of the others.
const SQUARE_SHARE: f64 = 0.15;
const SQUARE_TAPER: f64 = 0.2;
const TAPERS: (f64, f64) = (0.5, 2.4);
/// How frayed the parts of slivers are: few are frayed far.
const FRAYED: (f64, f64) = (0.2, 2.5);

impl TornRelief<'_> {
    /// Returns the heights of the shaft of a sliver and of its outline, the taper on it, which is most of it. `length` is that drawn
    /// for it, and `high` a height that its outline has in any case.
    pub(super) fn taper(&self, end: &TornEnd, length: f64, high: f64) -> (f64, f64) {
        let outline =
            (TAPER * length + 0.7 * high).min(self.longest_taper(end)) * self.tapering(end);
        ((SLIVER_LENGTH * length - outline).max(0.0), outline)
    }

    /// Returns the greatest height of the taper of a sliver.
    pub(super) fn longest_taper(&self, end: &TornEnd) -> f64 {
        let (width, _) = self.ends.slivers.region(end.sliver as usize).size();
        MAX_SLENDERNESS * width * self.ends.ring_unit * self.tapering(end).max(1.0)
    }

    /// Returns the greatest height of the blade of a bundle of a width, both radii.
    pub(super) fn longest_blade(&self, width: f64) -> f64 {
        3.0 * MAX_SLENDERNESS * width
    }

    /// Returns how far a sliver tapers against others: some are broken off nearly square, by steps from part to part.
    fn tapering(&self, end: &TornEnd) -> f64 {
        if self.ends.is_board() {
            return 1.0;
        }
        let square = self.random(purpose::SLIVER, i64::from(end.sliver), 11);
        let far = self.random(purpose::SLIVER, i64::from(end.sliver), 12);
        if square < SQUARE_SHARE {
            SQUARE_TAPER
        } else {
            let (least, most) = TAPERS;
            least + (most - least) * far * far
        }
    }

    /// Returns how frayed the part of a sliver's tip is that a bundle is in: most are whole, some frayed into single fibres.
    pub(super) fn frayed(&self, end: &TornEnd) -> f64 {
        if self.ends.is_board() {
            return 1.0;
        }
        let random = self.random(purpose::FORK, i64::from(end.fork), 13);
        let (least, most) = FRAYED;
        least + (most - least) * random * random * random
    }
}
