//! The part of the torn ends of fibre bundles that does not depend on heights: the slab and the sliver of each, the outlines
//! that run over it, and its random numbers. It is made once for a layout and cached for the next break.

use crate::board::{BoardSection, ring_unit};
use crate::height_model::{NoiseSamplers, purpose, unit};
use crate::layout::{FibreBundle, FibreBundles, wrap_angle};
use crate::outline;
use crate::parameters::BreakParameters;
use crate::plates::{Plate, brittleness};
use crate::rays::Rays;
use crate::slabs::{SectionPartition, SectionSpan, Slabs};
use crate::strips::{self as bark, Strips};
use crate::surface::{NONE, SectionLayout};
use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::PI;
use std::sync::Arc;

/// Everything that ends depend on besides the layout.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    seed: u64,
    slabs: usize,
    slivers: usize,
    aspect: f64,
    strips: usize,
    radius: f64,
    pith: DVec2,
    brittle: bool,
}

/// The torn ends of the bundles of a layout.
#[derive(Debug)]
pub(crate) struct TornEnds {
    layout: Arc<SectionLayout>,
    key: Key,
    pub pith: DVec2,
    /// For sections without a pith in them.
    board: Option<BoardSection>,
    /// Radii in a unit of the ring coordinate, whose origin is the pith of the log that a board was cut from.
    pub ring_unit: f64,
    rays: Rays,
    pub slabs: Slabs,
    pub slivers: SectionPartition,
    pub strips: Strips,
    /// Ring coordinate of the outermost wood under bark; `None` where there is no bark.
    pub wood: Option<f64>,
    /// The parts that slivers split into towards their tips.
    pub forks: SectionPartition,
    /// One for each bundle.
    pub bundles: Vec<TornEnd>,
    /// Every node of every bundle.
    pub nodes: Vec<EndNode>,
    /// For each corner of each facet its number in `nodes`.
    pub corners: Vec<[u32; 3]>,
}

/// The torn end of a bundle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TornEnd {
    /// Its sliver.
    pub sliver: u32,
    /// Its slab.
    pub slab: u32,
    /// Height of the slab there, and in the middle of the sliver.
    pub slab_heights: (f64, f64),
    /// Random numbers of its sliver: how short it is, how long, and the height of its outline.
    pub sliver_random: [f64; 3],
    /// The part of the sliver's tip that it is in.
    pub fork: u32,
    /// Random numbers of the part of the sliver's tip that it is in: how far that ends before the others, and the height of its
    /// outline.
    pub fork_random: [f64; 2],
    /// Greatest height of that outline, radii.
    pub fork_height: f64,
    /// How deep a cleft along the border of its sliver is there, 0 for none to about 1.
    pub cleft: f64,
    /// Random numbers of its fibres.
    pub fibre_random: [f64; 3],
    /// Random numbers of its crushing, of its depth in a split, and of how far it is torn beside the shelf.
    pub crushed_random: [f64; 3],
    /// Step against other bundles of its ring, −1 to 1.
    pub step: f64,
    /// Raggedness of the edge of the compression shelf there.
    pub shelf: f64,
    /// The strip of bark that it lies under or is part of.
    pub strip: u32,
    /// The plate of bark that it is part of, if it is.
    pub plate: u32,
    /// Height of the end of that strip there.
    pub strip_end: f64,
    /// The string of inner bark that it is part of, if it is.
    pub string: BarkString,
    /// The plates that it broke across in, if it is brittle.
    brittle_plate: Plate,
}

/// A string of inner bark at a bundle of it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BarkString {
    /// Random numbers: how far it goes with the bark, and how far beyond that or short of it.
    pub goes: f64,
    pub long: f64,
    /// How far its end is torn to one side there, −1 to 1.
    pub slant: f64,
    /// How far the bundle ends before the string or beyond it, −0.5 to 0.5.
    pub ragged: f64,
}

/// A node of a bundle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EndNode {
    pub node: u32,
    pub cell: u32,
    /// Outline of the sliver; of the strip where the bundle is bark.
    pub shared_outline: f64,
    /// Outline of the part of the sliver's tip.
    pub fork_outline: f64,
    /// Height of the slab here over that at the bundle's middle.
    pub slab: f64,
    /// Unevenness of short breaks, about −1 to 1: one value for all bundles at the node.
    pub rough: f64,
    /// Height of the plate that the bundle broke in, in steps of brittle wood.
    pub plate: f64,
    /// Outline of the bundle's own end.
    pub own_outline: f64,
    /// Raggedness of the bundle's own end.
    pub raggedness: f64,
    /// Height of torn bark here over its inner edge, radii.
    pub outward: f64,
}

/// How many parts a sliver splits into towards its tip, on average, and of how many bundles those are on average, at least.
const FORKS: usize = 5;
const FORK_BUNDLES: usize = 6;
/// Of how many bundles slivers are on average, at least: with fewer they would all be of one size.
const SLIVER_BUNDLES: usize = 20;
/// Width of the clumps of brittle wood along the ring over their thickness across it, at most: it breaks across rings, and checks along
/// rays.
const BRITTLE_ASPECT: f64 = 0.7;
/// How many times as large the span of a board's rings and rays counts at most.
const MAX_SPANS: f64 = 8.0;
/// How many times as many slivers a board has as a round stem: they are as thin as slabs that lie in its thickness.
const BOARD_SLIVERS: f64 = 1.4;
/// Greatest length of such a part over its width.
const FORK_SLENDERNESS: f64 = 7.0;
/// Shares of the sides of slivers along rings and along rays that have a cleft, its width, radii, and the greatest part of a
/// sliver's that it takes.
const RING_CLEFTS: f64 = 0.45;
const RAY_CLEFTS: f64 = 0.4;
const CLEFT_WIDTH: f64 = 0.024;
const CLEFT_SHARE: f64 = 0.4;
/// Ring coordinates between which clefts end: wood under bark is torn as that is.
const CLEFTS_END: (f64, f64) = (0.8, 0.88);
/// Greatest part of its height that a sliver lacks on one side of its thickness.
const MAX_BEVEL: f64 = 0.65;
/// How many steps of a ring follow each other along a radius's length of it.
const STEPS_PER_RADIUS: f64 = 4.0;

impl TornEnds {
    /// Returns the ends of `bundles`: the cached ones where nothing has changed that they depend on. `radius` and `pith` are
    /// the stem's, m.
    pub fn cached(
        bundles: &FibreBundles,
        p: &BreakParameters,
        noises: &mut NoiseSamplers,
        (radius, pith): (f64, DVec2),
        cache: &mut Option<Arc<TornEnds>>,
    ) -> Arc<TornEnds> {
        let key = Key {
            seed: p.seed,
            slabs: p.slab_count as usize,
            slivers: p.sliver_count as usize,
            aspect: p.bundle_aspect,
            strips: p.bark_strips as usize,
            radius,
            pith,
            brittle: brittleness(p) > 0.0,
        };
        if let Some(ends) = cache
            && ends.key == key
            && Arc::ptr_eq(&ends.layout, &bundles.layout)
        {
            return ends.clone();
        }
        let ends = Arc::new(TornEnds::new(bundles, p, noises, key));
        *cache = Some(ends.clone());
        ends
    }

    fn new(
        bundles: &FibreBundles,
        p: &BreakParameters,
        noises: &mut NoiseSamplers,
        key: Key,
    ) -> TornEnds {
        let span = SectionSpan::from_bundles(&bundles.bundles);
        let barked = bundles.bundles.iter().any(|b| b.bark);
        let wood = (bundles.bundles.iter().filter(|b| !b.bark))
            .map(|b| b.rho)
            .fold(0.0, f64::max);
        let pith = match (span.phi, bundles.layout.nodes.first()) {
            (None, Some(&node)) => node,
            _ => key.pith,
        };
        let ring_unit = span
            .phi
            .map_or(1.0, |_| ring_unit(bundles, (key.radius, key.pith)));
        let board = span.phi.is_some();
        // Counts are those of the section, which takes a part of the span of its rings and rays.
        let spans = match span.phi {
            Some(_) => (span.area() * ring_unit * ring_unit / PI).clamp(1.0, MAX_SPANS),
            None => 1.0,
        };
        let count = |count: usize, factor: f64| (count as f64 * factor).round() as usize;
        let (slabs, slivers) = (
            count(key.slabs, spans.sqrt().sqrt()),
            count(key.slivers, spans * if board { BOARD_SLIVERS } else { 1.0 }),
        );
        let slabs = Slabs::new(&span, slabs, key.brittle, key.seed);
        let sliver_seed = seed(key.seed, purpose::SLIVER);
        let aspect = match key.brittle {
            true => key.aspect.min(BRITTLE_ASPECT),
            false => key.aspect,
        };
        let slivers = match span.phi {
            None => {
                let most = bundles.bundles.len() / SLIVER_BUNDLES;
                slabs.split(slivers.min(most), aspect, sliver_seed)
            }
            // The slabs of a board are as thick as it is: its slivers run on through several.
            Some(_) => SectionPartition::new(&span, slivers, aspect, sliver_seed),
        };
        let forks = (FORKS * slivers.count()).min(bundles.bundles.len() / FORK_BUNDLES);
        let mut ends = TornEnds {
            layout: bundles.layout.clone(),
            key,
            pith,
            board: span.phi.map(|_| BoardSection::new(bundles)),
            ring_unit,
            rays: Rays::new(&span),
            forks: slivers.split(forks, aspect, seed(key.seed, purpose::FORK), |_| 1.0),
            slabs,
            slivers,
            strips: Strips::new(p),
            wood: barked.then_some(wood),
            bundles: Vec::new(),
            nodes: Vec::new(),
            corners: Vec::new(),
        };
        let all = (0..bundles.bundles.len()).map(|i| ends.end(bundles, i, noises));
        ends.bundles = all.collect();
        ends.find_nodes(bundles, noises);
        ends
    }

    /// Returns the angle (rad) of a point among rays that wander, so that slabs do not end on straight lines to the pith.
    pub fn ray_angle(&self, noises: &mut NoiseSamplers, rho: f64, phi: f64) -> f64 {
        self.rays.angle(noises, (rho, phi), unit(1.0, phi))
    }

    fn random(&self, purpose: u64, a: i64, b: i64) -> f64 {
        noise::unit(seed(self.key.seed, purpose), a, b, 0)
    }

    /// Returns the position of a bundle's middle, m.
    pub fn middle(&self, bundles: &FibreBundles, index: usize, unit: DVec2) -> DVec2 {
        match bundles.tips[index] {
            NONE => unit * self.key.radius + self.pith,
            tip => bundles.layout.nodes[tip as usize],
        }
    }

    /// Returns whether the section has no pith in it.
    pub fn is_board(&self) -> bool {
        self.board.is_some()
    }

    /// Returns a point (`unit` in ring coordinates, `at` in m) in the coordinates of the compression shelf.
    pub fn shelf_coordinates(&self, unit: DVec2, at: DVec2) -> DVec2 {
        let in_board = |board: &BoardSection| board.across_width(at);
        self.board.as_ref().map_or(unit, in_board)
    }

    /// Returns how far a point (m) lies through the thickness of a board, −1 on one face and 1 on that to which `tension` points: boards
    /// bend flat. `None` where the pith is in the section.
    pub fn across_board(&self, at: DVec2, tension: DVec2) -> Option<f64> {
        let board = self.board.as_ref()?;
        Some(board.through(at, tension))
    }

    fn end(&self, bundles: &FibreBundles, index: usize, noises: &mut NoiseSamplers) -> TornEnd {
        let bundle = &bundles.bundles[index];
        let strip = self.strips.find(bundle.phi);
        let rho = bundle.rho.min(1.0);
        let unit = unit(rho, bundle.phi);
        if bundle.bark {
            return TornEnd {
                strip: strip as u32,
                plate: self.strips.plate(bundle.phi) as u32,
                ..TornEnd::default()
            };
        }
        let key = index as i64;
        let wandered = self.ray_angle(noises, rho, bundle.phi);
        let number = self.slivers.find(rho, wandered);
        let (ring, ray) = self.slivers.middle(number);
        let (slab, height) = self.slabs.at(rho, wandered);
        let shared = self.slabs.at(ring, ray).1;
        let sliver = |what: i64| self.random(purpose::GROUP, number as i64, what);
        let place = self.shelf_coordinates(unit, self.middle(bundles, index, unit));
        let part = self.forks.find(rho, wandered);
        let fork = |what: i64| self.random(purpose::FORK, part as i64, what);
        TornEnd {
            sliver: number as u32,
            slab: slab as u32,
            slab_heights: (height, shared),
            sliver_random: [sliver(9), sliver(0), sliver(1)],
            fork: part as u32,
            fork_random: [fork(0), fork(1)],
            fork_height: FORK_SLENDERNESS * self.ring_unit * self.forks.region(part).size().0,
            cleft: self.cleft(number, self.slivers.within(number, rho, wandered))
                * (1.0 - noise::smoothstep(CLEFTS_END.0, CLEFTS_END.1, rho)),
            fibre_random: [1, 2, 3].map(|n| self.random(purpose::FIBRE, key, n)),
            crushed_random: [1, 7, 8].map(|n| self.random(purpose::SHELF, key, n)),
            step: noise::value_1d(
                seed(self.key.seed, purpose::STEP) + u64::from(bundle.ring),
                // Patches of one length along the ring, wherever it is.
                bundle.phi * (1.0 + STEPS_PER_RADIUS * rho),
            ),
            shelf: noises.shelf.at(place * 3.0),
            strip: strip as u32,
            plate: 0,
            strip_end: if self.wood.is_some() {
                self.strips
                    .edge((strip, self.strips.plate(bundle.phi)), bundle.phi)
            } else {
                0.0
            },
            string: self.string(bundle),
            brittle_plate: if self.key.brittle {
                let at = (self.middle(bundles, index, unit) - self.pith) / self.key.radius;
                Plate::large(seed(self.key.seed, purpose::PLATE), at)
            } else {
                Plate::default()
            },
        }
    }

    /// Returns the string of inner bark that a bundle is part of.
    fn string(&self, bundle: &FibreBundle) -> BarkString {
        let (string, across) = self.strips.string(bundle.phi);
        let random = |what: i64| self.random(purpose::BARK, string as i64, what);
        let own = self.random(
            purpose::BARK,
            i64::from(bundle.sector) << 16 | i64::from(bundle.ring),
            3,
        );
        BarkString {
            goes: random(0),
            long: random(1),
            slant: across * (2.0 * random(2) - 1.0),
            ragged: own - 0.5,
        }
    }

    /// Returns how deep a cleft a sliver has at a point of it, −1 to 1 along the ring and across it. Wood parts along rings and
    /// rays: what lay there stayed on the other piece, as a thin lath.
    fn cleft(&self, sliver: usize, at: DVec2) -> f64 {
        let (width, thickness) = self.slivers.region(sliver).size();
        // Clefts are of one width, and leave most of a thin sliver as it is.
        let border = |size: f64| 1.0 - (2.0 * CLEFT_WIDTH / size.max(1e-9)).min(CLEFT_SHARE);
        let (width, thickness) = (width * self.ring_unit, thickness * self.ring_unit);
        let random = |k: i64| self.random(purpose::GROUP, sliver as i64, k);
        let sides = [
            (at.y, border(thickness), RING_CLEFTS),
            (-at.y, border(thickness), RING_CLEFTS),
            (at.x, border(width), RAY_CLEFTS),
            (-at.x, border(width), RAY_CLEFTS),
        ];
        let depth = |(k, (place, from, share)): (i64, (f64, f64, f64))| {
            let is_cleft = place > from && random(20 + k) < share;
            if is_cleft {
                0.3 + 0.7 * random(30 + k)
            } else {
                0.0
            }
        };
        (0..).zip(sides).map(depth).fold(0.0, f64::max)
    }

    /// Returns the part of its height that a sliver has at a point of its thickness (−1 to 1): splinters are thinner towards
    /// their tips.
    fn bevel(&self, sliver: usize, across: f64) -> f64 {
        let random = 2.0 * self.random(purpose::GROUP, sliver as i64, 3) - 1.0;
        let depth = MAX_BEVEL * random.abs();
        let side = if random < 0.0 { -across } else { across };
        let far = (1.0 + side) / 2.0;
        1.0 - depth * far * far
    }

    /// Finds the nodes of every bundle.
    fn find_nodes(&mut self, bundles: &FibreBundles, noises: &mut NoiseSamplers) {
        let nodes = bundles.addresses.iter().zip(&bundles.directions);
        let rays: Vec<f64> = nodes
            .map(|(&at, &direction)| self.rays.angle(noises, at, direction))
            .collect();
        let rough: Vec<f64> = bundles
            .addresses
            .iter()
            .zip(&bundles.directions)
            .map(|(&(rho, _), &direction)| self.roughness(direction * rho))
            .collect();
        let thick = bark::thickness(bundles, (self.pith, self.key.radius));
        // Facets of a bundle follow each other, so a node's last number is most often the right one.
        let mut last = vec![(NONE, 0); bundles.layout.nodes.len()];
        let facets = bundles.layout.facets.iter();
        let mut end_nodes: Vec<EndNode> = Vec::with_capacity(bundles.layout.facets.len());
        let corners = facets.zip(&bundles.layout.cells).map(|(facet, &cell)| {
            facet.map(|n| {
                let known = &mut last[n as usize];
                if known.0 != cell {
                    *known = (cell, end_nodes.len() as u32);
                    let at = (rays[n as usize], rough[n as usize], thick[n as usize]);
                    end_nodes.push(self.end_node(bundles, (cell, n), at));
                }
                known.1
            })
        });
        let corners = corners.collect();
        (self.corners, self.nodes) = (corners, end_nodes);
    }

    /// Returns the unevenness of short breaks at a point, in ring coordinates.
    fn roughness(&self, at: DVec2) -> f64 {
        let seed = seed(self.key.seed, purpose::ROUGH);
        let octave = |n: u64, scale: f64| noise::gradient_2d(seed + n, at * scale);
        1.1 * octave(0, 4.3) + 0.9 * octave(1, 9.7) + 0.7 * octave(2, 21.0)
    }

    /// Returns a node of a bundle with its angle among rays that wander and the unevenness there.
    fn end_node(
        &self,
        bundles: &FibreBundles,
        (cell, node): (u32, u32),
        (wandered, rough, thick): (f64, f64, f64),
    ) -> EndNode {
        let bundle: &FibreBundle = &bundles.bundles[cell as usize];
        let end = &self.bundles[cell as usize];
        let (rho, phi) = bundles.addresses[node as usize];
        let none = EndNode {
            node,
            cell,
            shared_outline: 0.0,
            fork_outline: 0.0,
            slab: 0.0,
            rough,
            plate: 0.0,
            own_outline: 0.0,
            raggedness: 0.0,
            outward: 0.0,
        };
        if bundle.bark {
            let shared_outline = self
                .strips
                .edge((end.strip as usize, end.plate as usize), phi);
            return EndNode {
                shared_outline,
                outward: bark::outward(
                    seed(self.key.seed, purpose::BARK_SLANT),
                    (node, thick),
                    phi,
                ),
                ..none
            };
        }
        let number = end.sliver as usize;
        let kind = self.random(purpose::GROUP, number as i64, 2);
        let own_kind = self.random(purpose::FIBRE, i64::from(cell), 4);
        let part = end.fork as usize;
        let fork_kind = self.random(purpose::FORK, part as i64, 2);
        let off = wrap_angle(phi - bundle.phi);
        let along = (off / bundle.half_width.max(1e-9)).clamp(-1.0, 1.0);
        let on_sliver = self.slivers.within(number, rho, wandered);
        let on_part = self.forks.within(part, rho, wandered).x;
        let at = (bundles.layout.nodes[node as usize] - self.pith) / self.key.radius;
        EndNode {
            shared_outline: outline::SLIVERS.outline(kind, on_sliver.x)
                * self.bevel(number, on_sliver.y),
            fork_outline: outline::SLIVERS.outline(fork_kind, on_part),
            plate: if self.key.brittle {
                end.brittle_plate.at(at) + Plate::small(seed(self.key.seed, purpose::PLATE), at)
            } else {
                0.0
            },
            slab: self.slabs.height(end.slab as usize, rho, wandered) - end.slab_heights.0,
            own_outline: outline::BUNDLES.outline(own_kind, along),
            raggedness: noise::unit(
                seed(self.key.seed, purpose::SHAFT),
                i64::from(cell),
                i64::from(node),
                3,
            ),
            ..none
        }
    }
}

fn seed(seed: u64, purpose: u64) -> u64 {
    seed ^ purpose << 20
}
