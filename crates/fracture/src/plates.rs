//! The plates in which brittle wood breaks across: smooth, tilted and slightly hollow, of three sizes, with sheer edges. The small
//! ones are stubs on some of the large ones.

use crate::parameters::BreakParameters;
use glam::DVec2;
use greenstick_wood::noise;

/// Plates of one size.
struct Size {
    /// How many follow each other over a radius.
    per_radius: f64,
    /// Share of them that stand out or are sunk.
    share: f64,
    /// Greatest height.
    height: f64,
    /// Greatest slope, height per radius.
    slope: f64,
    /// Curvature, height per radius squared, at most.
    hollow: f64,
}

/// Heights are in those of the steps of brittle wood. Large plates have sheer edges along the bundles there.
const LARGE: Size = Size {
    per_radius: 1.1,
    share: 1.0,
    height: 0.3,
    slope: 2.0,
    hollow: 1.6,
};
/// The edges of smaller ones run out over a bundle.
const SMALL: [Size; 2] = [
    Size {
        per_radius: 4.2,
        share: 0.7,
        height: 0.034,
        slope: 0.6,
        hollow: 0.0,
    },
    Size {
        per_radius: 9.0,
        share: 0.4,
        height: 0.02,
        slope: 0.6,
        hollow: 0.0,
    },
];
/// How much wider plates are along the ring than across it: they run through rings rather than along them.
const FLATNESS: f64 = 0.8;
/// How far the edges of plates wind, and how often over a plate's width, in those widths.
const WINDING: (f64, f64) = (0.3, 2.3);

/// Heights of the steps of brittle wood over those by which slabs and slivers differ between which wood splinters and is brittle.
const BRITTLE_STEPS: (f64, f64) = (0.18, 0.34);

/// Returns how brittle wood is, 0 where it splinters to 1: where its slabs and slivers are no higher than its steps, the face is one
/// of plates.
pub(crate) fn brittleness(p: &BreakParameters) -> f64 {
    let (from, to) = BRITTLE_STEPS;
    let torn = p.slab_height + p.sliver_height;
    noise::smoothstep(from, to, p.step_height / torn.max(1e-9))
}

/// The height of the plates at a bundle as a function of the place: `height` + `slope` · p + `hollow` p².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Plate {
    height: f64,
    slope: DVec2,
    hollow: f64,
}

impl Plate {
    /// Returns the large plate at a point, radii from the pith.
    pub fn large(seed: u64, at: DVec2) -> Plate {
        let mut sum = Plate::default();
        sum.add(seed, &LARGE, at);
        sum
    }

    /// Returns the height of the smaller plates at a point, radii from the pith.
    pub fn small(seed: u64, at: DVec2) -> f64 {
        let mut sum = Plate::default();
        for (seed, size) in (seed + 1..).zip(&SMALL) {
            sum.add(seed, size, at);
        }
        sum.at(at)
    }

    fn add(&mut self, seed: u64, size: &Size, at: DVec2) {
        let out = at.normalize_or_zero();
        let winds =
            |k: u64| noise::gradient_2d(seed + (k << 40), at * (size.per_radius * WINDING.1));
        let at = at + DVec2::new(winds(1), winds(2)) * (WINDING.0 / size.per_radius);
        let home = (at * size.per_radius).floor();
        let mut nearest = (f64::INFINITY, DVec2::ZERO, (0, 0));
        for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
            let (x, y) = (home.x as i64 + i, home.y as i64 + j);
            let random = |what: i64| noise::unit(seed, x, y, what);
            let middle = DVec2::new(x as f64 + random(0), y as f64 + random(1)) / size.per_radius;
            let off = at - middle;
            let across = FLATNESS * off.dot(out);
            let distance = across * across + off.perp_dot(out) * off.perp_dot(out);
            if distance < nearest.0 {
                nearest = (distance, middle, (x, y));
            }
        }
        let (_, middle, (x, y)) = nearest;
        let random = |what: i64| noise::unit(seed, x, y, what);
        if random(2) >= size.share {
            return;
        }
        let even = |what: i64| 2.0 * random(what) - 1.0;
        let slope = size.slope * DVec2::new(even(4), even(5));
        let hollow = size.hollow * even(6);
        self.height += size.height * even(3) - slope.dot(middle) + hollow * middle.length_squared();
        self.slope += slope - 2.0 * hollow * middle;
        self.hollow += hollow;
    }

    /// Returns the height at a point, radii from the pith.
    pub fn at(&self, p: DVec2) -> f64 {
        self.height + self.slope.dot(p) + self.hollow * p.length_squared()
    }
}
