//! The relief of torn wood on a fibrous face, in three orders: slabs, the slivers they split into, and the fibres that
//! stand out of those.
//!
//! A sliver is a group of bundles side by side in a few rings that ended together: one outline runs over all of them,
//! so that splinters are flat, wide along the ring, and only their tips are ragged. All heights are ratios to the
//! stem's radius.

use crate::heights::{Maker, Walks, purpose, unit};
use crate::layout::{Bundle, Bundles};
use crate::slabs::{Parts, Slabs, Span};
use crate::strips::{Strips, outline};
use crate::surface::NONE;
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::Zone;

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
    end: End,
}

/// Outline of a bundle's end.
enum End {
    /// Bark: of the strip of this number.
    Strip(usize),
    /// Wood.
    Sliver {
        number: usize,
        /// Height of the sliver's outline, below zero where it hangs out of the upper piece.
        sliver: f64,
        /// Height of the bundle's own.
        blade: f64,
        /// Which outlines.
        kinds: (f64, f64),
        /// Angle of the bundle's middle and half its width, rad.
        phi: (f64, f64),
    },
}

/// Bundles whose ends are as torn wood.
pub(crate) struct Torn<'a> {
    maker: &'a Maker<'a>,
    bundles: &'a Bundles,
    pith: DVec2,
    /// Middle of the section and half its width (m), for sections without a pith in them.
    board: Option<(DVec2, f64)>,
    slabs: Slabs,
    slivers: Parts,
    strips: Strips,
    /// Ring coordinate from which on wood is inner bark.
    inner_bark: f64,
}

/// A long blade is so many times as long as it is wide, at most.
const SLENDER: f64 = 9.0;

impl<'a> Torn<'a> {
    pub fn new(maker: &'a Maker<'a>, bundles: &'a Bundles) -> Self {
        let p = maker.p;
        let span = Span::of(&bundles.bundles);
        let barked = bundles.bundles.iter().any(|b| b.bark);
        let wood = (bundles.bundles.iter().filter(|b| !b.bark))
            .map(|b| b.rho)
            .fold(0.0, f64::max);
        let pith = match (span.phi, bundles.layout.nodes.first()) {
            (None, Some(&node)) => node,
            _ => maker.setting.pith,
        };
        Torn {
            maker,
            bundles,
            pith,
            board: span.phi.map(|_| middle_of(bundles)),
            slabs: Slabs::new(&span, p.slab_count as usize, p.seed),
            slivers: Parts::new(
                &span,
                p.sliver_count as usize,
                p.bundle_aspect,
                maker.seed(purpose::SLIVER),
            ),
            strips: Strips::new(p),
            inner_bark: if barked {
                wood - p.phloem_proportion
            } else {
                2.0
            },
        }
    }

    fn random(&self, purpose: u64, a: i64, b: i64) -> f64 {
        noise::unit(self.maker.seed(purpose), a, b, 0)
    }

    /// How far a place is from the edge of the compression shelf, in radii: below 0 on the shelf.
    fn off_shelf(&self, walks: &mut Walks, unit: DVec2, at: DVec2) -> f64 {
        let place = self
            .board
            .map_or(unit, |(middle, half)| (at - middle) / half);
        let ragged = 0.16 * walks.shelf.at(place * 3.0);
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

    /// Relief of slabs at a place. Rays wander, so that slabs do not end on straight lines to the pith.
    fn slab(&self, rho: f64, wandered: f64) -> (&crate::slabs::Slab, f64) {
        self.slabs.at(rho, wandered)
    }

    /// The angle of a place, `at` in ring coordinates, on rays that wander.
    fn wandered(&self, walks: &mut Walks, phi: f64, at: DVec2) -> f64 {
        phi + 0.16 * walks.wander.at(at * 3.5)
    }

    /// The same of every node.
    pub fn wandering(&self, walks: &mut Walks) -> Vec<f64> {
        let bundles = self.bundles;
        let nodes = bundles.addresses.iter().zip(&bundles.directions);
        nodes
            .map(|(&(rho, phi), &direction)| self.wandered(walks, phi, direction * rho))
            .collect()
    }

    pub fn level(&self, walks: &mut Walks, index: usize) -> Level {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let unit = unit(rho, bundle.phi);
        let middle = match self.bundles.tips[index] {
            NONE => unit * self.maker.setting.radius + self.pith,
            tip => self.bundles.layout.nodes[tip as usize],
        };
        if bundle.bark {
            self.bark_level(walks, bundle, middle)
        } else {
            self.wood_level(walks, index, unit, middle)
        }
    }

    /// Height of the wood under a strip of bark, as far as the bark follows it.
    fn under_bark(&self, walks: &mut Walks, strip: usize) -> f64 {
        let p = self.maker.p;
        let phi = self.strips.middle(strip);
        let at = unit(1.0, phi);
        let place = self.pith + at * self.maker.setting.radius;
        let torn = self.torn(self.off_shelf(walks, at, place));
        let wandered = self.wandered(walks, phi, at * 0.95);
        let slab = self.slab(0.95, wandered).1;
        let wood = 0.7 * p.slab_height * self.maker.setting.relief * torn * slab;
        self.maker.stepped(at, 0.99, phi) + wood + p.bark_offset
    }

    fn bark_level(&self, walks: &mut Walks, bundle: &Bundle, middle: DVec2) -> Level {
        let p = self.maker.p;
        let strip = self.strips.find(bundle.phi);
        let at = unit(1.0, bundle.phi);
        let noise = self
            .maker
            .noise(walks, at, p.zone(Zone::Bark), bundle_key(bundle));
        Level {
            base: self.under_bark(walks, strip) + 0.3 * noise,
            thorn: 0.0,
            fibre: 0.0,
            middle,
            slant: self.maker.tilt,
            end: End::Strip(strip),
        }
    }

    fn wood_level(&self, walks: &mut Walks, index: usize, at: DVec2, middle: DVec2) -> Level {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let (maker, p, relief) = (self.maker, self.maker.p, self.maker.setting.relief);
        let key = index as i64;
        let zone = p.proportions().zone_at(rho, 0.0);
        let across = (middle - self.pith) / maker.setting.radius;
        let published = maker.published(walks, (across, at), (rho, bundle.phi), zone, key);
        let shelf = self.off_shelf(walks, at, middle);
        let torn = self.torn(shelf);
        let wandered = self.wandered(walks, bundle.phi, at);
        let number = self.slivers.find(rho, wandered);
        let (ring, ray) = self.slivers.middle(number);
        // Slivers run up a slab like the treads of a stair.
        let (slab, own_height) = self.slab(rho, wandered);
        let shared = self.slabs.at(ring, ray).1;
        let slab_height = 0.35 * own_height + 0.65 * shared;
        let short = self.random(purpose::GROUP, number as i64, 9);
        let slab_height = slab_height * (1.0 - 0.75 * short * short);
        // Both halves keep their splinters: every other slab tears downwards.
        let up = if slab.height > 0.0 { 1.0 } else { -1.0 };
        let sliver = |what: i64| self.random(purpose::GROUP, number as i64, what);
        // Short ones are common, long ones rare.
        let length = sliver(0) * sliver(0) * sliver(0);
        let length = p.sliver_height * slab.splinters * length * relief * torn;
        let step = noise::line(
            maker.seed(purpose::STEP) + u64::from(bundle.ring),
            bundle.phi * 0.8,
        );
        let (width, _) = self.slivers.region(number).size();
        let outline =
            (0.9 * length + 0.7 * p.sliver_height * relief * torn * sliver(1)).min(SLENDER * width);
        // Fibres: most end with their sliver, a few stand out of it far.
        let far = self.random(purpose::FIBRE, key, 1);
        let fibre = relief * p.fibre_height * (0.25 + 0.75 * torn);
        let blade = fibre * (0.6 + 5.0 * far * far * far * far * torn)
            + 0.25 * torn * length * self.random(purpose::FIBRE, key, 2);
        let crushed = p.compression_height * (self.random(purpose::SHELF, key, 1) - 0.5);
        let slant = slab.slant * (torn * relief * p.slab_height);
        let torn_height = relief * p.slab_height * slab_height
            + up * (1.6 * length - 0.4 * p.sliver_height * relief * torn)
            + p.step_height * step
            + fibre * (self.random(purpose::FIBRE, key, 3) - 0.5);
        let mut base = published + torn * torn_height + (1.0 - torn) * crushed + slant.dot(at);
        base -= self.split(shelf, key);
        base = self.with_bark(walks, base, bundle, rho);
        let width = 2.0 * bundle.half_width * rho;
        Level {
            base,
            thorn: self.thorn(rho, bundle.phi, zone, key, number),
            fibre,
            middle,
            slant: slant + maker.tilt,
            end: End::Sliver {
                number,
                sliver: up * outline,
                blade: up * blade.min(3.0 * SLENDER * width),
                kinds: (sliver(2), self.random(purpose::FIBRE, key, 4)),
                phi: (bundle.phi, bundle.half_width),
            },
        }
    }

    /// Inner bark tears in strings, of which some come off with the bark.
    fn with_bark(&self, walks: &mut Walks, base: f64, bundle: &Bundle, rho: f64) -> f64 {
        if rho <= self.inner_bark {
            return base;
        }
        let strip = self.strips.find(bundle.phi);
        let pair = i64::from(bundle.sector / 2);
        let goes = self.random(purpose::BARK, pair, i64::from(bundle.ring));
        let depth = ((rho - self.inner_bark) / self.maker.p.phloem_proportion.max(1e-6)).min(1.0);
        let with = noise::smoothstep(0.35, 0.75, goes * (0.55 + 0.75 * depth));
        let bark = self.under_bark(walks, strip)
            + self.maker.p.bark_height
                * (self.strips.edge(strip, bundle.phi)
                    + 0.5 * (self.random(purpose::BARK, pair, 1) - 0.6));
        base + (bark - base) * with
    }

    /// Length of a bundle's thorn. Thorns stand in groups: a sliver has several or none, of about one length.
    fn thorn(&self, rho: f64, phi: f64, zone: Zone, key: i64, sliver: usize) -> f64 {
        self.maker
            .thorn(rho, phi, zone, |purpose, length, probability| {
                // Both draws together meet as often as one would.
                let each = probability.max(0.0).sqrt();
                let group = |b: i64| self.random(purpose, sliver as i64, b);
                if group(5) < each && self.random(purpose, key, 6) < each {
                    length * (0.55 * group(7) + 0.45 * self.random(purpose, key, 8))
                } else {
                    0.0
                }
            })
    }

    /// Depth of the split between the tension and the compression side.
    fn split(&self, shelf: f64, key: i64) -> f64 {
        const WIDTH: f64 = 0.05;
        let near = 1.0 - (shelf - 0.02).abs() / WIDTH;
        if self.maker.p.split <= 0.0 || near <= 0.0 || self.maker.p.compression_shelf <= 0.0 {
            return 0.0;
        }
        self.maker.p.split * near * (0.4 + 0.6 * self.random(purpose::SHELF, key, 7))
    }

    /// Height of a bundle's end at a node of it, whose angle on rays that wander is `wandered`.
    pub fn at(&self, level: &Level, (cell, node): (u32, u32), wandered: f64) -> f64 {
        let bundles = self.bundles;
        let at = bundles.layout.nodes[node as usize];
        let (rho, phi) = bundles.addresses[node as usize];
        let radius = self.maker.setting.radius;
        match level.end {
            End::Strip(strip) => {
                // Nodes beyond the bark repeat the heights of those below them, so that the edge runs straight outwards.
                let out = bundles.directions[node as usize] * radius - (level.middle - self.pith);
                let edge = self.maker.p.bark_height * self.strips.edge(strip, phi);
                level.base + edge + out.dot(level.slant) / radius
            }
            End::Sliver {
                number,
                sliver,
                blade,
                kinds,
                phi: (middle, half),
            } => {
                let ragged = noise::unit(
                    self.maker.seed(purpose::SHAFT),
                    i64::from(cell),
                    i64::from(node),
                    3,
                );
                let off = crate::layout::wrap(phi - middle);
                let own = outline(kinds.1, (off / half.max(1e-9)).clamp(-1.0, 1.0));
                let over = outline(kinds.0, self.slivers.within(number, rho, wandered).x);
                let slope = level.slant.dot(at - level.middle) / radius;
                let height = level.base + slope + sliver * over;
                if level.thorn > 0.0 {
                    // A slender prism, and on it a pyramid that leans to one side.
                    let shaft = self.maker.p.thorn_shaft;
                    let apex = node == bundles.tips[cell as usize];
                    let up = if apex {
                        1.0
                    } else {
                        (0.85 * own + 0.15 * ragged).min(1.0)
                    };
                    return height + level.thorn * (shaft + (1.0 - shaft) * up);
                }
                height + blade * own + level.fibre * (ragged - 0.5)
            }
        }
    }
}

fn bundle_key(bundle: &Bundle) -> i64 {
    (1 << 40) + i64::from(bundle.sector)
}

/// Middle of the section's bundles and half their extent, m.
fn middle_of(bundles: &Bundles) -> (DVec2, f64) {
    let tips = || {
        let known = bundles.tips.iter().filter(|&&t| t != NONE);
        known.map(|&t| bundles.layout.nodes[t as usize])
    };
    let (low, high) = tips().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| {
        (l.min(p), h.max(p))
    });
    (
        (low + high) / 2.0,
        ((high - low).max_element() / 2.0).max(1e-9),
    )
}
