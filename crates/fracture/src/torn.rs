//! The relief of torn wood on a fibrous face, in three orders: slabs, the slivers they split into, and the fibres that
//! stand out of those.
//!
//! A sliver is a group of bundles side by side in a few rings that ended together: one outline runs over all of them,
//! so that splinters are flat, wide along the ring, and only their tips are ragged. All heights are ratios to the
//! stem's radius.

use crate::ends::{EndNode, TornEnd, TornEnds, wandering_angle};
use crate::field::HeightField;
use crate::height_model::{HeightModel, NoiseSamplers, unit};
use crate::layout::{FibreBundle, FibreBundles};
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::Zone;
use std::sync::Arc;

/// Height of one fibre bundle.
pub(crate) struct BundleHeight {
    /// Before the outlines of its sliver and its own end.
    base: f64,
    /// Height of its thorn, 0 for none.
    pub thorn: f64,
    /// Raggedness of its end.
    raggedness: f64,
    middle: DVec2,
    slant: DVec2,
    /// Height of the sliver's outline, below zero where it hangs out of the upper piece.
    sliver: f64,
    /// Height of the bundle's own.
    blade: f64,
    bark: bool,
}

/// The relief of the torn ends of fibre bundles.
pub(crate) struct TornRelief<'a> {
    model: &'a HeightModel<'a>,
    bundles: &'a FibreBundles,
    pub ends: Arc<TornEnds>,
    /// Height of the wood under each strip of bark, as far as the bark follows it.
    under_bark: Vec<f64>,
    /// Ring coordinate from which on wood is inner bark.
    inner_bark: f64,
}

/// Greatest length of a blade over its width.
const MAX_SLENDERNESS: f64 = 9.0;

impl<'a> TornRelief<'a> {
    pub fn new(
        model: &'a HeightModel<'a>,
        bundles: &'a FibreBundles,
        noises: &mut NoiseSamplers,
        cache: &mut Option<Arc<TornEnds>>,
    ) -> Self {
        let p = model.p;
        let stem = (model.site.radius, model.site.pith);
        let ends = TornEnds::cached(bundles, p, noises, stem, cache);
        let mut torn = TornRelief {
            model,
            bundles,
            under_bark: Vec::new(),
            inner_bark: ends.wood.map_or(2.0, |wood| wood - p.phloem_proportion),
            ends,
        };
        if torn.ends.wood.is_some() {
            let strips = 0..torn.ends.strips.count();
            torn.under_bark = strips.map(|s| torn.under_bark(noises, s)).collect();
        }
        torn
    }

    fn random(&self, purpose: u64, a: i64, b: i64) -> f64 {
        noise::unit(self.model.seed(purpose), a, b, 0)
    }

    /// Returns the distance of a point from the edge of the compression shelf, radii; below 0 on the shelf. `ragged` is the
    /// raggedness of the edge there.
    fn distance_to_shelf(&self, ragged: f64, unit: DVec2, at: DVec2) -> f64 {
        let place = self.ends.shelf_coordinates(unit, at);
        let ragged = 0.16 * ragged;
        place.dot(self.model.tension) + 1.0 - 2.0 * self.model.p.compression_shelf + ragged
    }

    /// Returns how much of a bundle is torn rather than crushed, 0 to 1.
    fn torn_share(&self, shelf: f64) -> f64 {
        if self.model.p.compression_shelf > 0.0 {
            // Torn wood stands free within a tenth of a radius of the shelf's edge.
            noise::smoothstep(-0.05, 0.1, shelf)
        } else {
            1.0
        }
    }

    /// Returns the height of a bundle of the procedural model.
    pub fn bundle_height(&self, noises: &mut NoiseSamplers, index: usize) -> BundleHeight {
        let bundle = &self.bundles.bundles[index];
        let unit = unit(bundle.rho.min(1.0), bundle.phi);
        let middle = self.ends.middle(self.bundles, index, unit);
        let end = &self.ends.bundles[index];
        if bundle.bark {
            self.bark_height(noises, bundle, end, middle)
        } else {
            self.wood_height(noises, (index, end), unit, middle)
        }
    }

    /// Returns the height of the wood under a strip of bark, as far as the bark follows it.
    fn under_bark(&self, noises: &mut NoiseSamplers, strip: usize) -> f64 {
        let p = self.model.p;
        let phi = self.ends.strips.middle(strip);
        let at = unit(1.0, phi);
        let place = self.ends.pith + at * self.model.site.radius;
        let ragged = noises
            .shelf
            .at(self.ends.shelf_coordinates(at, place) * 3.0);
        let torn = self.torn_share(self.distance_to_shelf(ragged, at, place));
        let wandered = wandering_angle(noises, phi, at * 0.95);
        let slab = self.ends.slabs.at(0.95, wandered).1;
        let wood = 0.7 * p.slab_height * self.model.site.relief * torn * slab;
        self.model.stepped(at, 0.99, phi) + wood + p.bark_offset
    }

    /// Returns the height of a bundle that ends at a height field.
    pub fn field_height(&self, field: &HeightField, index: usize) -> BundleHeight {
        let bundle = &self.bundles.bundles[index];
        let unit = unit(bundle.rho.min(1.0), bundle.phi);
        let fibre = self.model.site.relief * self.model.p.fibre_height;
        BundleHeight {
            base: field.at(bundle.rho, bundle.phi) / self.model.site.radius,
            thorn: 0.0,
            raggedness: if bundle.bark { 0.0 } else { fibre },
            middle: self.ends.middle(self.bundles, index, unit),
            slant: DVec2::ZERO,
            sliver: 0.0,
            blade: if bundle.bark { 0.0 } else { fibre },
            bark: bundle.bark,
        }
    }

    fn bark_height(
        &self,
        noises: &mut NoiseSamplers,
        bundle: &FibreBundle,
        end: &TornEnd,
        middle: DVec2,
    ) -> BundleHeight {
        let p = self.model.p;
        let at = unit(1.0, bundle.phi);
        let noise = self
            .model
            .noise(noises, at, p.zone(Zone::Bark), bundle_key(bundle));
        BundleHeight {
            base: self.under_bark[end.strip as usize] + 0.3 * noise,
            thorn: 0.0,
            raggedness: 0.0,
            middle,
            slant: self.model.tilt,
            sliver: 0.0,
            blade: 0.0,
            bark: true,
        }
    }

    fn wood_height(
        &self,
        noises: &mut NoiseSamplers,
        (index, end): (usize, &TornEnd),
        at: DVec2,
        middle: DVec2,
    ) -> BundleHeight {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let (model, p, relief) = (self.model, self.model.p, self.model.site.relief);
        let key = index as i64;
        let zone = p.proportions().zone_at(rho, 0.0);
        let across = (middle - self.ends.pith) / model.site.radius;
        let published = model.published(noises, (across, at), (rho, bundle.phi), zone, key);
        let shelf = self.distance_to_shelf(end.shelf, at, middle);
        let torn = self.torn_share(shelf);
        let slab = self.ends.slabs.slab(end.slab as usize);
        // Slivers run up a slab like the treads of a stair.
        let (own_height, shared) = end.slab_heights;
        let slab_height = 0.35 * own_height + 0.65 * shared;
        let [short, long, high] = end.sliver_random;
        let slab_height = slab_height * (1.0 - 0.75 * short * short);
        // Both halves keep their splinters: every other slab tears downwards.
        let up = if slab.height > 0.0 { 1.0 } else { -1.0 };
        // Short ones are common, long ones rare.
        let length = long * long * long;
        let length = p.sliver_height * slab.splinters * length * relief * torn;
        let (width, _) = self.ends.slivers.region(end.sliver as usize).size();
        let outline = (0.9 * length + 0.7 * p.sliver_height * relief * torn * high)
            .min(MAX_SLENDERNESS * width);
        // Fibres: most end with their sliver, a few stand out of it far.
        let [far, blade, off] = end.fibre_random;
        let fibre = relief * p.fibre_height * (0.25 + 0.75 * torn);
        let blade =
            fibre * (0.6 + 5.0 * far * far * far * far * torn) + 0.25 * torn * length * blade;
        let crushed = p.compression_height * (end.crushed_random[0] - 0.5);
        let slant = slab.slant * (torn * relief * p.slab_height);
        let torn_height = relief * p.slab_height * slab_height
            + up * (1.6 * length - 0.4 * p.sliver_height * relief * torn)
            + p.step_height * end.step
            + fibre * (off - 0.5);
        let mut base = published + torn * torn_height + (1.0 - torn) * crushed + slant.dot(at);
        base -= self.split(shelf, end.crushed_random[1]);
        base = self.with_bark(base, end, rho);
        let width = 2.0 * bundle.half_width * rho;
        BundleHeight {
            base,
            thorn: self.thorn(rho, bundle.phi, zone, key, end.sliver),
            raggedness: fibre,
            middle,
            slant: slant + model.tilt,
            sliver: up * outline,
            blade: up * blade.min(3.0 * MAX_SLENDERNESS * width),
            bark: false,
        }
    }

    /// Returns the height of inner bark, which tears in strings; some of them come off with the bark.
    fn with_bark(&self, base: f64, end: &TornEnd, rho: f64) -> f64 {
        if rho <= self.inner_bark {
            return base;
        }
        let [goes, long] = end.string_random;
        let depth = ((rho - self.inner_bark) / self.model.p.phloem_proportion.max(1e-6)).min(1.0);
        let with = noise::smoothstep(0.35, 0.75, goes * (0.55 + 0.75 * depth));
        let bark = self.under_bark[end.strip as usize]
            + self.model.p.bark_height * (end.strip_end + 0.5 * (long - 0.6));
        base + (bark - base) * with
    }

    /// Returns the length of a bundle's thorn. Thorns stand in groups: a sliver has several or none, of about one length.
    fn thorn(&self, rho: f64, phi: f64, zone: Zone, key: i64, sliver: u32) -> f64 {
        self.model
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

    /// Returns the depth of the split between the tension and the compression side.
    fn split(&self, shelf: f64, deep: f64) -> f64 {
        const WIDTH: f64 = 0.05;
        let near = 1.0 - (shelf - 0.02).abs() / WIDTH;
        if self.model.p.split <= 0.0 || near <= 0.0 || self.model.p.compression_shelf <= 0.0 {
            return 0.0;
        }
        self.model.p.split * near * (0.4 + 0.6 * deep)
    }

    /// Returns the height of a bundle's end at one of its nodes.
    pub fn node_height(&self, level: &BundleHeight, node: &EndNode) -> f64 {
        let bundles = self.bundles;
        let radius = self.model.site.radius;
        if level.bark {
            // Nodes beyond the bark repeat the heights of those below them, so that the edge runs straight outwards.
            let direction = bundles.directions[node.node as usize];
            let out = direction * radius - (level.middle - self.ends.pith);
            let edge = self.model.p.bark_height * node.shared_outline;
            return level.base + edge + out.dot(level.slant) / radius;
        }
        let at = bundles.layout.nodes[node.node as usize];
        let slope = level.slant.dot(at - level.middle) / radius;
        let height = level.base + slope + level.sliver * node.shared_outline;
        if level.thorn > 0.0 {
            // A slender prism, and on it a pyramid that leans to one side.
            let shaft = self.model.p.thorn_shaft;
            let apex = node.node == bundles.tips[node.cell as usize];
            let up = if apex {
                1.0
            } else {
                (0.85 * node.own_outline + 0.15 * node.raggedness).min(1.0)
            };
            return height + level.thorn * (shaft + (1.0 - shaft) * up);
        }
        height + level.blade * node.own_outline + level.raggedness * (node.raggedness - 0.5)
    }
}

fn bundle_key(bundle: &FibreBundle) -> i64 {
    (1 << 40) + i64::from(bundle.sector)
}
