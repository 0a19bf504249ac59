//! The relief of torn wood on a fibrous face, in three orders: slabs, the slivers they split into, and the fibres that
//! stand out of those.
//!
//! A sliver is a group of bundles side by side in a few rings that ended together: one outline runs over all of them,
//! so that splinters are flat, wide along the ring, and only their tips are ragged. All heights are ratios to the
//! stem's radius.

use crate::ends::{End, Ends, Rim, wandered};
use crate::field::HeightField;
use crate::heights::{HeightCache, Maker, Walks, unit};
use crate::layout::{Bundle, Bundles};
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::Zone;
use std::sync::Arc;

/// Height of one fibre bundle.
pub(crate) struct Level {
    /// Before the outlines of its sliver and its own end.
    base: f64,
    /// Height of its thorn, 0 for none.
    pub thorn: f64,
    /// How ragged its end is.
    fibre: f64,
    middle: DVec2,
    slant: DVec2,
    /// Height of the sliver's outline, below zero where it hangs out of the upper piece.
    sliver: f64,
    /// Height of the bundle's own.
    blade: f64,
    bark: bool,
}

/// Bundles whose ends are as torn wood.
pub(crate) struct Torn<'a> {
    maker: &'a Maker<'a>,
    bundles: &'a Bundles,
    pub ends: Arc<Ends>,
    /// Height of the wood under each strip of bark, as far as the bark follows it.
    under_bark: Vec<f64>,
    /// Ring coordinate from which on wood is inner bark.
    inner_bark: f64,
}

/// A long blade is so many times as long as it is wide, at most.
const SLENDER: f64 = 9.0;

impl<'a> Torn<'a> {
    pub fn new(
        maker: &'a Maker<'a>,
        bundles: &'a Bundles,
        walks: &mut Walks,
        cache: &mut HeightCache,
    ) -> Self {
        let p = maker.p;
        let stem = (maker.setting.radius, maker.setting.pith);
        let ends = Ends::cached(bundles, p, walks, stem, cache);
        let mut torn = Torn {
            maker,
            bundles,
            under_bark: Vec::new(),
            inner_bark: ends.wood.map_or(2.0, |wood| wood - p.phloem_proportion),
            ends,
        };
        if torn.ends.wood.is_some() {
            let strips = 0..torn.ends.strips.count();
            torn.under_bark = strips.map(|s| torn.under_bark(walks, s)).collect();
        }
        torn
    }

    fn random(&self, purpose: u64, a: i64, b: i64) -> f64 {
        noise::unit(self.maker.seed(purpose), a, b, 0)
    }

    /// How far a place is from the edge of the compression shelf, whose raggedness there is given, in radii: below 0 on
    /// the shelf.
    fn off_shelf(&self, ragged: f64, unit: DVec2, at: DVec2) -> f64 {
        let place = self.ends.across(unit, at);
        let ragged = 0.16 * ragged;
        place.dot(self.maker.tension) + 1.0 - 2.0 * self.maker.p.compression_shelf + ragged
    }

    /// How much a place is torn rather than crushed, 0 to 1.
    fn torn(&self, shelf: f64) -> f64 {
        if self.maker.p.compression_shelf > 0.0 {
            // Torn wood stands free within a tenth of a radius of the shelf's edge.
            noise::smoothstep(-0.05, 0.1, shelf)
        } else {
            1.0
        }
    }

    pub fn level(&self, walks: &mut Walks, index: usize) -> Level {
        let bundle = &self.bundles.bundles[index];
        let unit = unit(bundle.rho.min(1.0), bundle.phi);
        let middle = self.ends.middle(self.bundles, index, unit);
        let end = &self.ends.bundles[index];
        if bundle.bark {
            self.bark_level(walks, bundle, end, middle)
        } else {
            self.wood_level(walks, (index, end), unit, middle)
        }
    }

    /// Height of the wood under a strip of bark, as far as the bark follows it.
    fn under_bark(&self, walks: &mut Walks, strip: usize) -> f64 {
        let p = self.maker.p;
        let phi = self.ends.strips.middle(strip);
        let at = unit(1.0, phi);
        let place = self.ends.pith + at * self.maker.setting.radius;
        let ragged = walks.shelf.at(self.ends.across(at, place) * 3.0);
        let torn = self.torn(self.off_shelf(ragged, at, place));
        let wandered = wandered(walks, phi, at * 0.95);
        let slab = self.ends.slabs.at(0.95, wandered).1;
        let wood = 0.7 * p.slab_height * self.maker.setting.relief * torn * slab;
        self.maker.stepped(at, 0.99, phi) + wood + p.bark_offset
    }

    /// The level of a bundle that ends at a field.
    pub fn level_of_field(&self, field: &HeightField, index: usize) -> Level {
        let bundle = &self.bundles.bundles[index];
        let unit = unit(bundle.rho.min(1.0), bundle.phi);
        let fibre = self.maker.setting.relief * self.maker.p.fibre_height;
        Level {
            base: field.at(bundle.rho, bundle.phi) / self.maker.setting.radius,
            thorn: 0.0,
            fibre: if bundle.bark { 0.0 } else { fibre },
            middle: self.ends.middle(self.bundles, index, unit),
            slant: DVec2::ZERO,
            sliver: 0.0,
            blade: if bundle.bark { 0.0 } else { fibre },
            bark: bundle.bark,
        }
    }

    fn bark_level(&self, walks: &mut Walks, bundle: &Bundle, end: &End, middle: DVec2) -> Level {
        let p = self.maker.p;
        let at = unit(1.0, bundle.phi);
        let noise = self
            .maker
            .noise(walks, at, p.zone(Zone::Bark), bundle_key(bundle));
        Level {
            base: self.under_bark[end.strip as usize] + 0.3 * noise,
            thorn: 0.0,
            fibre: 0.0,
            middle,
            slant: self.maker.tilt,
            sliver: 0.0,
            blade: 0.0,
            bark: true,
        }
    }

    fn wood_level(
        &self,
        walks: &mut Walks,
        (index, end): (usize, &End),
        at: DVec2,
        middle: DVec2,
    ) -> Level {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let (maker, p, relief) = (self.maker, self.maker.p, self.maker.setting.relief);
        let key = index as i64;
        let zone = p.proportions().zone_at(rho, 0.0);
        let across = (middle - self.ends.pith) / maker.setting.radius;
        let published = maker.published(walks, (across, at), (rho, bundle.phi), zone, key);
        let shelf = self.off_shelf(end.shelf, at, middle);
        let torn = self.torn(shelf);
        let slab = self.ends.slabs.slab(end.slab as usize);
        // Slivers run up a slab like the treads of a stair.
        let (own_height, shared) = end.slab_heights;
        let slab_height = 0.35 * own_height + 0.65 * shared;
        let [short, long, high] = end.of_sliver;
        let slab_height = slab_height * (1.0 - 0.75 * short * short);
        // Both halves keep their splinters: every other slab tears downwards.
        let up = if slab.height > 0.0 { 1.0 } else { -1.0 };
        // Short ones are common, long ones rare.
        let length = long * long * long;
        let length = p.sliver_height * slab.splinters * length * relief * torn;
        let (width, _) = self.ends.slivers.region(end.sliver as usize).size();
        let outline =
            (0.9 * length + 0.7 * p.sliver_height * relief * torn * high).min(SLENDER * width);
        // Fibres: most end with their sliver, a few stand out of it far.
        let [far, blade, off] = end.fibres;
        let fibre = relief * p.fibre_height * (0.25 + 0.75 * torn);
        let blade =
            fibre * (0.6 + 5.0 * far * far * far * far * torn) + 0.25 * torn * length * blade;
        let crushed = p.compression_height * (end.crushed[0] - 0.5);
        let slant = slab.slant * (torn * relief * p.slab_height);
        let torn_height = relief * p.slab_height * slab_height
            + up * (1.6 * length - 0.4 * p.sliver_height * relief * torn)
            + p.step_height * end.step
            + fibre * (off - 0.5);
        let mut base = published + torn * torn_height + (1.0 - torn) * crushed + slant.dot(at);
        base -= self.split(shelf, end.crushed[1]);
        base = self.with_bark(base, end, rho);
        let width = 2.0 * bundle.half_width * rho;
        Level {
            base,
            thorn: self.thorn(rho, bundle.phi, zone, key, end.sliver),
            fibre,
            middle,
            slant: slant + maker.tilt,
            sliver: up * outline,
            blade: up * blade.min(3.0 * SLENDER * width),
            bark: false,
        }
    }

    /// Inner bark tears in strings, of which some come off with the bark.
    fn with_bark(&self, base: f64, end: &End, rho: f64) -> f64 {
        if rho <= self.inner_bark {
            return base;
        }
        let [goes, long] = end.string;
        let depth = ((rho - self.inner_bark) / self.maker.p.phloem_proportion.max(1e-6)).min(1.0);
        let with = noise::smoothstep(0.35, 0.75, goes * (0.55 + 0.75 * depth));
        let bark = self.under_bark[end.strip as usize]
            + self.maker.p.bark_height * (end.edge + 0.5 * (long - 0.6));
        base + (bark - base) * with
    }

    /// Length of a bundle's thorn. Thorns stand in groups: a sliver has several or none, of about one length.
    fn thorn(&self, rho: f64, phi: f64, zone: Zone, key: i64, sliver: u32) -> f64 {
        self.maker
            .thorn(rho, phi, zone, |purpose, length, probability| {
                // Both draws together meet as often as one would.
                let each = probability.max(0.0).sqrt();
                let group = |b: i64| self.random(purpose, i64::from(sliver), b);
                if group(5) < each && self.random(purpose, key, 6) < each {
                    length * (0.55 * group(7) + 0.45 * self.random(purpose, key, 8))
                } else {
                    0.0
                }
            })
    }

    /// Depth of the split between the tension and the compression side.
    fn split(&self, shelf: f64, deep: f64) -> f64 {
        const WIDTH: f64 = 0.05;
        let near = 1.0 - (shelf - 0.02).abs() / WIDTH;
        if self.maker.p.split <= 0.0 || near <= 0.0 || self.maker.p.compression_shelf <= 0.0 {
            return 0.0;
        }
        self.maker.p.split * near * (0.4 + 0.6 * deep)
    }

    /// Height of a bundle's end at a node of it.
    pub fn at(&self, level: &Level, rim: &Rim) -> f64 {
        let bundles = self.bundles;
        let radius = self.maker.setting.radius;
        if level.bark {
            // Nodes beyond the bark repeat the heights of those below them, so that the edge runs straight outwards.
            let direction = bundles.directions[rim.node as usize];
            let out = direction * radius - (level.middle - self.ends.pith);
            let edge = self.maker.p.bark_height * rim.over;
            return level.base + edge + out.dot(level.slant) / radius;
        }
        let at = bundles.layout.nodes[rim.node as usize];
        let slope = level.slant.dot(at - level.middle) / radius;
        let height = level.base + slope + level.sliver * rim.over;
        if level.thorn > 0.0 {
            // A slender prism, and on it a pyramid that leans to one side.
            let shaft = self.maker.p.thorn_shaft;
            let apex = rim.node == bundles.tips[rim.cell as usize];
            let up = if apex {
                1.0
            } else {
                (0.85 * rim.own + 0.15 * rim.ragged).min(1.0)
            };
            return height + level.thorn * (shaft + (1.0 - shaft) * up);
        }
        height + level.blade * rim.own + level.fibre * (rim.ragged - 0.5)
    }
}

fn bundle_key(bundle: &Bundle) -> i64 {
    (1 << 40) + i64::from(bundle.sector)
}
