//! The figures in wood as bodies in space: streaks of fibres, annual rings, heartwood, vessels and rays. Each fades to
//! its mean where the footprint grows beyond it.

use super::mix::{mix_scalar, visible_detail};
use super::noises::{HEARTWOOD_NOISE, STREAK_NOISES};
use super::wood::WoodAppearance;
use crate::noise::{Noises, hash, smoothstep, unit};
use crate::rings::{RingSource, StemAddress, latewood_strength, periodic_cells};
use glam::DVec3;
use std::f64::consts::TAU;

/// Streaks of one size.
struct StreakSize {
    /// m.
    width: f64,
    /// Length in widths.
    stretch: f64,
    /// Share of the brightness.
    share: f64,
    /// m.
    relief: f64,
}

/// Slow changes along and across the wood, and single fibres; what lies between are bundles with edges.
const STREAKS: [StreakSize; STREAK_NOISES] = [
    StreakSize {
        width: 5.0e-3,
        stretch: 28.0,
        share: 0.09,
        relief: 120e-6,
    },
    StreakSize {
        width: 1.3e-3,
        stretch: 32.0,
        share: 0.10,
        relief: 60e-6,
    },
    StreakSize {
        width: 0.09e-3,
        stretch: 90.0,
        share: 0.20,
        relief: 18e-6,
    },
];
/// How far fibres wave to the sides, and the length of a wave along them, m: no grain is as straight as a ruler.
const WAVES: [(f64, f64); 2] = [(0.25e-3, 75e-3), (0.02e-3, 17e-3)];
/// Width of a ray and the distance between rays around the stem, m.
const RAY_WIDTH: f64 = 0.12e-3;
const RAY_DISTANCE: f64 = 1.1e-3;
/// Length of a ray from the pith outwards before it stops, m.
const RAY_LENGTH: f64 = 14e-3;
/// Mean of all rays over the wood, the same at every radius because they keep their distance.
const MEAN_RAY: f64 = 0.046;
/// Mean of all vessels over wood that is full of them.
const MEAN_VESSEL: f64 = 0.22;
/// Length of a vessel's visible groove, in diameters.
const VESSEL_LENGTH_DIAMETERS: f64 = 130.0;
/// How far the edge of the heartwood wanders, and how far it can lie from its mean, in ring coordinates.
const HEARTWOOD_WANDER: f64 = 0.07;
const MAX_HEARTWOOD_SHIFT: f64 = 0.15;

// Purposes in the hash: each figure has its own numbers.
const STREAK: u64 = 0x53;
const HEARTWOOD: u64 = 0x48;
const VESSEL: u64 = 0x56;
const RAYS: u64 = 0x59;
const WAVE: u64 = 0x57;

/// Streaks of fibres at a point.
pub(super) struct Streaks {
    /// Change of brightness.
    pub shade: f64,
    /// Relief, m.
    pub height: f64,
    /// Its slope.
    pub slope: DVec3,
}

/// Latewood at a point, averaged over the footprint.
#[derive(Default)]
pub(super) struct Latewood {
    /// 0 to 1.
    pub darkness: f64,
    /// How the darkness rises outwards, 1/m.
    pub slope: f64,
    /// How much the point belongs to the first earlywood of its ring, 0 to 1.
    pub first_earlywood: f64,
}

impl WoodAppearance {
    pub(super) fn streaks(
        &self,
        place: DVec3,
        footprint: f64,
        noises: &mut impl Noises,
    ) -> Streaks {
        let (mut shade, mut height, mut slope) = (0.0, 0.0, DVec3::ZERO);
        for (i, size) in STREAKS.iter().enumerate() {
            let visible = visible_detail(size.width, footprint);
            if visible == 0.0 {
                break;
            }
            let (length, period) = periodic_cells(size.width * size.stretch, self.period);
            let scale = DVec3::new(1.0 / size.width, 1.0 / size.width, 1.0 / length);
            let (v, g) = noises.gradient(
                i,
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
            shade += skewed * size.share * visible;
            height += v * size.relief * visible;
            slope += g * scale * (size.relief * visible);
        }
        Streaks {
            shade,
            height,
            slope,
        }
    }

    /// Where a fibre that waves would be if it were straight.
    pub(super) fn waved(&self, place: DVec3) -> DVec3 {
        let mut straight = place;
        for (i, (width, length)) in WAVES.into_iter().enumerate() {
            let (long, _) = periodic_cells(length, self.period);
            let start = |k: i64| unit(self.seed ^ WAVE, i as i64, k, 0);
            let wave = |k: i64| width * libm::sin(TAU * (place.z / long + start(k)));
            straight += DVec3::new(wave(0), wave(1), 0.0);
        }
        straight
    }

    /// The latewood of the ring at an address.
    pub(super) fn latewood(
        &self,
        rings: &dyn RingSource,
        at: &StemAddress,
        footprint: f64,
    ) -> Latewood {
        let Some(position) = rings.ring_at(at) else {
            return Latewood::default();
        };
        let fraction = position.fraction;
        let ring_width = position.width * self.radius;
        let half = (0.6 * footprint / ring_width).max(0.02);
        // Darkness rises with the square of the place within the latewood; its mean over the footprint is from its
        // integral.
        let start = 1.0 - self.latewood_width.clamp(0.02, 1.0);
        let of_one_ring = (1.0 - start) / 3.0;
        let rise = |f: f64| ((f - f.floor() - start) / (1.0 - start)).max(0.0);
        let integral = |f: f64| {
            let x = rise(f);
            f.floor() * of_one_ring + of_one_ring * x * x * x
        };
        let dark = |f: f64| {
            let x = rise(f);
            x * x
        };
        let mean = (integral(fraction + half) - integral(fraction - half)) / (2.0 * half);
        let slope = (dark(fraction + half) - dark(fraction - half)) / (2.0 * half);
        let strength =
            self.latewood_contrast * (0.55 + 0.45 * latewood_strength(self.seed, position.ring));
        Latewood {
            darkness: mean * strength,
            slope: slope * strength / ring_width,
            first_earlywood: if self.ring_porous {
                1.0 - smoothstep(0.12, 0.34, fraction)
            } else {
                1.0
            },
        }
    }

    /// Share of heartwood, 0 to 1, behind an uneven edge.
    pub(super) fn heartwood_share(
        &self,
        at: &StemAddress,
        place: DVec3,
        noises: &mut impl Noises,
    ) -> f64 {
        if self.heartwood <= 0.0 {
            return 0.0;
        }
        if (at.rho - self.heartwood).abs() > MAX_HEARTWOOD_SHIFT {
            return f64::from(u8::from(at.rho < self.heartwood));
        }
        let wide = 0.4 * self.radius;
        let (long, period) = periodic_cells(10.0 * self.radius, self.period);
        let scale = DVec3::new(1.0 / wide, 1.0 / wide, 1.0 / long);
        let seed = self.seed ^ HEARTWOOD;
        let wander = noises
            .gradient(HEARTWOOD_NOISE, seed, place * scale, period)
            .0;
        let edge = self.heartwood + HEARTWOOD_WANDER * wander;
        1.0 - smoothstep(edge - 0.075, edge + 0.055, at.rho)
    }

    /// How deep a point lies in a vessel, 0 to 1: a dot across the grain, a groove along it.
    pub(super) fn vessel(&self, place: DVec3, first_earlywood: f64, footprint: f64) -> f64 {
        let visible = visible_detail(self.vessel_diameter * 1.6, footprint);
        if self.vessel_diameter <= 0.0 {
            return 0.0;
        }
        let density = if self.ring_porous {
            0.06 + 0.94 * first_earlywood
        } else {
            0.5
        };
        // Vessels too small to be distinguished darken the wood evenly.
        let average = MEAN_VESSEL * density;
        if visible == 0.0 {
            return average;
        }
        let width = self.vessel_diameter * 1.5;
        let (x, y) = (place.x / width, place.y / width);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (length, period) =
            periodic_cells(self.vessel_diameter * VESSEL_LENGTH_DIAMETERS, self.period);
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
            return average * (1.0 - visible);
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
            visible,
        ) * taper
    }

    /// How much a point lies in a ray, 0 to 1, averaged over the footprint. Rays are thin sheets from the pith outwards, of
    /// limited height; where the stem has grown wide new ones begin, so that they keep their distance.
    pub(super) fn ray(&self, at: &StemAddress, footprint: f64) -> f64 {
        let radius = at.across.length();
        if self.ray_contrast <= 0.0 || at.rho > self.phloem || radius < 1e-6 {
            return 0.0;
        }
        // Averaged over the space between rays, or over their height, they are an even tint.
        let visible = visible_detail((0.5 * RAY_DISTANCE).min(self.ray_height), footprint);
        if visible == 0.0 {
            return MEAN_RAY;
        }
        let wanted = TAU * radius / RAY_DISTANCE;
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
            most = most.max(self.ray_of_sectors(at, footprint, number, share));
        }
        mix_scalar(MEAN_RAY, most, visible)
    }

    /// How much a point lies in a ray of those that `number` sectors have, of which a `share` is there.
    fn ray_of_sectors(&self, at: &StemAddress, footprint: f64, number: i64, share: f64) -> f64 {
        let radius = at.across.length();
        let wide = RAY_WIDTH.max(footprint);
        let turn = at.angle / TAU;
        let x = (turn - turn.floor()) * number as f64;
        let sector = (x.floor() as i64).rem_euclid(number);
        let seed = self.seed ^ RAYS ^ ((number as u64) << 8);
        let (length, period) = periodic_cells(self.ray_height, self.period);
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
            return 0.0;
        }
        let off = (x - x.floor() - 0.2 - 0.6 * part(16)).abs() * TAU * radius / number as f64;
        let (fz, fr) = (z - z.floor(), out - out.floor());
        let lens = 4.0 * fz * (1.0 - fz);
        let ends = smoothstep(0.0, 0.15, fr.min(1.0 - fr));
        let thick = wide * (0.4 + 0.6 * lens);
        let body = (1.0 - smoothstep(0.3 * thick, thick, off)) * ends * smoothstep(0.0, 0.3, lens);
        body * (0.35 + 0.65 * part(32)) * RAY_WIDTH / wide
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn rays_fade_to_their_mean_at_every_radius() {
        let wood = WoodAppearance {
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
                    let at = StemAddress {
                        rho: r / wood.radius,
                        angle,
                        across: r * DVec2::from_angle(angle),
                        along: j * 0.41e-3,
                    };
                    sum += wood.ray(&at, footprint);
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
