//! Hairline splits in wood: thin gaps along the grain, most of them along rays, some along rings. Torn wood is full of them, and
//! they run on from the broken face into slabs and splinters.

use super::mix::visible_detail;
use super::wood::WoodAppearance;
use crate::noise::{hash, smoothstep, unit};
use crate::rings::{StemAddress, periodic_cells};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Distance between places where a split may be, and the length of one along the grain, m.
const CELL: f64 = 2.6e-3;
const LENGTH: f64 = 26e-3;
/// Share of those places that have one, and of the splits the share that follows rays.
const SHARE: f64 = 0.6;
const RADIAL_SHARE: f64 = 0.72;
/// Half the width of a split where it gapes most: the least, and how much wider some are, m.
const HALF_WIDTH: (f64, f64) = (0.025e-3, 0.075e-3);
/// How far a split wanders to the sides along its length, m.
const WANDER: f64 = 0.22e-3;
/// Depth of its groove in half widths: what is deeper is dark.
const DEPTH_HALF_WIDTHS: f64 = 1.1;

/// Sines of the angle between a gap and a surface between which it begins to show.
const LYING: (f64, f64) = (0.3, 0.6);

// Purpose in the hash.
const SPLIT: u64 = 0x5c;

/// A split at a point.
#[derive(Default)]
pub(super) struct Split {
    /// How much of it is in the gap, 0 to 1, averaged over the footprint.
    pub gap: f64,
    /// Relief, m.
    pub height: f64,
    /// Its slope.
    pub slope: DVec3,
}

impl WoodAppearance {
    /// Returns how a split shows at a place of a surface with the normal `facing` in the section.
    pub(super) fn split(
        &self,
        at: &StemAddress,
        (place, facing): (DVec3, DVec2),
        footprint: f64,
    ) -> Split {
        let visible = visible_detail(0.4 * CELL, footprint);
        if visible == 0.0 || at.rho > self.phloem || at.rho < self.pith {
            return Split::default();
        }
        let (x, y) = (place.x / CELL, place.y / CELL);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let seed = self.seed ^ SPLIT;
        let (length, period) = periodic_cells(LENGTH, self.period);
        let z = place.z / length + unit(seed, i, j, -1);
        let level = match period {
            0 => z.floor() as i64,
            period => (z.floor() as i64).rem_euclid(period),
        };
        let h = hash(seed, i, j, level);
        let part = |shift: u32| ((h >> shift) & 0x3ff) as f64 / 1024.0;
        if part(0) > SHARE {
            return Split::default();
        }
        let outwards = at.across.normalize_or(DVec2::X);
        let lean = DVec2::from_angle(0.5 * (part(10) - 0.5));
        let along = match part(20) < RADIAL_SHARE {
            true => outwards.rotate(lean),
            false => outwards.perp().rotate(lean),
        };
        let normal = along.perp();
        // What lies in a gap would be a dark patch.
        let crossing = match facing.try_normalize() {
            Some(facing) => smoothstep(LYING.0, LYING.1, facing.perp_dot(normal).abs()),
            None => 1.0,
        };
        let f = z - z.floor();
        let wave = |turns: f64, start: f64| libm::sin(TAU * (turns * f + start));
        let wander = WANDER * (wave(1.0, part(30)) + 0.45 * wave(3.0, part(40)));
        let from = DVec2::new(x - i as f64 - 0.5, y - j as f64 - 0.5) * CELL;
        let off = from.dot(normal) - 0.3 * CELL * (part(50) - 0.5) - wander;
        let lens = 4.0 * f * (1.0 - f);
        let reach = 0.5 * CELL * (0.6 + 0.4 * part(30));
        let ends = 1.0 - smoothstep(0.6 * reach, reach, from.dot(along).abs());
        let wide = part(40);
        let half = (HALF_WIDTH.0 + HALF_WIDTH.1 * wide * wide) * lens * ends;
        let shown = half.max(0.5 * footprint);
        let gap = 1.0 - smoothstep(0.35 * shown, shown, off.abs());
        if half <= 0.0 || gap == 0.0 {
            return Split::default();
        }
        let share = half / shown * visible * crossing;
        let depth = DEPTH_HALF_WIDTHS * half * share;
        // The slope of the smooth step between the edges of the gap.
        let t = ((off.abs() / shown - 0.35) / 0.65).clamp(0.0, 1.0);
        let rise = depth * 6.0 * t * (1.0 - t) / (0.65 * shown) * off.signum();
        Split {
            gap: gap * share,
            height: -depth * gap,
            slope: (normal * rise).extend(0.0),
        }
    }
}
