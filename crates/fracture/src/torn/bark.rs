//! Bark on a torn face: strips of dead bark, and strings of living bark that come off with them.

use super::{BundleHeight, TornRelief, heavy};
use crate::ends::TornEnd;
use crate::field::HeightField;
use crate::height_model::{NoiseSamplers, unit};
use crate::layout::FibreBundle;
use glam::DVec2;
use greenstick_wood::noise;

/// Ring coordinate of the wood that bark follows.
const UNDER_BARK: f64 = 0.95;
/// How far the bark of a field's face stands over the wood or back from it before it tears along the grain, in bark
/// heights.
const BARK_OVERHANG: f64 = 1.5;
/// Angle (rad) over which bark evens out the steps of the wood under it.
const BARK_REACH: f64 = 0.25;
/// How far strings of inner bark reach from the bark of a field's face, next to the wood, over that overhang; next to the
/// bark it is less by one.
const STRING_REACH: f64 = 1.3;
/// How far inner bark stands beyond the outer bark of a strip, or stays behind it, in bark heights: its fibres are tougher, and go with
/// one half or the other.
const INNER_FRINGE: f64 = 0.16;
/// How far the innermost strings of inner bark go with the bark over the outermost, and between which of their random numbers a string
/// ends on its way from the end of the wood to that of the bark: strings are torn in places of many lengths.
const INNERMOST_GOES: f64 = 0.7;
const GOES: (f64, f64) = (0.05, 0.6);
/// By how much the end of a string is torn to one side, and its bundles before each other, in those numbers.
const STRING_SLANT: f64 = 0.18;
const STRING_RAGGED: f64 = 0.16;
/// In the hash: which of both.
const FRINGE: u64 = 0xf419;
/// Distances from the border of a layer over which it runs out in the bark, radii.
const BARK_ROOT: f64 = 0.08;

impl TornRelief<'_> {
    /// Returns the height of the wood under a strip of bark, as far as the bark follows it.
    pub(super) fn under_bark(&self, noises: &mut NoiseSamplers, strip: usize) -> f64 {
        let p = self.model.p;
        let phi = self.ends.strips.middle(strip);
        if let Some(field) = self.field {
            return self.around(field, phi) + p.bark_offset;
        }
        let at = unit(1.0, phi);
        let place = self.ends.pith + at * self.model.site.radius;
        let ragged = noises
            .shelf
            .at(self.ends.shelf_coordinates(at, place) * 3.0);
        let torn = self.torn_share(self.distance_to_shelf(ragged, at, place));
        let wandered = self.ends.ray_angle(noises, UNDER_BARK, phi);
        let slab = self.ends.slabs.at(UNDER_BARK, wandered).1;
        let wood = 0.7 * p.slab_height * self.model.site.relief * torn * slab;
        self.model.stepped_torn(at, (0.99, phi), (0.0, BARK_ROOT)) + wood + p.bark_offset
    }

    /// Returns the height of the bark of a strip at an angle (rad), before its own relief: that of the wood under the
    /// strip's middle. On a field whose wood stands far above or below that, the strip tears askew and follows the wood.
    pub(super) fn bark_level(&self, strip: usize, phi: f64) -> f64 {
        let level = self.under_bark[strip];
        match self.field {
            None => {
                let added = self.added.map_or(0.0, |f| self.bark_added(f, strip, phi));
                level + self.border_of_layer(strip, phi) + added
            }
            Some(field) => {
                let p = self.model.p;
                let below = self.around(field, phi) + p.bark_offset;
                let free = BARK_OVERHANG * p.bark_height * self.bark_relief(phi);
                level.clamp(below - free, below + free)
            }
        }
    }

    /// Returns what a field adds to the bark of a strip at an angle (rad): what it adds to the wood under the strip's middle, or, where
    /// that is far from what it adds to the wood there, nearer to that.
    pub(super) fn bark_added(&self, added: &HeightField, strip: usize, phi: f64) -> f64 {
        let here = self.around(added, phi);
        let free = BARK_OVERHANG * self.model.p.bark_height * self.bark_relief(phi);
        let level = self.around(added, self.ends.strips.middle(strip));
        level.clamp(here - free, here + free)
    }

    /// Returns by how much the layers are higher at an angle (rad) than under the middle of a strip of bark, which tears askew where
    /// one ends.
    fn border_of_layer(&self, strip: usize, phi: f64) -> f64 {
        let p = self.model.p;
        if p.high.height == 0.0 && p.low.height == 0.0 {
            return 0.0;
        }
        let at = |phi: f64| {
            self.model
                .stepped_torn(DVec2::ZERO, (0.99, phi), (0.0, BARK_ROOT))
        };
        at(phi) - at(self.ends.strips.middle(strip))
    }

    /// Returns the height of the wood under the bark about an angle (rad): bark is too tough along the ring to follow steps.
    fn around(&self, field: &HeightField, phi: f64) -> f64 {
        const SAMPLES: i32 = 6;
        let (mut sum, mut weights) = (0.0, 0.0);
        for sample in -SAMPLES..=SAMPLES {
            let off = f64::from(sample) / f64::from(SAMPLES + 1);
            let weight = 1.0 - off.abs();
            sum += weight * field.at(UNDER_BARK, phi + off * BARK_REACH);
            weights += weight;
        }
        sum / weights / self.model.site.radius
    }

    /// Returns the factor on the relief of bark at an angle (rad).
    fn bark_relief(&self, phi: f64) -> f64 {
        let field = self.field.or(self.added);
        let local = field.and_then(|f| f.failure_at(1.0, phi));
        local.map_or(1.0, |l| {
            (0.3 + 0.7 * l.torn) * l.splintering.clamp(0.4, 1.5)
        })
    }

    pub(super) fn bark_height(
        &self,
        bundle: &FibreBundle,
        end: &TornEnd,
        middle: DVec2,
        noise: f64,
    ) -> BundleHeight {
        let p = self.model.p;
        // On a field every node of the bark has the height of its own angle.
        let strip = end.strip as usize;
        let (level, tilt) = match self.field {
            None => (
                self.under_bark[strip] + self.border_of_layer(strip, bundle.phi),
                self.model.tilt,
            ),
            Some(_) => (0.0, DVec2::ZERO),
        };
        BundleHeight {
            base: level + 0.3 * noise,
            thorn: 0.0,
            raggedness: 0.0,
            middle,
            slant: tilt,
            sliver: p.bark_height * self.bark_relief(bundle.phi),
            fork: 0.0,
            slab: 0.0,
            blade: 0.0,
            rough: 0.0,
            plates: 0.0,
            folds: 0.0,
            noisy: 0.0,
            bark: true,
        }
    }

    /// Returns the height of inner bark, which tears in strings; some of them come off with the bark.
    pub(super) fn with_bark(&self, base: f64, end: &TornEnd, (rho, phi): (f64, f64)) -> f64 {
        if rho <= self.inner_bark {
            return base;
        }
        let string = &end.string;
        let depth = ((rho - self.inner_bark) / self.model.p.phloem_proportion.max(1e-6)).min(1.0);
        // Layers farther out go farther with the bark.
        let goes = string.goes * (INNERMOST_GOES + (1.0 - INNERMOST_GOES) * depth);
        let torn = STRING_SLANT * string.slant + STRING_RAGGED * string.ragged;
        let (from, to) = GOES;
        let with = noise::smoothstep(from, to, goes + torn * depth);
        let level = self.bark_level(end.strip as usize, phi);
        let height = self.model.p.bark_height * self.bark_relief(phi);
        let base = match self.field {
            None => base,
            Some(_) => {
                // Strings of inner bark do not reach far through the bark beside them.
                let free = BARK_OVERHANG * height * (STRING_REACH - depth);
                base.clamp(level - free, level + free)
            }
        };
        // It tears at other heights than the bark outside of it.
        let stands = match noise::unit(self.model.p.seed ^ FRINGE, i64::from(end.strip), 0, 0) < 0.5
        {
            true => INNER_FRINGE,
            false => -INNER_FRINGE,
        };
        let bark = level + height * (end.strip_end + 0.9 * heavy(string.long) - 0.1 + stands);
        base + (bark - base) * with
    }
}
