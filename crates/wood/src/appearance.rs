//! The look of wood and bark as pure functions of the address: colour, roughness and micro relief, asked both at the
//! pixels of pictures and for baked textures. A figure in the wood (a ring, a vessel, a ray) is a body in space, so
//! it runs on from one face of a splinter to the next.
//!
//! Shapes follow Hoadley, *Identifying Wood* (1990): rings with a dark outer edge, vessels and rays as lines or dots
//! according to how they are cut. Colours are those of air-dry wood under daylight. Detail finer than the asked
//! footprint is averaged away.

pub use crate::bark::{BarkAppearance, BarkPoint, bark};
use crate::noise::{hash, line, smoothstep, space, unit};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

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

/// Fibre bundles, slivers and fibres: width (m), share of the brightness, relief (m). Lengths are [`STRETCH`] widths.
const STREAKS: [(f64, f64, f64); 4] = [
    (5.0e-3, 0.10, 120e-6),
    (1.3e-3, 0.17, 90e-6),
    (0.35e-3, 0.24, 48e-6),
    (0.10e-3, 0.24, 16e-6),
];
/// Length of a streak in widths: fibres are 40 to 100 times longer than wide.
const STRETCH: f64 = 40.0;
/// End grain swallows light in its open cells.
const END_GRAIN_DARKENING: f64 = 0.30;
/// Relief between the soft earlywood and the hard latewood, m.
const RING_RELIEF: f64 = 40e-6;
/// Width of a ray, m, and the distance between rays around the stem.
const RAY: (f64, f64) = (0.12e-3, 1.1e-3);
/// Length of a ray from the pith outwards before it stops, m.
const RAY_LENGTH: f64 = 14e-3;
/// Length of a vessel's visible groove, in diameters.
const VESSEL_LENGTH: f64 = 130.0;

// What for, in the hash: each figure has its own numbers.
const RING: u64 = 0x52;
const WANDER: u64 = 0x57;
const STREAK: u64 = 0x53;
const HEART: u64 = 0x48;
const VESSEL: u64 = 0x56;
const RAYS: u64 = 0x59;
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
        let outer = at.ring > self.phloem - soft - 0.01;
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
        for (edge, zone, grain) in [
            (-1.0, self.pith_color, 0.22),
            (self.phloem, self.phloem_color, 0.20),
            (self.cork, self.cork_color, 0.42),
        ] {
            // The pith lies below its edge, the barks above theirs.
            let wavy = 0.008 * ragged;
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

    /// The length of a cell along the grain that fits the period, and the number of cells in it (0: no period).
    fn cells(&self, length: f64) -> (f64, i64) {
        match self.period {
            Some(period) if period > 0.0 => {
                let number = (period / length).round().max(1.0);
                (period / number, number as i64)
            }
            _ => (length, 0),
        }
    }

    /// Streaks of fibres: change of brightness, relief (m) and its slope.
    fn streaks(&self, place: DVec3, footprint: f64) -> (f64, f64, DVec3) {
        let (mut shade, mut height, mut slope) = (0.0, 0.0, DVec3::ZERO);
        for (i, (width, share, relief)) in STREAKS.into_iter().enumerate() {
            let keep = left_of(width, footprint);
            if keep == 0.0 {
                break;
            }
            let (length, period) = self.cells(width * STRETCH);
            let scale = DVec3::new(1.0 / width, 1.0 / width, 1.0 / length);
            let (v, g) = space(
                self.seed ^ STREAK ^ ((i as u64) << 8),
                place * scale,
                period,
            );
            // Dark gaps are narrow, pale fibres wide: squash the bright side.
            let skewed = if v > 0.0 {
                v * (1.0 - 0.35 * v)
            } else {
                v * (1.0 - 0.5 * v)
            };
            shade += skewed * share * keep;
            height += v * relief * keep;
            slope += g * scale * (relief * keep);
        }
        (shade, height, slope)
    }

    /// Outer edge of a ring, in rings: years differ, and good years come together.
    fn edge(&self, ring: i64) -> f64 {
        let seed = self.seed ^ RING;
        ring as f64 + 0.34 * (unit(seed, ring, 1, 0) - 0.5) + 0.6 * line(seed, ring as f64 / 4.0)
    }

    /// Latewood at a place: how dark (0 to 1), its slope outwards (1/m), and how much the place belongs to the first
    /// wood of its ring.
    fn ring(&self, at: &WoodPoint, place: DVec3, footprint: f64) -> (f64, f64, f64) {
        if self.rings < 0.5 || at.ring >= self.phloem {
            return (0.0, 0.0, 0.0);
        }
        // Young trees grow wider rings.
        let r = (at.ring / self.phloem).clamp(0.0, 1.0);
        let warped = r * (0.78 + 0.22 * r);
        let per_metre = self.rings * (0.78 + 0.44 * r) / (self.radius * self.phloem);
        let wide = 0.5 * self.radius;
        let (long, period) = self.cells(8.0 * self.radius);
        let slow = place * DVec3::new(1.0 / wide, 1.0 / wide, 1.0 / long);
        let (fine_long, fine_period) = self.cells(0.08);
        let fine = place * DVec3::new(260.0, 260.0, 1.0 / fine_long);
        let seed = self.seed ^ WANDER;
        let wander =
            0.35 * space(seed, slow, period).0 + 0.07 * space(seed ^ 256, fine, fine_period).0;
        let t = warped * self.rings + wander * smoothstep(0.0, 1.5, warped * self.rings);
        let mut ring = t.floor() as i64;
        while self.edge(ring) > t {
            ring -= 1;
        }
        while self.edge(ring + 1) <= t {
            ring += 1;
        }
        let (inner, outer) = (self.edge(ring), self.edge(ring + 1));
        let fraction = (t - inner) / (outer - inner);
        let half = (0.6 * footprint * per_metre / (outer - inner)).max(0.02);
        // Mean of the darkness over the footprint, from its integral.
        let start = 1.0 - self.latewood_width.clamp(0.02, 1.0);
        let whole = (1.0 - start) / 3.0;
        let integral = |f: f64| {
            let x = ((f - f.floor() - start) / (1.0 - start)).max(0.0);
            f.floor() * whole + whole * x * x * x
        };
        let dark = |f: f64| {
            let x = ((f - f.floor() - start) / (1.0 - start)).max(0.0);
            x * x
        };
        let mean = (integral(fraction + half) - integral(fraction - half)) / (2.0 * half);
        let slope = (dark(fraction + half) - dark(fraction - half)) / (2.0 * half);
        let strength = self.latewood * (0.55 + 0.45 * unit(self.seed ^ RING, ring, 2, 0));
        let early = if self.ring_porous {
            1.0 - smoothstep(0.12, 0.34, fraction)
        } else {
            1.0
        };
        (
            mean * strength,
            slope * strength * per_metre / (outer - inner),
            early,
        )
    }

    /// Share of heartwood, 0 to 1, behind an uneven edge.
    fn heart(&self, at: &WoodPoint, place: DVec3) -> f64 {
        if self.heartwood <= 0.0 {
            return 0.0;
        }
        if (at.ring - self.heartwood).abs() > 0.13 {
            // Further off than the edge wanders.
            return f64::from(u8::from(at.ring < self.heartwood));
        }
        let wide = 0.4 * self.radius;
        let (long, period) = self.cells(10.0 * self.radius);
        let scale = DVec3::new(1.0 / wide, 1.0 / wide, 1.0 / long);
        let edge = self.heartwood + 0.07 * space(self.seed ^ HEART, place * scale, period).0;
        1.0 - smoothstep(edge - 0.035, edge + 0.025, at.ring)
    }

    /// How deep a place lies in a vessel, 0 to 1: a dot across the grain, a groove along it.
    fn vessel(&self, place: DVec3, early: f64, footprint: f64) -> f64 {
        let keep = left_of(self.vessels * 1.6, footprint);
        if self.vessels <= 0.0 {
            return 0.0;
        }
        let density = if self.ring_porous {
            0.06 + 0.94 * early
        } else {
            0.5
        };
        // What cannot be told apart any more darkens all alike.
        let average = 0.22 * density;
        if keep == 0.0 {
            return average;
        }
        let width = self.vessels * 1.5;
        let (x, y) = (place.x / width, place.y / width);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (length, period) = self.cells(self.vessels * VESSEL_LENGTH);
        let seed = self.seed ^ VESSEL;
        let z = place.z / length + unit(seed, i, j, -1);
        let k = z.floor();
        let cell = if period > 0 {
            (k as i64).rem_euclid(period)
        } else {
            k as i64
        };
        let h = hash(seed, i, j, cell);
        let part = |shift: u32| ((h >> shift) & 0xfff) as f64 / 4096.0;
        if part(0) > density {
            return average * (1.0 - keep);
        }
        let radius = 0.24 + 0.10 * part(12);
        let (cx, cy) = (
            radius + (1.0 - 2.0 * radius) * part(24),
            radius + (1.0 - 2.0 * radius) * part(36),
        );
        let (dx, dy) = (x - i as f64 - cx, y - j as f64 - cy);
        let off = (dx * dx + dy * dy).sqrt();
        let soft = (0.5 * footprint / width).max(0.05);
        let taper = smoothstep(0.0, 0.08, (z - k).min(1.0 - (z - k)));
        mix_scalar(
            average,
            1.0 - smoothstep(radius - soft, radius + soft, off),
            keep,
        ) * taper
    }

    /// How much a place lies in a ray, 0 to 1. Rays are thin sheets from the pith outwards, of limited height; where
    /// the stem has grown wide new ones begin, so that they keep their distance.
    fn ray(&self, at: &WoodPoint, footprint: f64) -> f64 {
        let radius = at.across.length();
        if self.rays <= 0.0 || at.ring > self.phloem || radius < 1e-6 {
            return 0.0;
        }
        let wide = RAY.0.max(footprint);
        if wide > RAY.1 * 2.0 {
            return 0.0;
        }
        let wanted = TAU * radius / RAY.1;
        // The power of two below the wanted number of sectors: halves of a doubling keep their rays.
        let mut sectors: i64 = 4;
        while (sectors * 2) as f64 <= wanted && sectors < 1 << 20 {
            sectors *= 2;
        }
        let mut most = 0.0f64;
        for (number, share) in [(sectors, 1.0), (sectors * 2, wanted / sectors as f64 - 1.0)] {
            let turn = at.angle / TAU;
            let x = (turn - turn.floor()) * number as f64;
            let sector = (x.floor() as i64).rem_euclid(number);
            let seed = self.seed ^ RAYS ^ ((number as u64) << 8);
            let (length, period) = self.cells(self.ray_height);
            let z = at.along / length + unit(seed, sector, -1, 0);
            let level = if period > 0 {
                (z.floor() as i64).rem_euclid(period)
            } else {
                z.floor() as i64
            };
            let out = radius / RAY_LENGTH + unit(seed, sector, level, -2);
            let h = hash(seed, sector, level, out.floor() as i64);
            let part = |shift: u32| ((h >> shift) & 0xffff) as f64 / 65_536.0;
            if part(0) > 0.75 * share.clamp(0.0, 1.0) {
                continue;
            }
            let off = (x - x.floor() - 0.2 - 0.6 * part(16)).abs() * TAU * radius / number as f64;
            let (fz, fr) = (z - z.floor(), out - out.floor());
            let lens = 4.0 * fz * (1.0 - fz);
            let ends = smoothstep(0.0, 0.15, fr.min(1.0 - fr));
            let thick = wide * (0.4 + 0.6 * lens);
            let body =
                (1.0 - smoothstep(0.3 * thick, thick, off)) * ends * smoothstep(0.0, 0.3, lens);
            most = most.max(body * (0.35 + 0.65 * part(32)) * RAY.0 / wide);
        }
        // Rays lower than the footprint are seen as their mean.
        most
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
