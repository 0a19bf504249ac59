//! What of the torn ends of fibre bundles does not depend on heights: which slab and sliver each belongs to, the
//! outlines that run over it, and its random numbers. It is made once for a layout and kept for the next break.

use crate::heights::{HeightCache, Walks, purpose, unit};
use crate::layout::{Bundle, Bundles, wrap};
use crate::parameters::BreakParameters;
use crate::slabs::{Parts, Slabs, Span};
use crate::strips::{Strips, outline};
use crate::surface::{Layout, NONE};
use glam::DVec2;
use greenstick_wood::noise;
use std::sync::Arc;

/// What ends are made from beside the layout.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    seed: u64,
    slabs: usize,
    slivers: usize,
    aspect: f64,
    strips: usize,
    radius: f64,
    pith: DVec2,
}

/// Ends of the bundles of a layout.
#[derive(Debug)]
pub(crate) struct Ends {
    layout: Arc<Layout>,
    key: Key,
    pub pith: DVec2,
    /// Middle of the section and half its width (m), for sections without a pith in them.
    board: Option<(DVec2, f64)>,
    pub slabs: Slabs,
    pub slivers: Parts,
    pub strips: Strips,
    /// Ring coordinate of the outermost wood under bark; `None` where there is no bark.
    pub wood: Option<f64>,
    /// One for each bundle.
    pub bundles: Vec<End>,
    /// Every node of every bundle.
    pub rims: Vec<Rim>,
    /// For each corner of each facet its number in `rims`.
    pub corners: Vec<[u32; 3]>,
}

/// The end of a bundle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct End {
    /// Its sliver.
    pub sliver: u32,
    /// Its slab, the slab's height there and in the middle of the sliver.
    pub slab: u32,
    pub slab_heights: (f64, f64),
    /// Random numbers of its sliver: how short it is, how long, and the height of its outline.
    pub of_sliver: [f64; 3],
    /// Random numbers of its fibres.
    pub fibres: [f64; 3],
    /// Random numbers of its crushing and of its depth in a split.
    pub crushed: [f64; 2],
    /// How far it steps against others of its ring, −1 to 1.
    pub step: f64,
    /// How ragged the edge of the compression shelf is there.
    pub shelf: f64,
    /// The strip of bark that it lies under or is part of, and where that ends there.
    pub strip: u32,
    pub edge: f64,
    /// Random numbers of the string of inner bark that it is part of.
    pub string: [f64; 2],
}

/// A node of a bundle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rim {
    pub node: u32,
    pub cell: u32,
    /// Outline of the sliver, or of the strip where the bundle is bark.
    pub over: f64,
    /// Outline of the bundle's own end, and how ragged it is.
    pub own: f64,
    pub ragged: f64,
}

/// The angle of a place, `at` in ring coordinates, on rays that wander, so that slabs do not end on straight lines to
/// the pith.
pub(crate) fn wandered(walks: &mut Walks, phi: f64, at: DVec2) -> f64 {
    phi + 0.16 * walks.wander.at(at * 3.5)
}

impl Ends {
    /// The ends of `bundles`: the cached ones where nothing has changed that they depend on. `radius` and `pith` are
    /// the stem's, m.
    pub fn cached(
        bundles: &Bundles,
        p: &BreakParameters,
        walks: &mut Walks,
        (radius, pith): (f64, DVec2),
        cache: &mut HeightCache,
    ) -> Arc<Ends> {
        let key = Key {
            seed: p.seed,
            slabs: p.slab_count as usize,
            slivers: p.sliver_count as usize,
            aspect: p.bundle_aspect,
            strips: p.bark_strips as usize,
            radius,
            pith,
        };
        if let Some(ends) = &cache.ends
            && ends.key == key
            && Arc::ptr_eq(&ends.layout, &bundles.layout)
        {
            return ends.clone();
        }
        let ends = Arc::new(Ends::new(bundles, p, walks, key));
        cache.ends = Some(ends.clone());
        ends
    }

    fn new(bundles: &Bundles, p: &BreakParameters, walks: &mut Walks, key: Key) -> Ends {
        let span = Span::of(&bundles.bundles);
        let barked = bundles.bundles.iter().any(|b| b.bark);
        let wood = (bundles.bundles.iter().filter(|b| !b.bark))
            .map(|b| b.rho)
            .fold(0.0, f64::max);
        let pith = match (span.phi, bundles.layout.nodes.first()) {
            (None, Some(&node)) => node,
            _ => key.pith,
        };
        let mut ends = Ends {
            layout: bundles.layout.clone(),
            key,
            pith,
            board: span.phi.map(|_| middle_of(bundles)),
            slabs: Slabs::new(&span, key.slabs, key.seed),
            slivers: Parts::new(
                &span,
                key.slivers,
                key.aspect,
                seed(key.seed, purpose::SLIVER),
            ),
            strips: Strips::new(p),
            wood: barked.then_some(wood),
            bundles: Vec::new(),
            rims: Vec::new(),
            corners: Vec::new(),
        };
        let made = (0..bundles.bundles.len()).map(|i| ends.end(bundles, i, walks));
        ends.bundles = made.collect();
        ends.walk_rims(bundles, walks);
        ends
    }

    fn random(&self, purpose: u64, a: i64, b: i64) -> f64 {
        noise::unit(seed(self.key.seed, purpose), a, b, 0)
    }

    /// The place of a bundle's middle, m.
    pub fn middle(&self, bundles: &Bundles, index: usize, unit: DVec2) -> DVec2 {
        match bundles.tips[index] {
            NONE => unit * self.key.radius + self.pith,
            tip => bundles.layout.nodes[tip as usize],
        }
    }

    /// A place (`unit` in ring coordinates, `at` in m) as the compression shelf counts it.
    pub fn across(&self, unit: DVec2, at: DVec2) -> DVec2 {
        self.board
            .map_or(unit, |(middle, half)| (at - middle) / half)
    }

    fn end(&self, bundles: &Bundles, index: usize, walks: &mut Walks) -> End {
        let bundle = &bundles.bundles[index];
        let strip = self.strips.find(bundle.phi);
        let rho = bundle.rho.min(1.0);
        let unit = unit(rho, bundle.phi);
        if bundle.bark {
            return End {
                strip: strip as u32,
                ..End::default()
            };
        }
        let key = index as i64;
        let wandered = wandered(walks, bundle.phi, unit);
        let number = self.slivers.find(rho, wandered);
        let (ring, ray) = self.slivers.middle(number);
        let (slab, height) = self.slabs.at(rho, wandered);
        let shared = self.slabs.at(ring, ray).1;
        let sliver = |what: i64| self.random(purpose::GROUP, number as i64, what);
        let place = self.across(unit, self.middle(bundles, index, unit));
        let pair = i64::from(bundle.sector / 2);
        End {
            sliver: number as u32,
            slab: slab as u32,
            slab_heights: (height, shared),
            of_sliver: [sliver(9), sliver(0), sliver(1)],
            fibres: [1, 2, 3].map(|n| self.random(purpose::FIBRE, key, n)),
            crushed: [1, 7].map(|n| self.random(purpose::SHELF, key, n)),
            step: noise::value_1d(
                seed(self.key.seed, purpose::STEP) + u64::from(bundle.ring),
                bundle.phi * 0.8,
            ),
            shelf: walks.shelf.at(place * 3.0),
            strip: strip as u32,
            edge: if self.wood.is_some() {
                self.strips.edge(strip, bundle.phi)
            } else {
                0.0
            },
            string: [i64::from(bundle.ring), 1].map(|n| self.random(purpose::BARK, pair, n)),
        }
    }

    /// Finds the nodes of every bundle.
    fn walk_rims(&mut self, bundles: &Bundles, walks: &mut Walks) {
        let nodes = bundles.addresses.iter().zip(&bundles.directions);
        let rays: Vec<f64> = nodes
            .map(|(&(rho, phi), &direction)| wandered(walks, phi, direction * rho))
            .collect();
        // Facets of a bundle follow each other, so the last number given at a node is most often the one asked for.
        let mut last = vec![(NONE, 0); bundles.layout.nodes.len()];
        let facets = bundles.layout.facets.iter();
        let mut rims: Vec<Rim> = Vec::with_capacity(bundles.layout.facets.len());
        let corners = facets.zip(&bundles.layout.cells).map(|(facet, &cell)| {
            facet.map(|n| {
                let known = &mut last[n as usize];
                if known.0 != cell {
                    *known = (cell, rims.len() as u32);
                    rims.push(self.rim(bundles, (cell, n), rays[n as usize]));
                }
                known.1
            })
        });
        let corners = corners.collect();
        (self.corners, self.rims) = (corners, rims);
    }

    /// A node of a bundle; its angle on rays that wander is `wandered`.
    fn rim(&self, bundles: &Bundles, (cell, node): (u32, u32), wandered: f64) -> Rim {
        let bundle: &Bundle = &bundles.bundles[cell as usize];
        let end = &self.bundles[cell as usize];
        let (rho, phi) = bundles.addresses[node as usize];
        let none = Rim {
            node,
            cell,
            over: 0.0,
            own: 0.0,
            ragged: 0.0,
        };
        if bundle.bark {
            let over = self.strips.edge(end.strip as usize, phi);
            return Rim { over, ..none };
        }
        let number = end.sliver as usize;
        let kind = self.random(purpose::GROUP, number as i64, 2);
        let own_kind = self.random(purpose::FIBRE, i64::from(cell), 4);
        let off = wrap(phi - bundle.phi);
        let along = (off / bundle.half_width.max(1e-9)).clamp(-1.0, 1.0);
        Rim {
            over: outline(kind, self.slivers.within(number, rho, wandered).x),
            own: outline(own_kind, along),
            ragged: noise::unit(
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
