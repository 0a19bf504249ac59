//! Wood that broke across: the folds of crushed wood, and the terraces in which crushed and brittle wood ends.

use super::{TornRelief, heavy};
use crate::ends::TornEnd;
use crate::height_model::purpose;
use glam::DVec2;
use greenstick_wood::noise;

/// Width of the folds of crushed wood, radii, at most: with the usual heights their sides lie at 45° to 60° to the grain.
const FOLD_WIDTH: f64 = 0.17;
/// Height of the terraces of crushed wood over the compression height.
const CRUSHED_TERRACES: f64 = 3.0;
/// What its terraces are made of: clumps as large as slivers, and steps from ring to ring, along which it is sheared off.
const CRUSHED_STEPS: (f64, f64) = (0.35, 0.25);
/// The same of clumps as large as parts of slivers, in crushed and in brittle wood.
const CLUMPS: f64 = 0.15;
/// By how much the ends of parts of slivers and of bundles differ where they are crushed, in compression heights.
const CRUSHED_PARTS: f64 = 0.1;
const CRUSHED_BUNDLES: f64 = 0.06;
/// Heights of the ends of crushed bundles, in compression heights: of most, and of those that stand out.
const CRUSHED_BLADE: (f64, f64) = (0.04, 0.15);
/// Part of a fold's width over which it rises: fibres lean over to one side and break off on the other.
const FOLD_RISE: f64 = 0.72;

/// Where the lip of brittle wood begins and where it is whole, radii from the pith away from the tension side, by how much that differs
/// from sliver to sliver, and how high it is at least and by how much more at most, radii.
const LIP: (f64, f64) = (0.72, 0.95);
const LIP_SLIVERS: f64 = 0.1;
const LIP_HEIGHT: (f64, f64) = (0.05, 0.3);

impl TornRelief<'_> {
    /// Returns the height of the lip that brittle wood has at a bundle, `at` in ring coordinates: what broke last is torn off in fibres.
    pub(super) fn lip(&self, end: &TornEnd, at: DVec2) -> f64 {
        if self.brittle == 0.0 || self.field.is_some() || self.ends.is_board() {
            return 0.0;
        }
        let [short, long, _] = end.sliver_random;
        let place = at.dot(-self.model.tension) + LIP_SLIVERS * (long - 0.5);
        let (least, more) = LIP_HEIGHT;
        let height = least + more * short * end.fork_random[1];
        self.brittle * height * noise::smoothstep(LIP.0, LIP.1, place)
    }

    /// Returns the height of a bundle of crushed wood, and that of its end.
    pub(super) fn crushed(&self, end: &TornEnd, torn: f64) -> (f64, f64) {
        let (height, [drop, _]) = (self.model.p.compression_height, end.fork_random);
        let crushed = height
            * (CRUSHED_TERRACES * self.terrace(end, CRUSHED_STEPS)
                + CRUSHED_PARTS * heavy(drop)
                + CRUSHED_BUNDLES * heavy(end.crushed_random[0]));
        // Either half keeps the fibres of a bundle.
        let [sharp, side, _] = end.crushed_random;
        let blade = ((1.0 - torn) * height)
            * (CRUSHED_BLADE.0 + CRUSHED_BLADE.1 * sharp * sharp).copysign(side - 0.5);
        (crushed, blade)
    }

    /// Returns the height of the terrace that a bundle broke across in, about −1 to 1: wood that is too brittle to split far, or too
    /// crushed, still parts along rings and rays, into clumps of a few sizes.
    pub(super) fn terrace(&self, end: &TornEnd, (clumps, ring_steps): (f64, f64)) -> f64 {
        let even = |random: f64| 2.0 * random - 1.0;
        let [sliver, ..] = end.sliver_random;
        let [part, _] = end.fork_random;
        clumps * even(sliver) + CLUMPS * even(part) + ring_steps * end.step
    }

    /// Returns the height of a fold of crushed wood at a point (m), 0 to 1, where folds are `height` high. Their ridges run across
    /// the way that the stem was bent, and wind.
    pub(super) fn fold(&self, at: DVec2, height: f64, rough: f64) -> f64 {
        if height <= 0.0 {
            return 0.0;
        }
        let across = (at - self.ends.pith) / self.model.site.radius;
        let seed = self.model.seed(purpose::ROUGH);
        let winding = 0.8 * noise::gradient_2d(seed + 7, across * 1.6)
            + 0.4 * noise::gradient_2d(seed + 8, across * 4.3)
            + 0.06 * rough;
        let place = across.dot(self.model.tension) / FOLD_WIDTH + 2.0 * winding;
        let (fold, part) = (place.floor(), place - place.floor());
        // No fold runs on for long.
        let along = across.dot(self.model.tension.perp());
        let high = noise::value_1d(seed + 9 + (fold as i64 & 0xff) as u64, 3.4 * along);
        let rise = if part < FOLD_RISE {
            part / FOLD_RISE
        } else {
            (1.0 - part) / (1.0 - FOLD_RISE)
        };
        rise * (0.55 + 0.45 * high)
    }
}
