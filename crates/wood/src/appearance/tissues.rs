//! The tissues beside the wood: pith, cambium, inner and outer bark, blended over the wood near and beyond their edges.

use super::mix::visible_detail;
use super::noises::{BAST_NOISE, SPECK_NOISE, UNEVEN_NOISES};
use super::tissue_blend::TissueBlend;
use super::wood::WoodAppearance;
use crate::noise::{Noises, smoothstep};
use crate::rings::{StemAddress, periodic_cells};
use glam::DVec3;

/// Width of the cambium, a pale line between wood and bark, m, and how much it shows.
const CAMBIUM_WIDTH: f64 = 0.4e-3;
const CAMBIUM_SHARE: f64 = 0.7;
/// Cosines of the angle to the direction away from the pith between which a face begins to be one that bark came off.
const PEELED: (f64, f64) = (0.15, 0.5);
/// Distances from the wood, in ring coordinates, between which such faces end: farther out, one is torn inner bark.
const OUTSIDE: (f64, f64) = (0.006, 0.016);
/// Width of the patches in which inner bark stays on wood that bark came off, in strings, and their length in those widths.
const BAST_PATCH: (f64, f64) = (2.4, 16.0);
/// How far single strings and slivers reach out of such a patch or end in it, over its own noise.
const BAST_STRINGS: (f64, f64) = (0.5, 0.3);
/// The sum of those at which inner bark stays at the cambium and where the outer bark begins, and how soft its edge is.
const BAST_STAYS: (f64, f64) = (0.42, -0.06);
const BAST_EDGE: f64 = 0.1;
/// How much of the wood it hides: its strings are thin.
const BAST_SHARE: f64 = 0.85;
/// How deep within the inner bark its layers look that outer bark came off, against the place: what is bare is the pale living side.
const BARE_DEPTH: f64 = 0.8;
/// How softly inner bark passes into sapwood, in ring coordinates to both sides, and how far strings of different tones reach into it;
/// and how far the edge of the outer bark wanders over that of the inner bark, to the other side.
const SAPWOOD_PASSAGE: f64 = 0.012;
const SAPWOOD_STRINGS: f64 = 0.006;
const CORK_WANDER: f64 = 1.0;
/// Width of the strings that barks are made of, m, and at least over the radius: those of a thick stem are coarse.
const BARK_STRING: f64 = 1.1e-3;
const COARSE_BARK: f64 = 0.02;
/// In the hash: what the specks of pith and bark are drawn for.
const SPECK: u64 = 0x4b;
/// In the hash: where inner bark stays on the wood.
const BAST: u64 = 0xba57;

impl WoodAppearance {
    /// Blends pith and barks over the wood near and beyond their edges.
    pub(super) fn blend_tissues(
        &self,
        surface: &mut TissueBlend,
        address: &StemAddress,
        place: DVec3,
        footprint: f64,
        noises: &mut impl Noises,
    ) {
        let rho = address.rho;
        let soft = (footprint / self.radius).max(0.004);
        let cork = self.drawn_inner_bark_end();
        let margin = 0.03 + (cork - self.phloem).clamp(0.0, 0.1);
        let near_bark = rho > self.phloem - soft - margin;
        let near_pith = rho <= self.pith * 1.15 + soft + 0.01;
        if !near_bark && !near_pith {
            return;
        }
        let string = BARK_STRING.max(COARSE_BARK * self.radius);
        let (long, period) = periodic_cells(7.3 * string, self.period);
        let scale = DVec3::new(1.0 / string, 1.0 / string, 1.0 / long);
        let ragged = noises
            .gradient(SPECK_NOISE, self.seed ^ SPECK, place * scale, period)
            .0;
        let speck = ragged * visible_detail(string, footprint);
        // The pith lies below its edge, the barks above theirs; the cambium is no compass line, and the cork eats into the
        // inner bark in places.
        let in_pith = 1.0
            - smoothstep(
                self.pith * 0.7 - soft,
                self.pith * 1.15 + soft,
                rho + 0.008 * ragged,
            );
        surface.blend(self.pith_color, 0.22 * speck, in_pith);
        let uneven = self.uneven_bark(place, noises);
        let from_cambium = (rho + (0.008 * ragged + uneven) - self.phloem).abs() * self.radius;
        let wide = CAMBIUM_WIDTH.max(footprint);
        let pale = (1.0 - smoothstep(0.3 * wide, wide, from_cambium)) * CAMBIUM_WIDTH / wide;
        let cambium = self.sapwood_color.map(|c| (1.12 * c).min(1.0));
        // Bark comes off at the cambium: a face that looks outwards there is wood, on which strings of inner bark are left. Farther
        // out it is a layer of the bark, which shows how thick that is.
        let peeled = smoothstep(PEELED.0, PEELED.1, surface.outwards)
            * (1.0 - surface.end)
            * (1.0 - smoothstep(self.phloem + OUTSIDE.0, self.phloem + OUTSIDE.1, rho));
        let strings = match peeled > 0.0 {
            true => self.bast(rho, (place, string), ragged, surface.tone, noises),
            false => 0.0,
        };
        let bare_wood = |edge: f64| match edge == self.phloem {
            true => peeled * (1.0 - strings),
            false => peeled,
        };
        for (edge, color, grain) in [
            (self.phloem, self.phloem_color, 0.20),
            (cork, self.cork_color, 0.42),
        ] {
            // The two edges wander apart, so that inner bark is here wide and there narrow.
            let (wavy, soft) = match edge == self.phloem {
                true => {
                    let strings = SAPWOOD_STRINGS * surface.tone;
                    (
                        rho + 0.008 * ragged + uneven + strings,
                        soft + SAPWOOD_PASSAGE,
                    )
                }
                false => (rho + 0.008 * ragged - CORK_WANDER * uneven, soft),
            };
            let inside = smoothstep(edge - soft, edge + soft, wavy) * (1.0 - bare_wood(edge));
            let color = match edge == self.phloem {
                true => {
                    let depth = 1.0 - (1.0 - BARE_DEPTH) * peeled;
                    self.inner_bark_color(self.phloem + depth * (wavy - self.phloem), surface.tone)
                }
                false => color,
            };
            surface.blend(color, grain * speck, inside);
            if edge == self.phloem {
                surface.blend(cambium, 0.1 * speck, CAMBIUM_SHARE * pale);
            }
        }
    }

    /// How much inner bark is left at a place of a face that bark came off, 0 to 1: it tears off in strings of many lengths, and more of it
    /// is left farther out. `string` is the width of its strings, m, of which the one there reaches far as `ragged` and `tone` say.
    fn bast(
        &self,
        rho: f64,
        (place, string): (DVec3, f64),
        ragged: f64,
        tone: f64,
        noises: &mut impl Noises,
    ) -> f64 {
        let thick = (self.drawn_inner_bark_end() - self.phloem).max(1e-6);
        let from_wood = ((rho - self.phloem) / thick).clamp(0.0, 1.0);
        let width = BAST_PATCH.0 * string;
        let (long, period) = periodic_cells(BAST_PATCH.1 * width, self.period);
        let scale = DVec3::new(1.0 / width, 1.0 / width, 1.0 / long);
        let noise = noises.gradient(BAST_NOISE, self.seed ^ BAST, place * scale, period);
        let patch = noise.0 + BAST_STRINGS.0 * ragged + BAST_STRINGS.1 * tone;
        let stays = BAST_STAYS.0 + (BAST_STAYS.1 - BAST_STAYS.0) * from_wood;
        BAST_SHARE * smoothstep(stays - BAST_EDGE, stays + BAST_EDGE, patch)
    }

    /// How far the borders of the inner bark are shifted at a place, in ring coordinates.
    fn uneven_bark(&self, place: DVec3, noises: &mut impl Noises) -> f64 {
        let thick = (self.drawn_inner_bark_end() - self.phloem).clamp(0.0, 0.1);
        let mut shift = 0.0;
        for (n, size, share) in [(1u64, 0.5, 0.5), (2, 0.13, 0.32)] {
            let size = size * self.radius.max(1e-6);
            let (long, period) = periodic_cells(4.0 * size, self.period);
            let scale = DVec3::new(1.0 / size, 1.0 / size, 1.0 / long);
            let seed = self.seed ^ SPECK ^ (n << 8);
            let number = UNEVEN_NOISES + n as usize - 1;
            shift += share * noises.gradient(number, seed, place * scale, period).0;
        }
        thick * shift
    }
}
