//! The look of wood and bark as pure functions of the address: colour, roughness and micro relief, asked both at the
//! pixels of pictures and for baked textures. A figure in the wood (a ring, a vessel, a ray) is a body in space, so
//! it runs on from one face of a splinter to the next.
//!
//! Shapes follow Hoadley, *Identifying Wood* (1990): rings with a dark outer edge, vessels and rays as lines or dots
//! according to how they are cut. Colours are those of air-dry wood under daylight. Detail finer than the asked
//! footprint is averaged away.

mod figures;
mod stem;

pub use crate::bark::{BarkAppearance, BarkPoint, bark};
use crate::noise::{smoothstep, space};
use glam::{DVec2, DVec3};
pub use stem::StemAppearance;

/// A place in the wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodPoint {
    /// Ring coordinate: 0 at the pith, 1 at the outside of the bark.
    pub ring: f64,
    /// Angle about the pith, rad.
    pub angle: f64,
    /// Place in the section, m, from the pith.
    pub across: DVec2,
    /// Length along the grain, m.
    pub along: f64,
    /// |normal · grain|: 0 on side grain, 1 on end grain.
    pub end_grain: f64,
}

/// What wood or bark looks like at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodSurface {
    /// Linear colour, each 0 to 1.
    pub color: [f64; 3],
    /// Roughness as in glTF, 0 to 1.
    pub roughness: f64,
    /// Micro relief, m outwards.
    pub height: f64,
    /// Change of `height` along x and y of the section and along the grain, m per m.
    pub slope: DVec3,
}

/// How the wood of a stem looks. Colours are linear.
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
    /// Strength of the latewood line, 0 (none) to 1.
    pub latewood: f64,
    /// Part of a ring's width over which its latewood darkens, 0 to 1.
    pub latewood_width: f64,
    /// Whether wide vessels stand in the first wood of each ring (oak, ash, elm).
    pub ring_porous: bool,
    /// Diameter of the vessels, m; 0 for softwoods, which have none.
    pub vessels: f64,
    /// Visibility of the rays, 0 to 1.
    pub rays: f64,
    /// Height of the rays along the grain, m.
    pub ray_height: f64,
    /// Seed of everything irregular.
    pub seed: u64,
    /// Length along the grain (m) after which the look repeats, for tiling textures; `None` for wood as it grows.
    pub period: Option<f64>,
}

/// An 8-bit sRGB colour as linear numbers.
pub(crate) fn srgb(color: [u8; 3]) -> [f64; 3] {
    color.map(|c| {
        let v = f64::from(c) / 255.0;
        if v <= 0.040_45 {
            v / 12.92
        } else {
            libm::pow((v + 0.055) / 1.055, 2.4)
        }
    })
}

pub(crate) fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}

/// How much of a figure of the given size is left when averaged over a footprint.
pub(crate) fn left_of(size: f64, footprint: f64) -> f64 {
    1.0 - smoothstep(0.4, 1.2, footprint / size)
}

/// End grain swallows light in its open cells.
const END_GRAIN_DARKENING: f64 = 0.30;
/// Relief between the soft earlywood and the hard latewood, m.
const RING_RELIEF: f64 = 40e-6;
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
            sapwood_color: srgb([224, 194, 150]),
            latewood_color: srgb([168, 118, 70]),
            heartwood_color: srgb([196, 147, 98]),
            pith_color: srgb([112, 74, 44]),
            phloem_color: srgb([128, 88, 58]),
            cork_color: srgb([80, 60, 46]),
            latewood: 0.95,
            latewood_width: 0.6,
            ring_porous: false,
            vessels: 0.0,
            rays: 0.25,
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
            latewood: 0.85,
            latewood_width: 0.35,
            vessels: 0.08e-3,
            rays: 0.6,
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
            latewood_color: srgb([178, 136, 90]),
            heartwood_color: srgb([168, 124, 80]),
            latewood: 0.6,
            latewood_width: 0.7,
            ring_porous: true,
            vessels: 0.22e-3,
            rays: 0.8,
            ray_height: 12e-3,
            ..WoodAppearance::softwood()
        }
    }

    /// What the wood (or the bark, where the ring coordinate lies beyond it) looks like at a place; detail finer than
    /// `footprint` (m) is averaged.
    pub fn wood(&self, at: &WoodPoint, footprint: f64) -> WoodSurface {
        let place = DVec3::new(at.across.x, at.across.y, at.along);
        let end = at.end_grain.clamp(0.0, 1.0);
        let (streak, mut height, mut slope) = self.streaks(place, footprint);
        let (late, late_slope, early) = self.ring(at, place, footprint);

        let sapwood = DVec3::from_array(self.sapwood_color);
        let mut color = mix(
            sapwood,
            DVec3::from_array(self.heartwood_color),
            self.heart(at, place),
        );
        let darker = DVec3::from_array(self.latewood_color) / sapwood.max(DVec3::splat(1e-3));
        color *= mix(DVec3::ONE, darker, late);
        color *= 1.0 - END_GRAIN_DARKENING * end * (1.0 - 0.25 * late);

        let vessel = self.vessel(place, early, footprint);
        color *= DVec3::ONE - DVec3::new(0.50, 0.58, 0.66) * vessel;
        let ray = self.rays * self.ray(at, footprint);
        // Rays shine pale across the end and as brown flecks along it.
        color *= mix(
            DVec3::new(0.80, 0.74, 0.68),
            DVec3::new(1.22, 1.24, 1.26),
            end,
        ) * ray
            + (1.0 - ray);
        // Blue falls most in the dark gaps between fibres: light that gets out of there went through more wood.
        color *= (DVec3::ONE + DVec3::new(1.0, 1.18, 1.45) * streak).max(DVec3::splat(0.1));

        height += RING_RELIEF * late - 0.5 * self.vessels * vessel;
        let outward = at.across.normalize_or_zero();
        slope += DVec3::new(outward.x, outward.y, 0.0) * (RING_RELIEF * late_slope);
        let mut roughness = 0.78 - 0.10 * late + 0.12 * end + 0.3 * streak.abs();

        let soft = (footprint / self.radius).max(0.004);
        let margin = 0.01 + (self.cork - self.phloem).clamp(0.0, 0.1);
        let outer = at.ring > self.phloem - soft - margin;
        if !outer && at.ring > self.pith * 1.15 + soft + 0.01 {
            return WoodSurface {
                color: color.clamp(DVec3::splat(0.004), DVec3::ONE).to_array(),
                roughness: roughness.clamp(0.3, 1.0),
                height,
                slope,
            };
        }
        let (long, period) = self.cells(8e-3);
        let scale = DVec3::new(900.0, 900.0, 1.0 / long);
        let ragged = space(self.seed ^ SPECK, place * scale, period).0;
        let speck = ragged * left_of(1.1e-3, footprint);
        let uneven = self.uneven_bark(place);
        for (edge, zone, grain) in [
            (-1.0, self.pith_color, 0.22),
            (self.phloem, self.phloem_color, 0.20),
            (self.cork, self.cork_color, 0.42),
        ] {
            // The pith lies below its edge, the barks above theirs; the cambium is no compass line, and the cork eats
            // into the inner bark in places.
            let wavy = 0.008 * ragged + if edge < 0.0 { 0.0 } else { uneven };
            let inside = if edge < 0.0 {
                1.0 - smoothstep(
                    self.pith * 0.7 - soft,
                    self.pith * 1.15 + soft,
                    at.ring + wavy,
                )
            } else {
                smoothstep(edge - soft, edge + soft, at.ring + wavy)
            };
            if inside > 0.0 {
                let shade = (1.0 + grain * speck + 0.5 * streak) * (1.0 - 0.15 * end);
                color = mix(color, DVec3::from_array(zone) * shade, inside);
                roughness = mix_scalar(roughness, 0.94, inside);
            }
        }
        WoodSurface {
            color: color.clamp(DVec3::splat(0.004), DVec3::ONE).to_array(),
            roughness: roughness.clamp(0.3, 1.0),
            height,
            slope,
        }
    }
}

impl WoodAppearance {
    /// How far the borders of the inner bark are shifted at a place, in ring coordinates.
    fn uneven_bark(&self, place: DVec3) -> f64 {
        let thick = (self.cork - self.phloem).clamp(0.0, 0.1);
        let mut shift = 0.0;
        for (n, size, share) in [(1u64, 0.5, 0.5), (2, 0.13, 0.32)] {
            let size = size * self.radius.max(1e-6);
            let (long, period) = self.cells(4.0 * size);
            let scale = DVec3::new(1.0 / size, 1.0 / size, 1.0 / long);
            shift += share * space(self.seed ^ SPECK ^ (n << 8), place * scale, period).0;
        }
        thick * shift
    }
}

pub(crate) fn mix_scalar(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, along: f64, end_grain: f64) -> WoodPoint {
        let across = DVec2::new(x, y);
        WoodPoint {
            ring: across.length() / 0.03,
            angle: y.atan2(x),
            across,
            along,
            end_grain,
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
                if (from..to).contains(&p.ring) {
                    sum += brightness(look.wood(&p, 1e-4).color);
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
            let phloem = mean(&look, look.phloem + 0.012, look.cork - 0.006, 0.0);
            let cork = mean(&look, look.cork + 0.012, 1.0, 0.0);
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
                fine += brightness(look.wood(&p, 1e-6).color);
                coarse += brightness(look.wood(&p, 2.5e-3).color);
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
                brightness(look.wood(&at(0.02 + dx, 0.0, s + ds, 0.0), 1e-5).color)
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
        let wood = WoodAppearance {
            rings: 0.0,
            ..WoodAppearance::softwood()
        };
        let step = 1e-9;
        for i in 0..100 {
            let (angle, along) = (f64::from(i) * 0.071, f64::from(i) * 0.0137);
            let height = |a: f64| wood.wood(&at(0.01 + a, 0.003, along, 0.0), 1e-5);
            let slope = (height(step).height - height(-step).height) / (2.0 * step);
            assert!((slope - height(0.0).slope.x).abs() < 1e-3, "{slope}");
            let height = |s: f64| {
                bark(
                    &look,
                    &BarkPoint {
                        angle,
                        along: s,
                        radius: 0.1,
                    },
                    1e-5,
                )
            };
            let slope = (height(along + 1e-7).height - height(along - 1e-7).height) / 2e-7;
            assert!((slope - height(along).slope.z).abs() < 1e-2, "{slope}");
        }
    }

    #[test]
    fn the_look_repeats_after_its_period() {
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
                let q = WoodPoint {
                    along: p.along + 0.06,
                    ..p
                };
                let (a, b) = (look.wood(&p, 1e-5).color, look.wood(&q, 1e-5).color);
                assert!(
                    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-6),
                    "{a:?} {b:?} at {i}"
                );
            }
        }
    }
}
