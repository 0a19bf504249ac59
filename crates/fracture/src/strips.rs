//! Strips of bark: bark tears along its furrows, each strip at a height of its own, some peeled back and some standing
//! over the wood as flaps.

use crate::parameters::BreakParameters;
use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::TAU;

const SEED: u64 = 0xba4c;
/// Share of the strips that stand over the wood as flaps.
const FLAP_SHARE: f64 = 0.24;
/// Share of the strips that are peeled back from the wood.
const PEELED_SHARE: f64 = 0.26;

/// Strips around a stem.
#[derive(Debug, Clone)]
pub(crate) struct Strips {
    /// Angles (rad, ascending) at which they begin, then a turn after the first.
    walls: Vec<f64>,
    /// Height of each over the wood, in bark heights.
    heights: Vec<f64>,
    seed: u64,
}

impl Strips {
    pub fn new(p: &BreakParameters) -> Strips {
        let seed = p.seed ^ SEED << 20;
        let count = p.bark_strips as usize;
        let random = |n: usize, what: i64| noise::unit(seed, n as i64, what, 0);
        let mut walls: Vec<f64> = (0..count)
            .map(|n| TAU * (n as f64 + 0.8 * random(n, 0)) / count as f64)
            .collect();
        walls.push(walls[0] + TAU);
        let height = |n: usize| {
            let (kind, extent) = (random(n, 1), random(n, 2));
            if kind < FLAP_SHARE {
                0.6 + 1.5 * extent * extent
            } else if kind > 1.0 - PEELED_SHARE {
                -0.5 - 1.2 * extent * extent
            } else {
                0.7 * (extent - 0.5)
            }
        };
        Strips {
            walls,
            heights: (0..count).map(height).collect(),
            seed,
        }
    }

    /// Returns the number of strips.
    pub fn count(&self) -> usize {
        self.heights.len()
    }

    /// Returns the number of the strip at an angle (rad).
    pub fn find(&self, phi: f64) -> usize {
        let place = (phi - self.walls[0]) / TAU;
        let phi = self.walls[0] + (place - place.floor()) * TAU;
        let after = self.walls.partition_point(|&w| w <= phi);
        after.clamp(1, self.heights.len()) - 1
    }

    /// Returns the angle (rad) of a strip's middle.
    pub fn middle(&self, strip: usize) -> f64 {
        (self.walls[strip] + self.walls[strip + 1]) / 2.0
    }

    /// Returns the height of the end of a strip at an angle, over the wood under its middle, in bark heights. The end is torn
    /// to one side or to a tongue, and ragged.
    pub fn edge(&self, strip: usize, phi: f64) -> f64 {
        let half = ((self.walls[strip + 1] - self.walls[strip]) / 2.0).max(1e-6);
        let off = phi - self.middle(strip);
        let v = ((off - TAU * (off / TAU).round()) / half).clamp(-1.0, 1.0);
        let random = |what: i64| noise::unit(self.seed, strip as i64, what, 1);
        let height = self.heights[strip];
        // Longer strips narrow more.
        let torn = (0.25 + 0.5 * height.abs()) * (0.5 + random(3));
        let shape = torn_outline(random(4), v);
        let (sin, cos) = libm::sincos(phi);
        // The angle on a circle, so that the edge closes.
        let on = |scale: f64| DVec2::new(cos, sin) * scale;
        let ragged = 0.22 * noise::gradient_2d(self.seed + 1, on(5.0))
            + 0.16 * noise::gradient_2d(self.seed + 2, on(17.0))
            + 0.12 * noise::gradient_2d(self.seed + 3, on(41.0));
        height + torn * (shape - 0.5) + ragged
    }
}

/// Returns the outline of a torn end, 0 to 1, over its width (`v` from −1 to 1). `kind` (0 to 1) selects an end torn to one
/// side, to a point or to two prongs.
pub(crate) fn torn_outline(kind: f64, v: f64) -> f64 {
    let (choice, rest) = (kind * 4.0, kind * 4.0 - (kind * 4.0).floor());
    if choice < 1.2 {
        (1.0 + v) / 2.0
    } else if choice < 2.4 {
        (1.0 - v) / 2.0
    } else if choice < 3.5 {
        let peak = 1.2 * (rest - 0.5);
        1.0 - (v - peak).abs() / (1.0 + peak.abs())
    } else {
        let valley = 0.8 * (rest - 0.5);
        (v - valley).abs() / (1.0 + valley.abs())
    }
}
