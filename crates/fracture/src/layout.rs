//! Parting a section into fibre bundles: rings × sectors about the pith.
//!
//! The smooth layout is the grid of Yang 2019 §3.1. The fibrous layout gives every ring as many bundles as keep their
//! areas about equal, and shifts the bundles of neighbouring rings against each other like bricks: no more than three
//! meet at a corner, so however their heights fall, the steps between them form a manifold.

mod smooth;

pub use smooth::smooth;

use crate::surface::Layout;
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::rings::RingField;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Seeds of independent random numbers.
mod purpose {
    pub const WALL: u64 = 0x57a1;
    pub const TILT: u64 = 0x711f;
    pub const RING: u64 = 0x2149;
    pub const NODE: u64 = 0x40de;
    pub const SHIFT: u64 = 0x51f7;
}

/// What a layout is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutOptions {
    /// Number of rings N_ring.
    pub rings: usize,
    /// Number of sectors N_sec; in the fibrous layout those of the outermost ring.
    pub sectors: usize,
    /// Ring coordinates between which the layout must lie to hold all of the section and its relief.
    pub reach: (f64, f64),
    /// Distance from the pith that it must reach, m.
    pub radius: f64,
    /// Angles (rad) between which the section lies, where the pith is outside of it (a board); `None` for all around.
    pub arc: Option<(f64, f64)>,
    /// Ring coordinate at which the bark begins (fibrous layout); `None` where there is none (a board).
    pub bark: Option<f64>,
    /// Seed of the irregularity.
    pub seed: u64,
}

/// A fibre bundle of a layout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bundle {
    /// Number of its ring, 0 at the pith.
    pub ring: u32,
    /// Number of its sector in that ring.
    pub sector: u32,
    /// Ring coordinate of its middle.
    pub rho: f64,
    /// Angle of its middle, rad.
    pub phi: f64,
    /// Half its width along the ring, rad.
    pub half_width: f64,
    /// Whether it is bark.
    pub bark: bool,
}

/// A layout with what its nodes and cells stand for.
#[derive(Debug, Clone, Default)]
pub struct Bundles {
    /// The triangulation.
    pub layout: Arc<Layout>,
    /// Fibre bundles; [`Layout::cells`] indexes them.
    pub bundles: Vec<Bundle>,
    /// Ring coordinate and angle (rad) of every node.
    pub addresses: Vec<(f64, f64)>,
    /// Cosine and sine of the angle of every node.
    pub directions: Vec<DVec2>,
    /// For each bundle the node within it that carries its tip, or [`crate::surface::NONE`].
    pub tips: Vec<u32>,
}

/// Nodes as they are made.
struct Maker<'a> {
    field: &'a RingField,
    nodes: Vec<DVec2>,
    addresses: Vec<(f64, f64)>,
}

impl Maker<'_> {
    /// A node beyond the skin, so far out that a chord of the angle `gap` (rad) to the next stays there too.
    fn beyond(&mut self, options: &LayoutOptions, phi: f64, gap: f64) -> u32 {
        let (sin, cos) = libm::sincos(phi);
        let radius = 1.02 * options.radius / libm::cos((gap / 2.0).min(1.2));
        self.nodes
            .push(self.field.pith() + DVec2::new(cos, sin) * radius);
        self.addresses.push((options.reach.1, phi));
        self.nodes.len() as u32 - 1
    }

    fn node(&mut self, rho: f64, phi: f64) -> u32 {
        self.nodes.push(self.field.point(rho, phi));
        self.addresses.push((rho, phi));
        self.nodes.len() as u32 - 1
    }
}

fn directions(addresses: &[(f64, f64)]) -> Vec<DVec2> {
    let direction = |&(_, phi): &(f64, f64)| {
        let (sin, cos) = libm::sincos(phi);
        DVec2::new(cos, sin)
    };
    addresses.iter().map(direction).collect()
}

/// An irrational offset (rad), so that no ray runs exactly through a vertex of a symmetrical mesh.
const TURN: f64 = 0.011_318_29;

/// A ring of bundles between two boundaries.
struct Band {
    /// Ring coordinates of its inner and outer boundary.
    between: (f64, f64),
    /// Angles of the walls between its bundles at the inner and at the outer boundary, ascending.
    walls: Vec<(f64, f64)>,
    bark: bool,
}

/// Fibre bundles of about equal area, offset like bricks. They are as irregular as the section allows: where a facet
/// would fold over, all is made again with half the irregularity.
pub fn fibrous(field: &RingField, options: &LayoutOptions) -> Bundles {
    let mut irregular = 1.0;
    loop {
        let made = fibrous_with(field, options, irregular);
        let sound = made
            .layout
            .facets
            .iter()
            .all(|f| area(*f, &made.layout.nodes) > 0.0);
        if sound || irregular < 0.05 {
            return made;
        }
        irregular *= 0.5;
    }
}

fn fibrous_with(field: &RingField, options: &LayoutOptions, irregular: f64) -> Bundles {
    let bands = bands(options, irregular);
    let mut maker = Maker {
        field,
        nodes: Vec::new(),
        addresses: Vec::new(),
    };
    let around = options.arc.is_none();
    let mut build = Build {
        facets: Vec::new(),
        cells: Vec::new(),
        bundles: Vec::new(),
        tips: Vec::new(),
    };
    // The innermost bundle of a round stem surrounds the pith: its inner boundary is that one node.
    let mut inner = if around {
        Boundary {
            nodes: vec![(0.0, maker.node(0.0, 0.0))],
            ends: [Vec::new(), vec![0]],
        }
    } else {
        boundary(&mut maker, options, None, Some(&bands[0]), (0, irregular))
    };
    for (i, band) in bands.iter().enumerate() {
        let outer = boundary(
            &mut maker,
            options,
            Some(band),
            bands.get(i + 1),
            (i + 1, irregular),
        );
        fill_band(&mut maker, &mut build, band, i, &inner, &outer, around);
        inner = outer;
    }
    let layout = Layout::new(maker.nodes, build.facets, build.cells);
    Bundles {
        layout: Arc::new(layout),
        bundles: build.bundles,
        directions: directions(&maker.addresses),
        addresses: maker.addresses,
        tips: build.tips,
    }
}

struct Build {
    facets: Vec<[u32; 3]>,
    cells: Vec<u32>,
    bundles: Vec<Bundle>,
    tips: Vec<u32>,
}

/// Number of bundles around the pith in the first ring of a round stem.
const FEWEST: usize = 5;

fn bands(options: &LayoutOptions, irregular: f64) -> Vec<Band> {
    let around = options.arc.is_none();
    let start = if around {
        0.0
    } else {
        options.reach.0.max(0.0)
    };
    let rings = options.rings.max(2);
    let wood = options
        .bark
        .map_or(options.reach.1, |b| b.clamp(start + 0.05, 1.0));
    // Uneven ring boundaries: thin bands beside thick ones, as growth has it.
    let mut bounds = vec![start];
    for i in 0..rings {
        let random = noise::unit(options.seed ^ purpose::RING, i as i64, 0, 0) - 0.5;
        let width = 1.0 + 0.9 * irregular * random;
        bounds.push(bounds[i] + width);
    }
    let total = bounds[rings] - start;
    for b in &mut bounds {
        *b = start + (*b - start) / total * (wood - start);
    }
    if options.bark.is_some() {
        bounds.push(options.reach.1);
    }
    let (low, high) = options.arc.unwrap_or((0.0, TAU));
    (0..bounds.len() - 1)
        .map(|i| {
            let between = (bounds[i], bounds[i + 1]);
            let bark = i == rings;
            let middle = if bark {
                1.0
            } else {
                (between.0 + between.1) / 2.0
            };
            let thickness = if bark {
                1.0 / rings as f64
            } else {
                between.1 - between.0
            };
            // Equal areas: a thicker ring has fewer, wider … and so more numerous, shorter bundles.
            let share = middle * (thickness * rings as f64 / (wood - start)).sqrt();
            let wanted = (options.sectors as f64 * share).round() as usize;
            let count = match i {
                0 if around => 1,
                1 if around => wanted.clamp(FEWEST, 9),
                _ => wanted.max(if around { FEWEST } else { 3 }),
            };
            Band {
                between,
                walls: walls(options, i, count, (low, high), irregular),
                bark,
            }
        })
        .collect()
}

/// Angles of a band's walls, shifted at random and a little slanted.
fn walls(
    options: &LayoutOptions,
    band: usize,
    count: usize,
    (low, high): (f64, f64),
    irregular: f64,
) -> Vec<(f64, f64)> {
    let around = options.arc.is_none();
    let step = (high - low) / count as f64;
    let random =
        |what: u64, j: usize| noise::unit(options.seed ^ what, band as i64, j as i64, 1) - 0.5;
    let shift = if around {
        TURN + step * (random(purpose::SHIFT, 0) + 0.5)
    } else {
        0.0
    };
    if count == 1 && around {
        return vec![(shift, shift)];
    }
    (0..count + usize::from(!around))
        .map(|j| {
            let place = low + shift + step * j as f64;
            if !around && (j == 0 || j == count) {
                return (place, place);
            }
            let angle = place + 0.7 * irregular * step * random(purpose::WALL, j);
            let slant = 0.16 * irregular * step * random(purpose::TILT, j);
            (angle - slant, angle + slant)
        })
        .collect()
}

/// A ring boundary: its nodes by ascending angle, and which of them end the walls of the band inside and outside.
struct Boundary {
    nodes: Vec<(f64, u32)>,
    /// For the band inside, then the one outside: the place in `nodes` of each wall's end.
    ends: [Vec<usize>; 2],
}

fn boundary(
    maker: &mut Maker,
    options: &LayoutOptions,
    inside: Option<&Band>,
    outside: Option<&Band>,
    (number, irregular): (usize, f64),
) -> Boundary {
    let rho = inside.map_or_else(|| outside.map_or(0.0, |b| b.between.0), |b| b.between.1);
    let around = options.arc.is_none();
    let mut ends: Vec<(f64, usize, usize)> = Vec::new();
    // Angles from 0 to a turn, so that the ends of both bands sort together.
    let within = |angle: f64| {
        if around {
            angle - TAU * (angle / TAU).floor()
        } else {
            angle
        }
    };
    if let Some(band) = inside {
        ends.extend(
            band.walls
                .iter()
                .enumerate()
                .map(|(j, w)| (within(w.1), 0, j)),
        );
    }
    if let Some(band) = outside {
        ends.extend(
            band.walls
                .iter()
                .enumerate()
                .map(|(j, w)| (within(w.0), 1, j)),
        );
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let width = options.arc.map_or(TAU, |(a, b)| b - a);
    let least = 0.12 * width / ends.len() as f64;
    let last = ends.len() - 1;
    for i in 1..ends.len() {
        // The two borders of a board's arc are shared by both bands and may coincide.
        let shared = !around && (i == 1 || i == last);
        if !shared && ends[i].0 < ends[i - 1].0 + least {
            ends[i].0 = ends[i - 1].0 + least;
        }
    }
    let thin = inside
        .into_iter()
        .chain(outside)
        .map(|b| b.between.1 - b.between.0)
        .fold(f64::INFINITY, f64::min);
    // Chords must not sag by more than a fraction of the thinner band.
    let widest = if rho > 0.0 {
        2.0 * (0.5 * thin / rho).min(0.5).sqrt()
    } else {
        1.0
    };
    let last_one = outside.is_none();
    let mut result = Boundary {
        nodes: Vec::new(),
        ends: [Vec::new(), Vec::new()],
    };
    result.ends[0] = vec![0; inside.map_or(0, |b| b.walls.len())];
    result.ends[1] = vec![0; outside.map_or(0, |b| b.walls.len())];
    let jitter = |n: usize| {
        // The innermost boundary of a board must stay outside the wood.
        if inside.is_none() {
            return 0.0;
        }
        0.36 * irregular
            * thin
            * (noise::unit(options.seed ^ purpose::NODE, number as i64, n as i64, 2) - 0.5)
    };
    for i in 0..ends.len() {
        let (angle, which, j) = ends[i];
        let joined = !around && result.nodes.last().is_some_and(|n| n.0 == angle);
        if !joined {
            let n = result.nodes.len();
            let id = if last_one {
                maker.beyond(options, angle, widest)
            } else {
                maker.node(rho + jitter(n), angle)
            };
            result.nodes.push((angle, id));
        }
        result.ends[which][j] = result.nodes.len() - 1;
        let next = match ends.get(i + 1) {
            Some(next) => next.0,
            None if around => ends[0].0 + TAU,
            None => continue,
        };
        let more = ((next - angle) / widest).ceil() as usize;
        for m in 1..more {
            let between = angle + (next - angle) * m as f64 / more as f64;
            let n = result.nodes.len();
            let id = if last_one {
                maker.beyond(options, between, widest)
            } else {
                maker.node(rho + jitter(n), between)
            };
            result.nodes.push((between, id));
        }
    }
    result
}

impl Boundary {
    /// Nodes from wall `j` of the band on `side` to the next wall, with unwrapped angles.
    fn run(&self, side: usize, j: usize, around: bool) -> Vec<(f64, u32)> {
        let ends = &self.ends[side];
        let (from, to) = (ends[j], ends[(j + 1) % ends.len()]);
        let count = self.nodes.len();
        if count == 1 {
            return vec![self.nodes[0]];
        }
        let steps = if around && to <= from {
            to + count - from
        } else {
            to - from
        };
        (0..=steps)
            .map(|k| {
                let i = from + k;
                let turn = if i >= count { TAU } else { 0.0 };
                (self.nodes[i % count].0 + turn, self.nodes[i % count].1)
            })
            .collect()
    }
}

fn fill_band(
    maker: &mut Maker,
    build: &mut Build,
    band: &Band,
    number: usize,
    inner: &Boundary,
    outer: &Boundary,
    around: bool,
) {
    let count = if around {
        band.walls.len()
    } else {
        band.walls.len() - 1
    };
    for j in 0..count {
        let cell = build.bundles.len() as u32;
        let (mut low, high) = (inner.run(1, j, around), outer.run(0, j, around));
        let turns = TAU * ((high[0].0 - low[0].0) / TAU).round();
        low.iter_mut().for_each(|n| n.0 += turns);
        let first = build.facets.len();
        let (from, to) = (high[0].0, high[high.len() - 1].0);
        let rho = if band.bark {
            1.0
        } else {
            (band.between.0 + band.between.1) / 2.0
        };
        build.bundles.push(Bundle {
            ring: number as u32,
            sector: j as u32,
            rho,
            phi: (from + to) / 2.0,
            half_width: (to - from) / 2.0,
            bark: band.bark,
        });
        let tip = if number == 0 && around {
            for pair in high.windows(2) {
                build.facets.push([low[0].1, pair[0].1, pair[1].1]);
            }
            low[0].1
        } else {
            strip(&mut build.facets, &low, &high, &maker.nodes);
            if band.bark {
                crate::surface::NONE
            } else {
                add_tip(maker, &mut build.facets, first)
            }
        };
        build.tips.push(tip);
        build.cells.resize(build.facets.len(), cell);
    }
}

/// Triangles between two chains of rising angle.
fn strip(facets: &mut Vec<[u32; 3]>, low: &[(f64, u32)], high: &[(f64, u32)], nodes: &[DVec2]) {
    let (mut p, mut q) = (0, 0);
    while p + 1 < low.len() || q + 1 < high.len() {
        let above = high.get(q + 1).map(|b| [low[p].1, high[q].1, b.1]);
        let below = low.get(p + 1).map(|a| [low[p].1, high[q].1, a.1]);
        let advance_high = match (above, below) {
            (Some(above), Some(below)) => {
                let (a, b) = (area(above, nodes), area(below, nodes));
                // Both ways are open: the angle decides.
                if a > 0.0 && b > 0.0 {
                    high[q + 1].0 <= low[p + 1].0
                } else {
                    a > b
                }
            }
            (above, _) => above.is_some(),
        };
        if advance_high {
            facets.extend(above);
            q += 1;
        } else {
            facets.extend(below);
            p += 1;
        }
    }
}

/// Twice the signed area of a facet.
fn area(facet: [u32; 3], nodes: &[DVec2]) -> f64 {
    let [a, b, c] = facet.map(|n| nodes[n as usize]);
    (b - a).perp_dot(c - a)
}

/// Puts a node into the largest facet from `first` on and returns it: the tip of the bundle.
fn add_tip(maker: &mut Maker, facets: &mut Vec<[u32; 3]>, first: usize) -> u32 {
    let size = |f: usize| area(facets[f], &maker.nodes);
    let largest = (first..facets.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
    let Some(largest) = largest else {
        return crate::surface::NONE;
    };
    let [a, b, c] = facets[largest];
    let corners = [a, b, c].map(|n| maker.addresses[n as usize]);
    let near = corners[0].1;
    let wrap = |phi: f64| phi - TAU * ((phi - near) / TAU + 0.5).floor();
    let rho = (corners[0].0 + corners[1].0 + corners[2].0) / 3.0;
    let phi = (corners.iter().map(|x| wrap(x.1)).sum::<f64>()) / 3.0;
    let place = (0..3)
        .map(|i| maker.nodes[facets[largest][i] as usize])
        .sum::<DVec2>()
        / 3.0;
    maker.nodes.push(place);
    maker.addresses.push((rho, phi));
    let tip = maker.nodes.len() as u32 - 1;
    facets[largest] = [a, b, tip];
    facets.extend([[b, c, tip], [c, a, tip]]);
    tip
}

/// The angle brought to −π … π.
#[inline]
pub fn wrap(angle: f64) -> f64 {
    if (-PI..PI).contains(&angle) {
        return angle;
    }
    angle - TAU * ((angle + PI) / TAU).floor()
}
