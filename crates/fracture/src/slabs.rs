//! Slabs: the coarsest pieces of a torn face, bounded by rings and rays.

use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::TAU;

/// What all bundles of a slab share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Height, −1 to 1, mean about 0.
    pub height: f64,
    /// Slope across the section, per radius.
    pub slant: DVec2,
    /// How much its slivers differ, about 1.
    pub splinters: f64,
}

/// A slab's part of the section: ring coordinates and angles (rad, counted from the turn of the layout).
#[derive(Debug, Clone, Copy)]
struct Region {
    rho: (f64, f64),
    phi: (f64, f64),
    slab: Slab,
}

/// The slabs of a section.
#[derive(Debug, Clone)]
pub struct Slabs {
    regions: Vec<Region>,
    turn: f64,
}

const SEED: u64 = 0x51ab;

impl Slabs {
    /// Parts the section into `count` slabs by rings and rays, the largest first.
    pub fn new(count: usize, seed: u64) -> Self {
        let seed = seed ^ SEED << 20;
        let random = |n: usize, what: i64| noise::unit(seed, n as i64, what, 0);
        let flat = Slab {
            height: 0.0,
            slant: DVec2::ZERO,
            splinters: 1.0,
        };
        let mut regions = vec![Region {
            rho: (0.0, 1.0),
            phi: (0.0, TAU),
            slab: flat,
        }];
        let area = |r: &Region| (r.rho.1 * r.rho.1 - r.rho.0 * r.rho.0) * (r.phi.1 - r.phi.0);
        while regions.len() < count {
            let n = regions.len();
            let mut largest = 0;
            for i in 1..n {
                if area(&regions[i]) > area(&regions[largest]) {
                    largest = i;
                }
            }
            let r = regions[largest];
            let at = 0.3 + 0.4 * random(n, 0);
            let width = (r.phi.1 - r.phi.0) * (r.rho.0 + r.rho.1) / 2.0;
            let mut other = r;
            if width > 1.6 * (r.rho.1 - r.rho.0) {
                let ray = r.phi.0 + (r.phi.1 - r.phi.0) * at;
                regions[largest].phi.1 = ray;
                other.phi.0 = ray;
            } else {
                let ring = r.rho.0 + (r.rho.1 - r.rho.0) * at;
                regions[largest].rho.1 = ring;
                other.rho.0 = ring;
            }
            regions.push(other);
        }
        for (n, r) in regions.iter_mut().enumerate() {
            let unit = |what: i64| 2.0 * random(n, what) - 1.0;
            r.slab = Slab {
                height: if count == 1 { 0.0 } else { unit(1) },
                slant: DVec2::new(unit(2), unit(3)) * 0.45,
                splinters: 0.4 + 1.2 * random(n, 4),
            };
        }
        Slabs {
            regions,
            turn: TAU * random(0, 9),
        }
    }

    /// The slab at a ring coordinate and angle (rad). Its borders are ragged by a few slivers.
    pub fn at(&self, rho: f64, phi: f64) -> Slab {
        let place = (phi - self.turn) / TAU;
        let phi = (place - place.floor()) * TAU;
        self.regions
            .iter()
            .find(|r| rho >= r.rho.0 && rho <= r.rho.1 && phi >= r.phi.0 && phi <= r.phi.1)
            .map_or(self.regions[0].slab, |r| r.slab)
    }
}
