//! The figures in wood as bodies in space: streaks of fibres, annual rings, heartwood, vessels and rays. Each fades to
//! its mean where the footprint grows beyond it.

use super::{WoodAppearance, WoodPoint, left_of, mix_scalar};
use crate::noise::{hash, line, smoothstep, space, unit};
use glam::DVec3;
use std::f64::consts::TAU;

/// Fibre bundles, slivers and fibres: width (m), share of the brightness, relief (m). Lengths are [`STRETCH`] widths.
const STREAKS: [(f64, f64, f64); 4] = [
    (5.0e-3, 0.10, 120e-6),
    (1.3e-3, 0.17, 90e-6),
    (0.35e-3, 0.24, 48e-6),
    (0.10e-3, 0.24, 16e-6),
];
/// Length of a streak in widths: fibres are 40 to 100 times longer than wide.
const STRETCH: f64 = 40.0;
/// Width of a ray, m, and the distance between rays around the stem.
const RAY: (f64, f64) = (0.12e-3, 1.1e-3);
/// Length of a ray from the pith outwards before it stops, m.
const RAY_LENGTH: f64 = 14e-3;
/// Mean of all rays over the wood, the same at every radius because they keep their distance.
const RAY_MEAN: f64 = 0.046;
/// Length of a vessel's visible groove, in diameters.
const VESSEL_LENGTH: f64 = 130.0;

// What for, in the hash: each figure has its own numbers.
const RING: u64 = 0x52;
const WANDER: u64 = 0x57;
const STREAK: u64 = 0x53;
const HEART: u64 = 0x48;
const VESSEL: u64 = 0x56;
const RAYS: u64 = 0x59;

impl WoodAppearance {
    /// The length of a cell along the grain that fits the period, and the number of cells in it (0: no period).
    pub(super) fn cells(&self, length: f64) -> (f64, i64) {
        match self.period {
            Some(period) if period > 0.0 => {
                let number = (period / length).round().max(1.0);
                (period / number, number as i64)
            }
            _ => (length, 0),
        }
    }

    /// Streaks of fibres: change of brightness, relief (m) and its slope.
    pub(super) fn streaks(&self, place: DVec3, footprint: f64) -> (f64, f64, DVec3) {
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
    pub(super) fn ring(&self, at: &WoodPoint, place: DVec3, footprint: f64) -> (f64, f64, f64) {
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
    pub(super) fn heart(&self, at: &WoodPoint, place: DVec3) -> f64 {
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
    pub(super) fn vessel(&self, place: DVec3, early: f64, footprint: f64) -> f64 {
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

    /// How much a place lies in a ray, 0 to 1, averaged over the footprint. Rays are thin sheets from the pith outwards, of limited height; where
    /// the stem has grown wide new ones begin, so that they keep their distance.
    pub(super) fn ray(&self, at: &WoodPoint, footprint: f64) -> f64 {
        let radius = at.across.length();
        if self.rays <= 0.0 || at.ring > self.phloem || radius < 1e-6 {
            return 0.0;
        }
        // Averaged over the space between rays, or over their height, they are an even tint.
        let keep = left_of((0.5 * RAY.1).min(self.ray_height), footprint);
        if keep == 0.0 {
            return RAY_MEAN;
        }
        let wide = RAY.0.max(footprint);
        let wanted = TAU * radius / RAY.1;
        // The power of two below the wanted number of sectors. Outwards its rays give way to those of the next, so that
        // the number of both together is the wanted one.
        let mut sectors: i64 = 4;
        while (sectors * 2) as f64 <= wanted && sectors < 1 << 20 {
            sectors *= 2;
        }
        let mut most = 0.0f64;
        for (number, share) in [
            (sectors, 2.0 - wanted / sectors as f64),
            (sectors * 2, wanted / sectors as f64 - 1.0),
        ] {
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
        mix_scalar(RAY_MEAN, most, keep)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn rays_fade_to_their_mean_at_every_radius() {
        let look = WoodAppearance {
            radius: 0.2,
            ..WoodAppearance::hardwood()
        };
        for radius in [0.02, 0.033, 0.05, 0.1] {
            let mean = |footprint: f64| {
                let (around, along) = (1500, 60);
                let mut sum = 0.0;
                for i in 0..around * along {
                    let (k, j) = (f64::from(i / along), f64::from(i % along));
                    let angle = TAU * (k + 0.5) / f64::from(around);
                    let r = radius * (1.0 + 0.05 * (k * 0.618).fract());
                    let at = WoodPoint {
                        ring: r / look.radius,
                        angle,
                        across: r * DVec2::from_angle(angle),
                        along: j * 0.41e-3,
                        end_grain: 0.0,
                    };
                    sum += look.ray(&at, footprint);
                }
                sum / f64::from(around * along)
            };
            let fine = mean(1e-6);
            for footprint in [1e-4, 3e-4, 1e-3, 1e-2] {
                let coarse = mean(footprint);
                assert!(
                    (coarse / fine - 1.0).abs() < 0.12,
                    "at {radius} m: fine {fine}, over {footprint} m {coarse}"
                );
            }
        }
    }
}
