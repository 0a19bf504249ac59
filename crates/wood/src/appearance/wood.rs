//! The appearance of wood: rings, streaks, vessels, rays and the tissues of a section.

use super::bark_kinds::BarkKind;
use super::mix::{mix, mix_scalar, visible_detail};
use super::noises::{SPECK_NOISE, UNEVEN_NOISES};
use super::surface::WoodSurface;
use crate::colour::linear_from_srgb as srgb;
use crate::noise::{Forgetful, NoiseMemory, Noises, smoothstep};
use crate::rings::{ConcentricRings, RingSource, StemAddress, periodic_cells};
use crate::tissue::Proportions;
use glam::{DVec2, DVec3};

/// A point in the wood, and how the surface cuts the grain there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodPoint {
    /// Where it is.
    pub address: StemAddress,
    /// |normal · grain|: 0 on side grain, 1 on end grain.
    pub end_grain: f64,
    /// The normal in the section, of any length; zero where it is not known. A thin gap that lies in the surface is no dark patch.
    pub facing: DVec2,
}

/// How the wood of a stem looks. Colours are linear.
///
/// ```
/// use glam::DVec2;
/// use greenstick_wood::appearance::{WoodAppearance, WoodPoint};
/// use greenstick_wood::rings::StemAddress;
///
/// let oak = WoodAppearance::ring_porous();
/// let across = DVec2::new(0.015, 0.0); // m from the pith
/// let address = StemAddress { rho: across.length() / oak.radius, angle: 0.0, across, along: 0.2 };
/// let rings = oak.usual_rings();
/// let point = |end_grain| WoodPoint { address, end_grain, facing: DVec2::ZERO };
/// let end_grain = oak.surface_at(&rings, &point(1.0), 1e-4);
/// let side_grain = oak.surface_at(&rings, &point(0.0), 1e-4);
/// assert!(end_grain.color[0] < side_grain.color[0]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct WoodAppearance {
    /// Number of annual rings between pith and phloem.
    pub rings: f64,
    /// Radius of the section with its bark, m.
    pub radius: f64,
    /// Ring coordinate at the edge of the pith.
    pub pith: f64,
    /// Ring coordinate at the edge of the heartwood; 0 for none.
    pub heartwood: f64,
    /// Ring coordinate where wood ends and the inner bark (phloem) begins.
    pub phloem: f64,
    /// Ring coordinate where the inner bark ends and the outer bark (cork) begins.
    pub cork: f64,
    /// Earlywood of the sapwood.
    pub sapwood_color: [f64; 3],
    /// Latewood of the sapwood.
    pub latewood_color: [f64; 3],
    /// Earlywood of the heartwood.
    pub heartwood_color: [f64; 3],
    /// The pith.
    pub pith_color: [f64; 3],
    /// The inner bark.
    pub phloem_color: [f64; 3],
    /// The outer bark where it is cut or torn.
    pub cork_color: [f64; 3],
    /// The ridges of the bark, where their colour is given.
    pub bark_color: Option<[f64; 3]>,
    /// The kind of bark, where the genus is known.
    pub bark_kind: Option<BarkKind>,
    /// How much latewood is darker, 0 (not at all) to 1.
    pub latewood_contrast: f64,
    /// Part of a ring's width over which its latewood darkens, 0 to 1.
    pub latewood_width: f64,
    /// Whether wide vessels stand in the first wood of each ring (oak, ash, elm).
    pub ring_porous: bool,
    /// Diameter of the vessels, m; 0 for softwoods, which have none.
    pub vessel_diameter: f64,
    /// How much rays stand out, 0 to 1.
    pub ray_contrast: f64,
    /// Height of the rays along the grain, m.
    pub ray_height: f64,
    /// Seed of everything irregular.
    pub seed: u64,
    /// Length along the grain (m) after which the appearance repeats, for tiling textures; `None` for wood as it grows.
    pub period: Option<f64>,
}

/// How much darker end grain is: its open cells swallow light.
const END_GRAIN_DARKENING: f64 = 0.30;
/// Relief between the soft earlywood and the hard latewood, m.
const RING_RELIEF: f64 = 40e-6;
/// How much darker lines of latewood are than their colour, as their ridges catch the light, and how much higher they stand on faces
/// along the grain than across it.
const LATEWOOD_LINES: f64 = 1.35;
const RIDGES_ALONG: f64 = 1.5;
/// How much darker the gaps of hairline splits are: blue most, as light there went through wood.
const SPLIT_DARKENING: DVec3 = DVec3::new(0.62, 0.70, 0.78);
/// How much less streaks show across the grain than along it.
const STREAKS_ACROSS: f64 = 0.5;
/// How much less splits show across the grain, where a saw or a tear has filled them.
const SPLIT_ACROSS: f64 = 0.65;
/// Width of the cambium, a pale line between wood and bark, m, and how much it shows.
const CAMBIUM_WIDTH: f64 = 0.4e-3;
const CAMBIUM_SHARE: f64 = 0.7;
/// Cosines of the angle to the direction away from the pith between which a face begins to be one that bark came off.
const PEELED: (f64, f64) = (0.15, 0.5);
/// Distances beyond the inner bark, in ring coordinates, between which such faces end.
const OUTSIDE: (f64, f64) = (0.006, 0.016);
/// Tones of slivers between which those begin that inner bark sticks to.
const BAST: (f64, f64) = (0.42, 0.62);
/// Parts of the thickness of the inner bark between which a face that looks outwards begins to show it.
const BARE_BAST: (f64, f64) = (0.35, 0.75);
/// How much of the wood strings of inner bark hide: they are thin.
const BAST_SHARE: f64 = 0.75;
/// In the hash: what the specks of pith and bark are drawn for.
const SPECK: u64 = 0x4b;

impl Default for WoodAppearance {
    fn default() -> Self {
        WoodAppearance::softwood()
    }
}

impl WoodAppearance {
    /// Pine or spruce: pale, with strong latewood lines.
    pub fn softwood() -> Self {
        WoodAppearance {
            rings: 14.0,
            radius: 0.03,
            pith: 0.03,
            heartwood: 0.38,
            phloem: 0.93,
            cork: 0.965,
            sapwood_color: srgb([228, 201, 160]),
            latewood_color: srgb([184, 142, 99]),
            heartwood_color: srgb([214, 177, 135]),
            pith_color: srgb([112, 74, 44]),
            phloem_color: srgb([172, 127, 95]),
            cork_color: srgb([100, 68, 47]),
            bark_color: None,
            bark_kind: None,
            latewood_contrast: 0.95,
            latewood_width: 0.6,
            ring_porous: false,
            vessel_diameter: 0.0,
            ray_contrast: 0.25,
            ray_height: 0.4e-3,
            seed: 0,
            period: None,
        }
    }

    /// Beech, maple or birch: even, with thin ring lines, fine vessels and clear rays.
    pub fn hardwood() -> Self {
        WoodAppearance {
            rings: 18.0,
            heartwood: 0.3,
            sapwood_color: srgb([218, 186, 144]),
            latewood_color: srgb([176, 132, 90]),
            heartwood_color: srgb([188, 144, 102]),
            latewood_contrast: 0.85,
            latewood_width: 0.35,
            vessel_diameter: 0.08e-3,
            ray_contrast: 0.6,
            ray_height: 2.5e-3,
            ..WoodAppearance::softwood()
        }
    }

    /// Oak or ash: wide vessels in the first wood of every ring.
    pub fn ring_porous() -> Self {
        WoodAppearance {
            rings: 14.0,
            heartwood: 0.62,
            sapwood_color: srgb([214, 184, 140]),
            phloem_color: srgb([142, 100, 72]),
            latewood_color: srgb([178, 136, 90]),
            heartwood_color: srgb([168, 124, 80]),
            latewood_contrast: 0.6,
            latewood_width: 0.7,
            ring_porous: true,
            vessel_diameter: 0.22e-3,
            ray_contrast: 0.8,
            ray_height: 12e-3,
            ..WoodAppearance::softwood()
        }
    }

    /// The rings that a stem of this wood has where nothing is known of them.
    pub fn usual_rings(&self) -> ConcentricRings {
        let proportions = Proportions {
            pith: self.pith,
            heartwood: (self.heartwood - self.pith).max(0.0),
            phloem: (self.cork - self.phloem).max(0.0),
        };
        ConcentricRings::grown(self.rings.round() as u16, self.seed, &proportions)
    }

    /// Returns what the wood (or the bark, where the ring coordinate lies beyond it) looks like at a point in wood with these
    /// annual rings; detail finer than `footprint` (m) is averaged.
    pub fn surface_at(
        &self,
        rings: &dyn RingSource,
        at: &WoodPoint,
        footprint: f64,
    ) -> WoodSurface {
        self.surface_by(rings, at, footprint, &mut Forgetful)
    }

    /// [`WoodAppearance::surface_at`] for points visited one after another, such as those of a texture's row: `memory` is
    /// kept between them. The outcome is the same, sooner.
    pub fn surface_in_row(
        &self,
        rings: &dyn RingSource,
        at: &WoodPoint,
        footprint: f64,
        memory: &mut NoiseMemory,
    ) -> WoodSurface {
        self.surface_by(rings, at, footprint, memory)
    }

    fn surface_by(
        &self,
        rings: &dyn RingSource,
        at: &WoodPoint,
        footprint: f64,
        noises: &mut impl Noises,
    ) -> WoodSurface {
        let address = &at.address;
        let place = DVec3::new(address.across.x, address.across.y, address.along);
        let end = at.end_grain.clamp(0.0, 1.0);
        let straight = self.waved(place);
        let mut streaks = self.streaks(straight, footprint, noises);
        let bundles = self.bundles(straight, at.facing, footprint);
        streaks.shade += bundles.shade;
        streaks.height += bundles.height;
        streaks.slope += bundles.slope;
        // A saw cuts all fibres at one height.
        streaks.slope *= 1.0 - STREAKS_ACROSS * end;
        streaks.shade *= 1.0 - STREAKS_ACROSS * end;
        let latewood = self.latewood(rings, address, footprint);
        let vessel = self.vessel(place, latewood.first_earlywood, footprint);
        let ray = self.ray_contrast * self.ray(address, footprint);
        let split = self.split(address, (place, at.facing), footprint);
        let gap = split.gap.max(bundles.gap) * (1.0 - SPLIT_ACROSS * end);

        let sapwood = DVec3::from_array(self.sapwood_color);
        let mut color = mix(
            sapwood,
            DVec3::from_array(self.heartwood_color),
            self.heartwood_share(address, place, noises),
        );
        color *= self.tint(straight, (address.rho, bundles.tone), footprint, noises);
        let late = latewood.darkness;
        let darker = DVec3::from_array(self.latewood_color) / sapwood.max(DVec3::splat(1e-3));
        color *= mix(DVec3::ONE, darker, late * LATEWOOD_LINES).max(DVec3::splat(0.1));
        color *= 1.0 - END_GRAIN_DARKENING * end * (1.0 - 0.25 * late);
        color *= DVec3::ONE - DVec3::new(0.50, 0.58, 0.66) * vessel;
        // Rays shine pale across the end and as brown flecks along it.
        color *= mix(
            DVec3::new(0.72, 0.65, 0.58),
            DVec3::new(1.22, 1.24, 1.26),
            end,
        ) * ray
            + (1.0 - ray);
        // Blue falls most in the dark gaps between fibres: light that gets out of there went through more wood.
        color *= (DVec3::ONE + DVec3::new(1.0, 1.18, 1.45) * streaks.shade).max(DVec3::splat(0.1));
        color *= DVec3::ONE - SPLIT_DARKENING * gap;

        let ridges = 1.0 + RIDGES_ALONG * (1.0 - end);
        let height = streaks.height
            + split.height
            + (RING_RELIEF * ridges * late - 0.5 * self.vessel_diameter * vessel);
        let outward = address.across.normalize_or_zero();
        let ring_slope =
            DVec3::new(outward.x, outward.y, 0.0) * (RING_RELIEF * ridges * latewood.slope);
        let roughness = 0.78 - 0.10 * late + 0.12 * end + 0.3 * streaks.shade.abs();
        let mut surface = TissueBlend {
            color,
            roughness,
            end,
            shade: streaks.shade,
            tone: bundles.tone,
            outwards: at
                .facing
                .normalize_or_zero()
                .dot(address.across.normalize_or_zero()),
        };
        self.blend_tissues(&mut surface, address, place, footprint, noises);
        WoodSurface {
            color: surface
                .color
                .clamp(DVec3::splat(0.004), DVec3::ONE)
                .to_array(),
            roughness: surface.roughness.clamp(0.3, 1.0),
            height,
            slope: streaks.slope + split.slope + ring_slope,
        }
    }

    /// Blends pith and barks over the wood near and beyond their edges.
    fn blend_tissues(
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
        let margin = 0.01 + (cork - self.phloem).clamp(0.0, 0.1);
        let near_bark = rho > self.phloem - soft - margin;
        let near_pith = rho <= self.pith * 1.15 + soft + 0.01;
        if !near_bark && !near_pith {
            return;
        }
        let (long, period) = periodic_cells(8e-3, self.period);
        let scale = DVec3::new(900.0, 900.0, 1.0 / long);
        let ragged = noises
            .gradient(SPECK_NOISE, self.seed ^ SPECK, place * scale, period)
            .0;
        let speck = ragged * visible_detail(1.1e-3, footprint);
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
        // out it is the side of a plate of bark.
        let peeled = smoothstep(PEELED.0, PEELED.1, surface.outwards)
            * (1.0 - surface.end)
            * (1.0 - smoothstep(cork + OUTSIDE.0, cork + OUTSIDE.1, rho));
        let strings = BAST_SHARE * smoothstep(BAST.0, BAST.1, surface.tone + 0.35 * ragged);
        // What looks outwards farther from the cambium is inner bark that the outer bark came off.
        let from_wood = (rho - self.phloem) / (cork - self.phloem).max(1e-6);
        let bare = 1.0 - smoothstep(BARE_BAST.0, BARE_BAST.1, from_wood);
        let bare_wood = |edge: f64| match edge == self.phloem {
            true => peeled * bare * (1.0 - strings),
            false => peeled,
        };
        for (edge, color, grain) in [
            (self.phloem, self.phloem_color, 0.20),
            (cork, self.cork_color, 0.42),
        ] {
            let wavy = rho + (0.008 * ragged + uneven);
            let inside = smoothstep(edge - soft, edge + soft, wavy) * (1.0 - bare_wood(edge));
            let color = match edge == self.phloem {
                true => self.inner_bark_color(wavy, surface.tone),
                false => color,
            };
            surface.blend(color, grain * speck, inside);
            if edge == self.phloem {
                surface.blend(cambium, 0.1 * speck, CAMBIUM_SHARE * pale);
            }
        }
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

/// Colour and roughness that tissues are blended into.
struct TissueBlend {
    color: DVec3,
    roughness: f64,
    /// |normal · grain|.
    end: f64,
    /// Change of brightness by streaks.
    shade: f64,
    /// Tone of the slivers, −1 to 1.
    tone: f64,
    /// Cosine of the angle between the normal and the direction away from the pith, 0 where that is not known.
    outwards: f64,
}

impl TissueBlend {
    /// Blends a tissue in, whose brightness is changed by `speck`, by the part `inside` of the footprint that it takes.
    fn blend(&mut self, color: [f64; 3], speck: f64, inside: f64) {
        const TISSUE_ROUGHNESS: f64 = 0.94;
        if inside > 0.0 {
            let shade = (1.0 + speck + 0.8 * self.shade) * (1.0 - 0.15 * self.end);
            self.color = mix(self.color, DVec3::from_array(color) * shade, inside);
            self.roughness = mix_scalar(self.roughness, TISSUE_ROUGHNESS, inside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::{BarkAppearance, BarkPoint};
    use crate::rings::RingPosition;

    fn at(x: f64, y: f64, along: f64, end_grain: f64) -> WoodPoint {
        let across = DVec2::new(x, y);
        WoodPoint {
            address: StemAddress {
                rho: across.length() / 0.03,
                angle: y.atan2(x),
                across,
                along,
            },
            end_grain,
            facing: DVec2::ZERO,
        }
    }

    /// The appearance at a point of wood with its usual rings.
    fn show(look: &WoodAppearance, p: &WoodPoint, footprint: f64) -> WoodSurface {
        look.surface_at(&look.usual_rings(), p, footprint)
    }

    /// Wood without rings.
    struct NoRings;

    impl RingSource for NoRings {
        fn ring_count(&self) -> usize {
            0
        }

        fn ring_at(&self, _: &StemAddress) -> Option<RingPosition> {
            None
        }
    }

    fn brightness(color: [f64; 3]) -> f64 {
        color[0] * 0.2126 + color[1] * 0.7152 + color[2] * 0.0722
    }

    /// Mean brightness over a grid in the section between two ring coordinates.
    fn mean(look: &WoodAppearance, from: f64, to: f64, end: f64) -> f64 {
        let (mut sum, mut number) = (0.0, 0.0);
        for i in -60..60 {
            for j in -60..60 {
                let p = at(f64::from(i) * 5.03e-4, f64::from(j) * 5.03e-4, 0.0, end);
                if (from..to).contains(&p.address.rho) {
                    sum += brightness(show(look, &p, 1e-4).color);
                    number += 1.0;
                }
            }
        }
        sum / number
    }

    #[test]
    fn zones_are_ordered_by_brightness_as_in_real_wood() {
        for look in [
            WoodAppearance::softwood(),
            WoodAppearance::hardwood(),
            WoodAppearance::ring_porous(),
        ] {
            let sapwood = mean(&look, look.heartwood + 0.12, look.phloem - 0.02, 0.0);
            let heartwood = mean(&look, look.pith + 0.05, look.heartwood - 0.12, 0.0);
            let phloem = mean(
                &look,
                look.phloem + 0.012,
                look.drawn_inner_bark_end() - 0.006,
                0.0,
            );
            let cork = mean(&look, look.drawn_inner_bark_end() + 0.012, 1.0, 0.0);
            let end = mean(&look, look.heartwood + 0.12, look.phloem - 0.02, 1.0);
            assert!(
                sapwood > heartwood * 1.15,
                "sapwood {sapwood}, heartwood {heartwood}"
            );
            assert!(
                heartwood > phloem && phloem > cork,
                "{heartwood} {phloem} {cork}"
            );
            assert!(end < sapwood * 0.9, "end grain {end}, side grain {sapwood}");
        }
    }

    #[test]
    fn a_coarse_footprint_gives_the_mean_of_the_detail() {
        let look = WoodAppearance {
            heartwood: 0.0,
            ..WoodAppearance::softwood()
        };
        let (mut fine, mut coarse) = (0.0, 0.0);
        for i in 0..200 {
            for j in 0..60 {
                let p = at(
                    0.003 + f64::from(i) * 1.1e-4,
                    f64::from(j) * 1.1e-4,
                    0.0,
                    0.0,
                );
                fine += brightness(show(&look, &p, 1e-6).color);
                coarse += brightness(show(&look, &p, 2.5e-3).color);
            }
        }
        assert!(
            (fine / coarse - 1.0).abs() < 0.06,
            "fine {fine}, coarse {coarse}"
        );
    }

    #[test]
    fn streaks_run_along_the_grain() {
        let look = WoodAppearance::softwood();
        let (mut across, mut along) = (0.0, 0.0);
        for i in 0..500 {
            let s = f64::from(i) * 3.7e-3;
            let color = |dx: f64, ds: f64| {
                brightness(show(&look, &at(0.02 + dx, 0.0, s + ds, 0.0), 1e-5).color)
            };
            across += (color(5e-4, 0.0) - color(0.0, 0.0)).abs();
            along += (color(0.0, 5e-4) - color(0.0, 0.0)).abs();
        }
        assert!(
            across > 5.0 * along,
            "changes across {across}, along {along}"
        );
    }

    #[test]
    fn slopes_are_those_of_the_relief() {
        let look = BarkAppearance {
            lenticels: 0.0,
            ..BarkAppearance::furrowed(0.1)
        };
        let wood = WoodAppearance::softwood();
        let step = 1e-9;
        for i in 0..100 {
            let (angle, along) = (f64::from(i) * 0.071, f64::from(i) * 0.0137);
            let height = |a: f64| wood.surface_at(&NoRings, &at(0.01 + a, 0.003, along, 0.0), 1e-5);
            let slope = (height(step).height - height(-step).height) / (2.0 * step);
            assert!((slope - height(0.0).slope.x).abs() < 1e-3, "{slope}");
            let height = |s: f64| {
                let at = BarkPoint {
                    angle,
                    along: s,
                    radius: 0.1,
                };
                look.surface_at(&at, 1e-5)
            };
            let slope = (height(along + 1e-7).height - height(along - 1e-7).height) / 2e-7;
            assert!((slope - height(along).slope.z).abs() < 1e-2, "{slope}");
        }
    }

    #[test]
    fn the_appearance_repeats_after_its_period() {
        for base in [
            WoodAppearance::softwood(),
            WoodAppearance::hardwood(),
            WoodAppearance::ring_porous(),
        ] {
            let look = WoodAppearance {
                period: Some(0.06),
                ..base
            };
            for i in 0..300 {
                let t = f64::from(i);
                let p = at(
                    (t * 0.37).sin() * 0.02,
                    (t * 0.61).cos() * 0.02,
                    t * 2.3e-4,
                    0.0,
                );
                let mut q = p;
                q.address.along += 0.06;
                let (a, b) = (show(&look, &p, 1e-5).color, show(&look, &q, 1e-5).color);
                assert!(
                    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-6),
                    "{a:?} {b:?} at {i}"
                );
            }
        }
    }
}
