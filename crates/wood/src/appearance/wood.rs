//! The appearance of wood: rings, streaks, vessels, rays and the tissues of a section.

use super::bark_kinds::BarkKind;
use super::mix::mix;
use super::surface::WoodSurface;
use super::tissue_blend::TissueBlend;
use crate::colour::linear_from_srgb as srgb;
use crate::noise::{Forgetful, NoiseMemory, Noises};
use crate::rings::{ConcentricRings, RingSource, StemAddress};
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
/// How much darker lines of latewood are than their colour, along the grain, where their ridges catch the light, and across it; and how
/// much higher they stand on faces along the grain.
const LATEWOOD_LINES: (f64, f64) = (1.8, 1.35);
const RIDGES_ALONG: f64 = 1.5;
/// How much darker the gaps of hairline splits are: blue most, as light there went through wood.
const SPLIT_DARKENING: DVec3 = DVec3::new(0.62, 0.70, 0.78);
/// How much less streaks show across the grain than along it.
const STREAKS_ACROSS: f64 = 0.5;
/// How much less splits show across the grain, where a saw or a tear has filled them.
const SPLIT_ACROSS: f64 = 0.65;
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
            phloem_color: srgb([152, 122, 94]),
            cork_color: srgb([118, 93, 72]),
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
        let (along, across) = LATEWOOD_LINES;
        let lines = along + (across - along) * end;
        color *= mix(DVec3::ONE, darker, late * lines).max(DVec3::splat(0.1));
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
