//! Tints of wood and of inner bark: no two strips of a stem have one colour. Slow changes between cream and pink, streaks that resin or sap has
//! soaked, and sapwood that is moist beside the bark (Hoadley, *Understanding Wood*, on the colour of wood and on stains).

use super::mix::{mix, visible_detail};
use super::noises::TINT_NOISES;
use super::wood::WoodAppearance;
use crate::noise::{Noises, smoothstep};
use crate::rings::periodic_cells;
use glam::DVec3;

/// Width of a tinted strip, m, and its length in widths.
const STRIP: (f64, f64) = (6.5e-3, 26.0);
/// Factors on the colour from the coolest to the warmest strip: their means keep the brightness.
const COOL: DVec3 = DVec3::new(0.965, 1.01, 1.10);
const WARM: DVec3 = DVec3::new(1.03, 0.99, 0.90);
/// The same for single slivers, as a part of that: little, as colours belong to places in the stem.
const SLIVERS: f64 = 0.15;
/// Width of a soaked streak, m, its length in widths, and the values of the noise between which it begins.
const SOAKED: (f64, f64) = (2.6e-3, 42.0);
const SOAKED_EDGE: (f64, f64) = (0.30, 0.58);
/// Part of the wood that is soaked, which is what is left of streaks too fine to be seen.
const SOAKED_SHARE: f64 = 0.045;
/// Factor on the colour of wood that is soaked.
const SOAKED_COLOR: DVec3 = DVec3::new(0.93, 0.86, 0.74);
/// Factor on the colour of moist sapwood beside the bark, and how far from there it begins, in ring coordinates.
const MOIST_COLOR: DVec3 = DVec3::new(0.97, 0.99, 0.86);
const MOIST: f64 = 0.16;

/// Part of the inner bark over which it passes from tan, where it lives, to red-brown, and how much farther out or in that is in strings
/// of different tones: it tears in layers.
const LIVING_BARK: f64 = 1.1;
const TORN_LAYERS: f64 = 0.45;
/// How much of the colour of sapwood living bark has, and the tint of that; the tint of dead bark; and how far the tones of its strings
/// differ.
const LIVING_SHARE: f64 = 0.45;
const LIVING_TINT: DVec3 = DVec3::new(0.92, 0.90, 0.80);
const DEAD_TINT: DVec3 = DVec3::new(0.70, 0.61, 0.51);
const BAST_TONES: f64 = 0.38;

/// Part of the outer bark that is drawn as inner bark, too: what its furrows part begins farther out.
const INNER_BARK_SHARE: f64 = 0.3;

/// In the hash: what tints are drawn for.
const TINT: u64 = 0x71;

impl WoodAppearance {
    /// Returns the factor on the colour of the wood at a place with a ring coordinate, whose sliver has a tone of −1 to 1; what is
    /// finer than `footprint` (m) is averaged.
    pub(super) fn tint(
        &self,
        place: DVec3,
        (rho, tone): (f64, f64),
        footprint: f64,
        noises: &mut impl Noises,
    ) -> DVec3 {
        // How much of the detail is visible, and the noise.
        let mut strips = |n: usize, (width, stretch): (f64, f64)| {
            let visible = visible_detail(width, footprint);
            if visible == 0.0 {
                return (0.0, 0.0);
            }
            let (long, period) = periodic_cells(width * stretch, self.period);
            let scale = DVec3::new(1.0 / width, 1.0 / width, 1.0 / long);
            let seed = self.seed ^ TINT ^ ((n as u64) << 8);
            let number = TINT_NOISES + n;
            (
                visible,
                noises.gradient(number, seed, place * scale, period).0,
            )
        };
        let (visible, strip) = strips(0, STRIP);
        let warmth = (1.3 * visible * strip + SLIVERS * tone).clamp(-1.0, 1.0);
        let mut tint = mix(COOL, WARM, 0.5 + 0.5 * warmth);
        let (visible, sap) = strips(1, SOAKED);
        let streak = smoothstep(SOAKED_EDGE.0, SOAKED_EDGE.1, sap + 0.12 * tone);
        let soaked = SOAKED_SHARE + visible * (streak - SOAKED_SHARE);
        tint *= mix(DVec3::ONE, SOAKED_COLOR, soaked);
        let moist = smoothstep(self.phloem - MOIST, self.phloem, rho);
        tint * mix(DVec3::ONE, MOIST_COLOR, moist)
    }

    /// Returns the ring coordinate at which the inner bark ends where it is drawn; the tissue of the model ends at `cork`.
    pub fn drawn_inner_bark_end(&self) -> f64 {
        self.cork + INNER_BARK_SHARE * (1.0 - self.cork).max(0.0)
    }

    /// The colour of the inner bark at a ring coordinate in strings of a tone of −1 to 1: pale and moist next to the wood, where it
    /// lives, and darker outwards.
    pub(super) fn inner_bark_color(&self, rho: f64, tone: f64) -> [f64; 3] {
        let depth = (rho - self.phloem) / (self.drawn_inner_bark_end() - self.phloem).max(1e-6);
        let living = 1.0 - smoothstep(0.0, LIVING_BARK, depth + TORN_LAYERS * tone);
        let own = DVec3::from_array(self.phloem_color);
        let dark = own * DEAD_TINT * (1.0 + BAST_TONES * tone);
        let sapwood = DVec3::from_array(self.sapwood_color);
        let pale = mix(own, sapwood * LIVING_TINT, LIVING_SHARE);
        mix(dark, pale, living).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Forgetful, unit};

    #[test]
    fn tints_differ_from_strip_to_strip_and_keep_the_brightness() {
        let wood = WoodAppearance::softwood();
        let count = 4000;
        let (mut sum, mut warmest, mut coolest) = (DVec3::ZERO, 0.0f64, f64::INFINITY);
        for i in 0..count {
            let random = |k: i64| unit(3, i, k, 0);
            let place = DVec3::new(random(0), random(1), random(2)) * 0.5;
            let tint = wood.tint(place, (0.6, 2.0 * random(3) - 1.0), 1e-4, &mut Forgetful);
            sum += tint;
            let warmth = tint.x / tint.z;
            (warmest, coolest) = (warmest.max(warmth), coolest.min(warmth));
        }
        let mean = sum / count as f64;
        assert!((mean - DVec3::ONE).abs().max_element() < 0.08, "{mean}");
        assert!(warmest > 1.25 * coolest, "{coolest} {warmest}");
        // From afar the brightness is the same.
        let far = |i: i64| {
            let tone = 2.0 * unit(3, i, 3, 0) - 1.0;
            wood.tint(DVec3::ZERO, (0.6, tone), 1.0, &mut Forgetful)
        };
        let far = (0..count).map(far).sum::<DVec3>() / count as f64;
        assert!(
            (far / mean - DVec3::ONE).abs().max_element() < 0.01,
            "{far} {mean}"
        );
        // Along the grain they last.
        let at = |x: f64, z: f64| {
            let tint = wood.tint(DVec3::new(x, 0.0, z), (0.6, 0.0), 1e-4, &mut Forgetful);
            tint.x / tint.z
        };
        let steps = |dx: f64, dz: f64| -> f64 {
            let step = |i: i32| {
                let x = 0.011 * f64::from(i);
                (at(x + dx, 0.3) - at(x, 0.3 + dz)).abs()
            };
            (0..300).map(step).sum()
        };
        assert!(steps(3e-3, 0.0) > 5.0 * steps(0.0, 3e-3));
    }

    #[test]
    fn inner_bark_is_palest_next_to_the_wood() {
        let wood = WoodAppearance::softwood();
        let at = |part: f64| {
            let rho = wood.phloem + part * (wood.drawn_inner_bark_end() - wood.phloem);
            DVec3::from_array(wood.inner_bark_color(rho, 0.0)).element_sum()
        };
        assert!(at(0.05) > 1.2 * at(0.95));
    }
}
