//! The relief of torn wood on a fibrous face, in three orders: slabs, the slivers they split into, and the fibres that
//! stand out of those.
//!
//! A sliver is a group of bundles side by side in a few rings that ended together: one outline runs over all of them,
//! so that splinters are flat, wide along the ring, and only their tips are ragged. All heights are ratios to the
//! stem's radius.

mod added;
mod bark;
mod crushed;
mod shards;
mod tips;

use crate::ends::{EndNode, TornEnd, TornEnds};
use crate::field::HeightField;
use crate::height_model::{HeightModel, NoiseSamplers, unit};
use crate::layout::{FibreBundle, FibreBundles};
use crate::parameters::ZoneParameters;
use crate::plates::brittleness;
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
    /// Height of the outline of its part of the sliver's tip.
    fork: f64,
    /// Height of the slab's shape within the bundle.
    slab: f64,
    /// Height of the bundle's own outline.
    blade: f64,
    /// Height of the unevenness that it shares with those beside it.
    rough: f64,
    /// Height of the plates of brittle wood.
    plates: f64,
    /// Height of the folds of crushed wood.
    folds: f64,
    /// How much of the noise of its nodes it has.
    noisy: f64,
    bark: bool,
}

/// The relief of the torn ends of fibre bundles.
pub(crate) struct TornRelief<'a> {
    model: &'a HeightModel<'a>,
    bundles: &'a FibreBundles,
    /// Heights that take the place of inclination, layers and slabs.
    field: Option<&'a HeightField>,
    /// Heights and splintering over those of the parameters.
    added: Option<&'a HeightField>,
    pub ends: Arc<TornEnds>,
    /// Height of the wood under each strip of bark, as far as the bark follows it.
    under_bark: Vec<f64>,
    /// Ring coordinate from which on wood is inner bark.
    inner_bark: f64,
    /// How brittle the wood is, 0 to 1.
    brittle: f64,
}

/// What is coarser than slivers at a bundle.
struct LargeShape {
    /// Height.
    level: f64,
    /// Depth of the split there.
    split: f64,
    /// Slope, height per radius.
    tilt: DVec2,
    /// How much of the wood is torn rather than crushed, 0 to 1.
    torn: f64,
    /// Factor on the torn relief.
    relief: f64,
    /// How high a layer still is that runs out there: none on it and beyond its end.
    runs_out: f64,
    /// How much of the height of slabs there is, 0 to 1.
    slabs: f64,
    /// Factor on the length of thorns.
    thorns: f64,
}

/// Distances from the edge of the compression shelf, radii, between which crushed wood passes into torn wood, and by how much those
/// of slivers and of bundles differ.
const SHELF_EDGE: (f64, f64) = (-0.1, 0.4);
/// Distance from that edge, radii, from which on slabs have their whole height: beside crushed wood it tears short.
const SLABS_FROM: f64 = 0.8;
/// Shares of the section between which a compression shelf begins to be one of crushed wood, and how long the wood of a narrower one tears
/// over the rest.
const CRUSHED_SHELF: (f64, f64) = (0.36, 0.46);
const SHORT_TORN: f64 = 0.55;
const SHELF_SLIVERS: f64 = 0.24;
const SHELF_BUNDLES: f64 = 0.12;
/// By how much the borders of layers wander, and by how much those of slivers differ, radii.
const LAYER_WANDER: f64 = 0.07;
const LAYER_SLIVERS: f64 = 0.16;
/// Distance from the border of a layer over which it runs out in the wood, radii, the same over its height, at least, and how much of that height bundles have from the middle of
/// their sliver.
const LAYER_ROOT: f64 = 0.04;
const LAYER_RUN_OUT: f64 = 0.055;
const LAYER_SHARE: f64 = 0.9;
/// Height of the outlines of slivers where a layer runs out, over its own there: it ends in tongues along the grain.
const LAYER_FEATHER: f64 = 0.35;
/// Height of the folds over the compression height, and how rough crushed wood is beside them.
const FOLD_HEIGHT: f64 = 0.4;
const CRUSHED_ROUGHNESS: f64 = 0.07;
/// Height of the terraces of brittle wood over that of its steps: its plates break through them, and they are little more than its grain.
const BRITTLE_TERRACES: f64 = 0.2;
/// What those terraces are made of: clumps as large as slivers, and steps from ring to ring.
const BRITTLE_STEPS: (f64, f64) = (0.7, 0.05);
/// How much lower slabs are where wood is brittle.
const BRITTLE_SLABS: f64 = 0.8;
/// How much of the noise of torn wood crushed wood has, and how much of a fold's height a bundle has from its middle: fibres that
/// broke beside each other are no rounded hill.
const CRUSHED_NOISE: f64 = 0.25;
const FOLD_STEPS: f64 = 0.3;
/// Depth of the deepest clefts between slivers over the heights by which slabs and slivers differ.
const CLEFT_OF_SLABS: f64 = 0.5;
const CLEFT_OF_SLIVERS: f64 = 1.1;
/// The unit of the heights of its plates, over that of its steps.
const PLATE_HEIGHT: f64 = 1.7;
/// How much less rough they are than short breaks of wood that splinters, and how much lower fibres and steps stand out of them.
const PLATE_SMOOTHNESS: f64 = 0.9;
const PLATE_SHARPNESS: f64 = 0.85;
/// Length of the slivers of a slab that tear together, over the longest.
const COMMON_LENGTH: f64 = 0.63;
/// How much of the height of its slab a bundle has at its own place, and how much of it the shortest sliver lacks.
const OWN_SHARE: f64 = 0.35;
const SHORTEST: f64 = 0.75;
/// The same in a board, whose slabs are as thick as it is: with slivers like treads of a stair they would be blocks.
const BOARD_OWN_SHARE: f64 = 0.9;
const BOARD_SHORTEST: f64 = 0.35;
/// How much longer the slivers of a board are, and how much deeper the clefts between them.
const BOARD_SLIVERS: f64 = 1.3;
const BOARD_CLEFTS: f64 = 1.3;
/// How much the slabs of a board slant over those of a stem: they are narrow against its width.
const BOARD_SLANT: f64 = 0.5;
/// How far strands of a sliver's tip end before it, and how far out of it, over the height of its outline.
const STRANDS_BACK: f64 = 0.45;
const STRANDS_OUT: f64 = 0.35;
/// Share of the strands that do not end out of it.
const LATE_STRANDS: f64 = 0.88;
/// Height of the tongues of bark from which on it breaks fully on the slant, radii.
const SLANTED_BARK: f64 = 0.35;

impl<'a> TornRelief<'a> {
    pub fn new(
        model: &'a HeightModel<'a>,
        bundles: &'a FibreBundles,
        field: Option<&'a HeightField>,
        noises: &mut NoiseSamplers,
        cache: &mut Option<Arc<TornEnds>>,
    ) -> Self {
        let p = model.p;
        let stem = (model.site.radius, model.site.pith);
        let ends = TornEnds::cached(bundles, p, noises, stem, cache);
        let mut torn = TornRelief {
            model,
            bundles,
            field: field.filter(|f| !f.is_added()),
            added: field.filter(|f| f.is_added()),
            under_bark: Vec::new(),
            brittle: brittleness(p),
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
        let tension = self.model.tension;
        let place = match self.ends.across_board(at, tension) {
            Some(across) => across,
            None => unit.dot(tension),
        };
        place + 1.0 - 2.0 * self.model.p.compression_shelf + 0.16 * ragged
    }

    /// Returns how much of a bundle is torn rather than crushed, 0 to 1.
    fn torn_share(&self, shelf: f64) -> f64 {
        if self.model.p.compression_shelf > 0.0 {
            let (from, to) = SHELF_EDGE;
            noise::smoothstep(from, to, shelf)
        } else {
            1.0
        }
    }

    /// Returns how much of a bundle is torn rather than crushed, 0 to 1, and the factor on the length of what is torn. Where bending
    /// ended on a narrow part of the section that was hardly crushed: the fibres there tore last, and short.
    fn torn_and_length(&self, shelf: f64) -> (f64, f64) {
        let torn = self.torn_share(shelf);
        let (from, to) = CRUSHED_SHELF;
        // The shelf of a board is a broad face of it, however narrow.
        let crushed = match self.ends.is_board() {
            true => 1.0,
            false => noise::smoothstep(from, to, self.model.p.compression_shelf),
        };
        let short = (1.0 - torn) * (1.0 - crushed);
        (
            1.0 - (1.0 - torn) * crushed,
            1.0 - (1.0 - SHORT_TORN) * short,
        )
    }

    /// Returns how much of the height of its slab wood has near the compression shelf, 0 to 1: it tears short there, without pits.
    fn slab_share(&self, shelf: f64) -> f64 {
        if self.model.p.compression_shelf > 0.0 {
            noise::smoothstep(SHELF_EDGE.0, SLABS_FROM, shelf)
        } else {
            1.0
        }
    }

    /// Returns the height of a bundle, which has this [`bundle_noise`].
    pub fn bundle_height(
        &self,
        noises: &mut NoiseSamplers,
        index: usize,
        noise: f64,
    ) -> BundleHeight {
        let bundle = &self.bundles.bundles[index];
        let unit = unit(bundle.rho.min(1.0), bundle.phi);
        let middle = self.ends.middle(self.bundles, index, unit);
        let end = &self.ends.bundles[index];
        if let Some(field) = self.field.filter(|f| !f.has_failures()) {
            self.field_height(field, bundle, middle)
        } else if bundle.bark {
            self.bark_height(bundle, end, middle, noise)
        } else {
            self.wood_height(noises, (index, end), (unit, middle), noise)
        }
    }

    /// Returns the height of a bundle that ends at a field of nothing but heights.
    fn field_height(
        &self,
        field: &HeightField,
        bundle: &FibreBundle,
        middle: DVec2,
    ) -> BundleHeight {
        let fibre = self.model.site.relief * self.model.p.fibre_height;
        BundleHeight {
            base: field.at(bundle.rho, bundle.phi) / self.model.site.radius,
            thorn: 0.0,
            raggedness: if bundle.bark { 0.0 } else { fibre },
            middle,
            slant: DVec2::ZERO,
            sliver: 0.0,
            fork: 0.0,
            slab: 0.0,
            rough: 0.0,
            plates: 0.0,
            folds: 0.0,
            noisy: 0.0,
            blade: if bundle.bark { 0.0 } else { fibre },
            bark: bundle.bark,
        }
    }

    /// Returns what is coarser than slivers at a bundle, `at` in ring coordinates and `middle` in m.
    fn large_shape(
        &self,
        noises: &mut NoiseSamplers,
        (index, end): (usize, &TornEnd),
        (at, middle): (DVec2, DVec2),
        noise: f64,
    ) -> LargeShape {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let model = self.model;
        let Some(field) = self.field else {
            let across = (middle - self.ends.pith) / model.site.radius;
            let shelf = self.distance_to_shelf(end.shelf, at, middle)
                + SHELF_SLIVERS * (end.sliver_random[2] - 0.5)
                + SHELF_BUNDLES * (end.crushed_random[2] - 0.5);
            let (layers, runs_out) = self.layers(end, across, (rho, bundle.phi));
            let (torn, length) = self.torn_and_length(shelf);
            let shape = LargeShape {
                level: layers + noise,
                runs_out,
                split: self.split(shelf, end.crushed_random[1]),
                tilt: model.tilt,
                torn,
                relief: model.site.relief * length,
                slabs: self.slab_share(shelf),
                thorns: 1.0,
            };
            return match self.added {
                Some(added) => self.with_added(shape, added, noises, (end, bundle)),
                None => shape,
            };
        };
        let (level, failure) = self.of_field(field, noises, (end, bundle));
        let torn = failure.map_or(1.0, |f| f.torn);
        let relief = failure.map_or(model.site.relief, |f| f.splintering);
        LargeShape {
            level: level + noise,
            split: 0.0,
            tilt: DVec2::ZERO,
            torn,
            relief,
            runs_out: 0.0,
            slabs: 1.0,
            thorns: torn * relief,
        }
    }

    /// Returns the inclination and the layers at a bundle, `across` in radii, and how high a layer still is that runs out there. A high
    /// layer runs out on the slant, in laths that end together as slivers do.
    fn layers(&self, end: &TornEnd, across: DVec2, (rho, phi): (f64, f64)) -> (f64, f64) {
        let p = self.model.p;
        let off = LAYER_WANDER * end.shelf + LAYER_SLIVERS * (end.sliver_random[2] - 0.5);
        let highest = p.high.height.max(-p.low.height);
        let root = LAYER_ROOT.max(LAYER_RUN_OUT * highest);
        let at = |rho, phi| self.model.stepped_torn(across, (rho, phi), (off, root));
        let own = at(rho, phi);
        if highest == 0.0 {
            return (own, 0.0);
        }
        let (ring, ray) = self.ends.slivers.middle(end.sliver as usize);
        let shared = at(ring.min(1.0), ray);
        let part = ((shared - across.dot(self.model.tilt)).abs() / highest).min(1.0);
        let level = own + (shared - own) * LAYER_SHARE;
        (level, 4.0 * part * (1.0 - part) * highest)
    }

    /// Returns the height of a sliver on its slab, which slivers run up like the treads of a stair, in slab heights; the share of the
    /// slab's own height in it; and the part of the slab's height that the sliver has.
    fn height_on_slab(&self, end: &TornEnd) -> (f64, f64, f64) {
        let (own_height, shared) = end.slab_heights;
        let (own_share, shortest) = self.slab_shares();
        let short = end.sliver_random[0];
        let together = self.ends.slabs.slab(end.slab as usize).together;
        let shortened = 1.0 - shortest * (1.0 - together) * short * short;
        let height = shared + (own_height - shared) * own_share;
        (height * shortened, own_share, shortened)
    }

    fn wood_height(
        &self,
        noises: &mut NoiseSamplers,
        (index, end): (usize, &TornEnd),
        (at, middle): (DVec2, DVec2),
        noise: f64,
    ) -> BundleHeight {
        let bundle = &self.bundles.bundles[index];
        let rho = bundle.rho.min(1.0);
        let p = self.model.p;
        let key = index as i64;
        let zone = p.proportions().zone_at(rho, 0.0);
        let width = 2.0 * bundle.half_width * rho * self.ends.ring_unit;
        let large = self.large_shape(noises, (index, end), (at, middle), noise);
        let (torn, relief) = (large.torn, large.relief);
        let slab = self.ends.slabs.slab(end.slab as usize);
        let (slab_height, own_share, shortened) = self.height_on_slab(end);
        let slabs = large.slabs * (1.0 - BRITTLE_SLABS * self.brittle);
        let [_, long, high] = end.sliver_random;
        let long = long + (COMMON_LENGTH - long) * slab.together;
        // Both halves keep their splinters: every other slab tears downwards.
        let up = if slab.height > 0.0 { 1.0 } else { -1.0 };
        // Short ones are common, long ones rare.
        let (longer, deeper) = self.of_board();
        let length =
            longer * p.sliver_height * relief * torn * slab.splinters * (long * long * long);
        let (shaft, outline) = self.taper(end, length, p.sliver_height * relief * torn * high);
        let feather = (LAYER_FEATHER * large.runs_out).min(self.longest_taper(end));
        // Fibres: most end with their sliver, a few stand out of it far.
        let [far, blade, off] = end.fibre_random;
        let splintered = 1.0 - PLATE_SHARPNESS * self.brittle;
        let frayed = self.frayed(end);
        let fibre = frayed * splintered * relief * p.fibre_height * (0.25 + 0.75 * torn);
        let blade = fibre * (0.5 + 3.0 * far * far * far * far * torn)
            + 0.08 * frayed * torn * length * blade;
        let [drop, fork] = end.fork_random;
        let fork =
            (torn * (0.3 * length + fibre) + 0.5 * torn * outline * fork).min(end.fork_height);
        let (crushed, crushed_blade) = self.crushed(end, torn);
        let slant = slab.slant * (torn * relief * p.slab_height);
        let torn_height = slabs * relief * p.slab_height * slab_height
            + up * (shaft - 0.4 * p.sliver_height * relief * torn)
            + up * 0.6 * length * heavy(drop)
            + splintered
                * p.step_height
                * (0.5 * end.step + 0.35 * frayed * heavy(end.crushed_random[0]))
            + self.brittle * BRITTLE_TERRACES * p.step_height * self.terrace(end, BRITTLE_STEPS)
            + fibre * (off - 0.5)
            + up * outline * frayed.min(1.0) * strand(far, off);
        let cleft = up * splintered * relief * self.cleft(end, deeper);
        let shard = self.shard((key, i64::from(end.fork)), (middle, width), torn);
        let base = large.level
            + shard.height
            + torn * (torn_height - cleft)
            + (1.0 - torn) * crushed
            + slant.dot(self.about_pivot(end, at))
            - 0.5 * up * feather
            - large.split;
        let base = self.with_bark(base + self.lip(end, at), end, (rho, bundle.phi));
        BundleHeight {
            base,
            thorn: large.thorns * self.thorn(rho, bundle.phi, zone, key, end.sliver),
            raggedness: fibre,
            middle,
            slant: slant + large.tilt + shard.slant,
            sliver: up * (outline + feather),
            fork: up * fork,
            slab: slabs * own_share * torn * relief * p.slab_height * shortened,
            plates: torn * self.brittle * PLATE_HEIGHT * p.step_height,
            rough: torn * p.step_height * (1.0 - PLATE_SMOOTHNESS * self.brittle)
                + (1.0 - torn) * CRUSHED_ROUGHNESS * p.compression_height,
            folds: (1.0 - torn) * FOLD_HEIGHT * p.compression_height,
            noisy: CRUSHED_NOISE + (1.0 - CRUSHED_NOISE) * torn,
            blade: up * blade.min(self.longest_blade(width)) + shard.blade + crushed_blade,
            bark: false,
        }
    }

    /// Returns how much of the height of its slab a bundle has at its own place, where the rest is that of its sliver, and how much of
    /// that height the shortest sliver lacks.
    fn slab_shares(&self) -> (f64, f64) {
        if self.ends.is_board() {
            (BOARD_OWN_SHARE, BOARD_SHORTEST)
        } else {
            (OWN_SHARE, SHORTEST)
        }
    }

    /// Returns the factors on the length of slivers and on the depth of the clefts between them: boards part in few, long ones, and split
    /// down their faces.
    fn of_board(&self) -> (f64, f64) {
        if self.ends.is_board() {
            (BOARD_SLIVERS, BOARD_CLEFTS)
        } else {
            (1.0, 1.0)
        }
    }

    /// Returns how deep a cleft is, radii; `deeper` is a factor on it.
    fn cleft(&self, end: &TornEnd, deeper: f64) -> f64 {
        let p = self.model.p;
        deeper * end.cleft * (CLEFT_OF_SLABS * p.slab_height + CLEFT_OF_SLIVERS * p.sliver_height)
    }

    /// Returns a point (`at` in ring coordinates) from that about which the slab there slants, radii: the pith, or the middle of the
    /// slab where the pith is far.
    fn about_pivot(&self, end: &TornEnd, at: DVec2) -> DVec2 {
        if !self.ends.is_board() {
            return at;
        }
        let (ring, ray) = self.ends.slabs.middle(end.slab as usize);
        (at - unit(ring, ray)) * (BOARD_SLANT * self.ends.ring_unit)
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

    /// Returns the height of a bundle's end at one of its nodes, which have `noises`.
    pub fn node_height(&self, level: &BundleHeight, node: &EndNode, noises: &[f64]) -> f64 {
        let bundles = self.bundles;
        let radius = self.model.site.radius;
        if level.bark {
            // Nodes beyond the bark repeat the heights of those below them, so that the edge runs straight outwards.
            let direction = bundles.directions[node.node as usize];
            let out = direction * radius - (level.middle - self.ends.pith);
            let edge = level.sliver * node.shared_outline
                + (level.sliver / SLANTED_BARK).min(1.0).powi(3) * node.outward;
            let strip = self.ends.bundles[node.cell as usize].strip as usize;
            let phi = bundles.addresses[node.node as usize].1;
            let along = match (self.field, self.added) {
                (Some(field), _) if field.has_failures() => self.bark_level(strip, phi),
                (None, Some(added)) => self.bark_added(added, strip, phi),
                _ => 0.0,
            };
            return level.base + along + edge + out.dot(level.slant) / radius;
        }
        let at = bundles.layout.nodes[node.node as usize];
        let slope = level.slant.dot(at - level.middle) / radius;
        let noise = level.noisy * noises[node.node as usize];
        let height = level.base
            + slope
            + noise
            + level.sliver * node.shared_outline
            + level.fork * node.fork_outline
            + level.slab * node.slab
            + level.rough * node.rough
            + level.plates * node.plate
            + level.folds * self.fold(at.lerp(level.middle, FOLD_STEPS), level.folds, node.rough);
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

/// Returns how far a strand of a sliver's tip ends from it, over the height of its outline, from two random numbers: most of a frayed
/// tip broke together, some strands before, a few later.
fn strand(later: f64, before: f64) -> f64 {
    let (later, before) = ((later - LATE_STRANDS).max(0.0), before * before);
    STRANDS_OUT * later / (1.0 - LATE_STRANDS) - STRANDS_BACK * before * before
}

/// Maps a random number from 0 to 1 to one from −1 to 1 with heavy tails: most are small.
fn heavy(random: f64) -> f64 {
    let t = 2.0 * random - 1.0;
    t * (0.2 + 0.8 * t * t * t * t)
}

/// Returns the noise of a bundle, number `index` of its layout (Yang 2019, Eqs. 2 to 5). Of wood it is the white noise alone: Perlin
/// noise is continuous, and each node has its own ([`node_noise`]).
pub(crate) fn bundle_noise(
    model: &HeightModel,
    noises: &mut NoiseSamplers,
    index: usize,
    bundle: &FibreBundle,
) -> f64 {
    if bundle.bark {
        let key = (1 << 40) + i64::from(bundle.sector);
        return model.noise(noises, unit(1.0, bundle.phi), model.p.zone(Zone::Bark), key);
    }
    let zone = model.p.proportions().zone_at(bundle.rho.min(1.0), 0.0);
    let white = ZoneParameters {
        perlin_amplitude: 0.0,
        ..model.p.zone(zone).clone()
    };
    model.noise(noises, DVec2::ZERO, &white, index as i64)
}

/// Returns the Perlin noise of wood at a node, `at` in ring coordinates.
pub(crate) fn node_noise(model: &HeightModel, noises: &mut NoiseSamplers, at: DVec2) -> f64 {
    let rho = at.length().min(1.0);
    let perlin = ZoneParameters {
        white_noise_amplitude: 0.0,
        ..model
            .p
            .zone(model.p.proportions().zone_at(rho, 0.0))
            .clone()
    };
    model.noise(noises, at, &perlin, 0)
}
