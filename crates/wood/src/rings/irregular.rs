//! Rings as they grow: years differ, good years come together, and rings wander along the grain. The rings of the look of
//! wood, made from nothing but a seed.

use super::address::StemAddress;
use super::source::{RingPart, RingPosition, RingSource};
use crate::noise::{gradient_3d, smoothstep, unit, value_1d};
use crate::tissue::Zone;
use glam::DVec3;

/// In the hash: what ring widths and the wandering of rings are drawn for.
const RING: u64 = 0x52;
const WANDER: u64 = 0x57;
/// Width of the innermost rings relative to that of the outermost: young trees grow wider rings.
pub(super) const INNERMOST_DENSITY: f64 = 0.78;
const DENSITY_GAIN: f64 = 0.22;
/// How far the edge of a ring is shifted, in rings: year by year, and over runs of good and bad years.
const YEARLY_SHIFT: f64 = 0.34;
const RUN_SHIFT: f64 = 0.6;
const RUN_YEARS: f64 = 4.0;
/// How far rings wander, in rings: over half the radius, and finely.
const SLOW_WANDER: f64 = 0.35;
const FINE_WANDER: f64 = 0.07;
/// Fine wandering: waves per metre across the grain, and length (m) along it.
const FINE_WAVES: f64 = 260.0;
const FINE_LENGTH: f64 = 0.08;

/// Ring coordinates at which tissues begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueEdges {
    /// Where the pith ends.
    pub pith: f64,
    /// Where the heartwood ends; 0 for none.
    pub heartwood: f64,
    /// Where the inner bark begins.
    pub phloem: f64,
    /// Where the outer bark begins.
    pub cork: f64,
}

impl TissueEdges {
    /// The tissue at a ring coordinate.
    pub fn zone_at(&self, rho: f64) -> Zone {
        if rho >= self.cork {
            Zone::Bark
        } else if rho >= self.phloem {
            Zone::Phloem
        } else if rho < self.pith {
            Zone::Pith
        } else if rho < self.heartwood {
            Zone::Heartwood
        } else {
            Zone::Sapwood
        }
    }
}

/// Rings whose widths differ from year to year and whose edges wander.
#[derive(Debug, Clone, PartialEq)]
pub struct IrregularRings {
    /// Mean number of rings between pith and inner bark.
    pub count: f64,
    /// Part of each ring's width that is latewood, 0 to 1.
    pub latewood: f64,
    /// Radius of the section with its bark, m.
    pub radius: f64,
    /// Where tissues begin; rings end where the inner bark begins.
    pub tissue: TissueEdges,
    /// Seed of everything irregular.
    pub seed: u64,
    /// Length along the grain (m) after which rings repeat; `None` for wood as it grows.
    pub period: Option<f64>,
}

/// A number from 0 to 1 that belongs to a year: how marked its latewood is.
pub(crate) fn latewood_strength(seed: u64, ring: i64) -> f64 {
    unit(seed ^ RING, ring - 1, 2, 0)
}

/// Outer edge of a ring, in mean ring widths.
pub(super) fn year_edge(seed: u64, ring: i64) -> f64 {
    let seed = seed ^ RING;
    ring as f64
        + YEARLY_SHIFT * (unit(seed, ring, 1, 0) - 0.5)
        + RUN_SHIFT * value_1d(seed, ring as f64 / RUN_YEARS)
}

/// The length of a cell along the grain that fits a period, and the number of cells in it (0: no period).
pub(crate) fn periodic_cells(length: f64, period: Option<f64>) -> (f64, i64) {
    match period {
        Some(period) if period > 0.0 => {
            let number = (period / length).round().max(1.0);
            (period / number, number as i64)
        }
        _ => (length, 0),
    }
}

impl IrregularRings {
    /// How far rings are shifted at a place, in mean ring widths, where the even count is `t`.
    fn wander(&self, at: &StemAddress, t: f64) -> f64 {
        let place = DVec3::new(at.across.x, at.across.y, at.along);
        let wide = 0.5 * self.radius;
        let (long, period) = periodic_cells(8.0 * self.radius, self.period);
        let slow = place * DVec3::new(1.0 / wide, 1.0 / wide, 1.0 / long);
        let (fine_long, fine_period) = periodic_cells(FINE_LENGTH, self.period);
        let fine = place * DVec3::new(FINE_WAVES, FINE_WAVES, 1.0 / fine_long);
        let seed = self.seed ^ WANDER;
        let wander = SLOW_WANDER * gradient_3d(seed, slow, period).0
            + FINE_WANDER * gradient_3d(seed ^ 256, fine, fine_period).0;
        wander * smoothstep(0.0, 1.5, t)
    }
}

impl RingSource for IrregularRings {
    fn ring_count(&self) -> usize {
        self.count.round().max(0.0) as usize
    }

    fn ring_at(&self, at: &StemAddress) -> Option<RingPosition> {
        if self.count < 0.5 || at.rho >= self.tissue.phloem {
            return None;
        }
        let r = (at.rho / self.tissue.phloem).clamp(0.0, 1.0);
        let even = r * (INNERMOST_DENSITY + DENSITY_GAIN * r) * self.count;
        let t = even + self.wander(at, even);
        let mut below = t.floor() as i64;
        while year_edge(self.seed, below) > t {
            below -= 1;
        }
        while year_edge(self.seed, below + 1) <= t {
            below += 1;
        }
        let (inner, outer) = (year_edge(self.seed, below), year_edge(self.seed, below + 1));
        let fraction = (t - inner) / (outer - inner);
        // Mean ring widths per ring coordinate: the derivative of `even`.
        let density =
            self.count * (INNERMOST_DENSITY + 2.0 * DENSITY_GAIN * r) / self.tissue.phloem;
        let part = if fraction > 1.0 - self.latewood {
            RingPart::Latewood
        } else {
            RingPart::Earlywood
        };
        Some(RingPosition {
            ring: below + 1,
            fraction,
            width: (outer - inner) / density,
            part,
            tissue: self.tissue.zone_at(at.rho),
        })
    }
}
