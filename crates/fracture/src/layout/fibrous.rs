//! The fibrous layout: rings of bundles that are shifted against each other like bricks.

use super::bundles::{FibreBundle, FibreBundles, LayoutOptions};
use super::dips::below_skin;
use super::nodes::{NodeBuilder, RAY_OFFSET, directions};
use crate::surface::SectionLayout;
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::rings::RingField;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Seeds of independent random numbers.
mod purpose {
    pub const WALL: u64 = 0x57a1;
    pub const TILT: u64 = 0x711f;
    pub const RING: u64 = 0x2149;
    pub const NODE: u64 = 0x40de;
    pub const SHIFT: u64 = 0x51f7;
}

/// A ring of bundles between two boundaries.
struct RingBand {
    /// Ring coordinates of its inner and outer boundary.
    between: (f64, f64),
    /// Angles of the walls between its bundles at the inner and at the outer boundary, rad, ascending.
    walls: Vec<(f64, f64)>,
    /// Whether its outer boundary is the edge of an annual ring.
    at_ring: bool,
    bark: bool,
}

/// Lays out a section in fibre bundles of about equal area, shifted like bricks.
///
/// They are as uneven as the section allows: where a facet would fold over, the boundaries beside it get half the unevenness and
/// chords of half the length, and the layout is made again.
///
/// # Examples
/// ```
/// use greenstick_fracture::layout::{LayoutOptions, fibrous};
/// use greenstick_geometry::Context;
/// use greenstick_wood::stem::{StemLocation, StemOptions, find_stem};
///
/// let mesh = greenstick_wood::primitive::cylinder(0.02, 0.3, 24);
/// let middle = StemLocation::Fraction(0.5);
/// let stem = find_stem(&[mesh], &middle, &StemOptions::default(), &Context::quiet())?.stem;
/// let options = LayoutOptions {
///     rings: 4,
///     sectors: 16,
///     reach: (0.0, 1.0),
///     radius: stem.radius,
///     arc: None,
///     bark: Some(0.94),
///     bark_below: Vec::new(),
///     ring_edges: vec![0.3, 0.6, 1.0],
///     seed: 1,
/// };
/// let bundles = fibrous(&stem.rings, &options);
/// assert_eq!(bundles.bundles.len(), bundles.tips.len());
/// # Ok::<(), greenstick_wood::stem::StemError>(())
/// ```
pub fn fibrous(field: &RingField, options: &LayoutOptions) -> FibreBundles {
    let bands = bands(options);
    let mut fineness = vec![1.0; bands.len() + 1];
    loop {
        let made = fibrous_with(field, options, &bands, &fineness);
        let layout = &made.layout;
        let folded = (layout.facets.iter().zip(&layout.cells))
            .filter(|(facet, _)| area(**facet, &layout.nodes) <= 0.0)
            .map(|(_, &cell)| made.bundles[cell as usize].ring as usize);
        let mut again = false;
        let before = fineness.clone();
        for band in folded {
            for boundary in [band, band + 1] {
                if before[boundary] > MIN_FINENESS {
                    fineness[boundary] = 0.5 * before[boundary];
                    again = true;
                }
            }
        }
        if !again {
            return made;
        }
    }
}

/// How far a boundary is made finer and more even where facets fold over: chords of a thirty-second follow any outline that wood has.
const MIN_FINENESS: f64 = 1.0 / 32.0;

/// Lays out a section; `fineness` has for each boundary the factor of its unevenness and of the length of its chords.
fn fibrous_with(
    field: &RingField,
    options: &LayoutOptions,
    bands: &[RingBand],
    fineness: &[f64],
) -> FibreBundles {
    let mut builder = NodeBuilder {
        field,
        nodes: Vec::new(),
        addresses: Vec::new(),
    };
    let around = options.arc.is_none();
    let mut build = LayoutBuilder {
        facets: Vec::new(),
        cells: Vec::new(),
        bundles: Vec::new(),
        tips: Vec::new(),
    };
    // The innermost bundle of a round stem surrounds the pith: its inner boundary is that one node.
    let mut inner = if around {
        Boundary {
            nodes: vec![(0.0, builder.node(0.0, 0.0))],
            ends: [Vec::new(), vec![0]],
            before: Vec::new(),
        }
    } else {
        let first = (0, fineness[0]);
        boundary(&mut builder, options, None, Some(&bands[0]), first)
    };
    for (i, band) in bands.iter().enumerate() {
        let number = (i + 1, fineness[i + 1]);
        let outer = boundary(&mut builder, options, Some(band), bands.get(i + 1), number);
        fill_band(&mut builder, &mut build, band, i, &inner, &outer, around);
        inner = outer;
    }
    let layout = SectionLayout::new(builder.nodes, build.facets, build.cells);
    FibreBundles {
        layout: Arc::new(layout),
        bundles: build.bundles,
        directions: directions(&builder.addresses),
        addresses: builder.addresses,
        tips: build.tips,
        skin: None,
    }
}

/// Facets and bundles while they are made.
struct LayoutBuilder {
    facets: Vec<[u32; 3]>,
    cells: Vec<u32>,
    bundles: Vec<FibreBundle>,
    tips: Vec<u32>,
}

/// Least distance of the edge of an annual ring from the skin of a stem without bark, radii, for a boundary of bundles to lie there.
const LEAST_DEPTH: f64 = 0.01;

/// Least number of bundles in a ring around the pith.
const MIN_BUNDLES: usize = 5;

fn bands(options: &LayoutOptions) -> Vec<RingBand> {
    let around = options.arc.is_none();
    let start = if around {
        0.0
    } else {
        options.reach.0.max(0.0)
    };
    let rings = options.rings.max(2);
    // Where the pith lies far outside, as of a sheet, the wood is thin.
    let thinnest = (0.5 * (options.reach.1 - start)).min(0.05);
    let wood = options
        .bark
        .map_or(options.reach.1, |b| b.min(1.0).max(start + thinnest));
    // Uneven ring boundaries: thin bands beside thick ones, as growth has it.
    let mut bounds = vec![start];
    for i in 0..rings {
        let random = noise::unit(options.seed ^ purpose::RING, i as i64, 0, 0) - 0.5;
        let width = 1.0 + 0.9 * random;
        bounds.push(bounds[i] + width);
    }
    let total = bounds[rings] - start;
    for b in &mut bounds {
        *b = start + (*b - start) / total * (wood - start);
    }
    // The last ring of a stem without bark ends at its skin: a boundary there would run along it.
    let outermost = if around && options.bark.is_none() {
        1.0 - LEAST_DEPTH
    } else {
        f64::INFINITY
    };
    let ring_edges = &options.ring_edges;
    let within = ring_edges.partition_point(|&edge| edge < outermost);
    let at_rings = snap_to_rings(&mut bounds, &ring_edges[..within]);
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
            // A thicker ring has more bundles of less width, so that areas are equal.
            let share = middle * (thickness * rings as f64 / (wood - start)).sqrt();
            let wanted = (options.sectors as f64 * share).round() as usize;
            let count = match i {
                0 if around => 1,
                1 if around => wanted.clamp(MIN_BUNDLES, 9),
                _ => wanted.max(if around { MIN_BUNDLES } else { 3 }),
            };
            RingBand {
                between,
                walls: walls(options, i, count, (low, high), 0.5 * thickness / middle),
                at_ring: at_rings.get(i + 1) == Some(&true),
                bark,
            }
        })
        .collect()
}

/// Moves boundaries between bands to the edges of annual rings, and those between to even distances. Where the rings are
/// wider than bands, a boundary lies at each of their edges; where they are narrower, each boundary lies at an edge.
/// Returns which boundaries do.
fn snap_to_rings(bounds: &mut [f64], ring_edges: &[f64]) -> Vec<bool> {
    let last = bounds.len() - 1;
    let mut snapped = vec![false; bounds.len()];
    let (low, high) = (bounds[0], bounds[last]);
    let within = |e: &&f64| **e > low && **e < high;
    // Each edge wants the boundary nearest to it, and a boundary goes to the nearest edge that wants it, so that they stay
    // in order.
    let mut wanted: Vec<Option<f64>> = vec![None; bounds.len()];
    for &edge in ring_edges.iter().filter(within) {
        let above = bounds.partition_point(|&b| b < edge).clamp(1, last);
        let nearest = if edge - bounds[above - 1] < bounds[above] - edge {
            above - 1
        } else {
            above
        };
        let nearest = nearest.clamp(1, last - 1);
        let distance = |e: f64| (e - bounds[nearest]).abs();
        let here = &mut wanted[nearest];
        if here.is_none_or(|other| distance(edge) < distance(other)) {
            *here = Some(edge);
        }
    }
    for (i, edge) in wanted.into_iter().enumerate() {
        if let Some(edge) = edge {
            (bounds[i], snapped[i]) = (edge, true);
        }
    }
    let mut from = 0;
    for to in 1..=last {
        if snapped[to] || to == last {
            let (a, b) = (bounds[from], bounds[to]);
            let count = (to - from) as f64;
            for (i, bound) in (0..).zip(&mut bounds[from..to]) {
                *bound = a + (b - a) * f64::from(i) / count;
            }
            from = to;
        }
    }
    snapped
}

/// Returns the angles of a band's walls, shifted at random and slightly slanted, by up to `steepest`, rad.
fn walls(
    options: &LayoutOptions,
    band: usize,
    count: usize,
    (low, high): (f64, f64),
    steepest: f64,
) -> Vec<(f64, f64)> {
    let around = options.arc.is_none();
    let step = (high - low) / count as f64;
    let random =
        |what: u64, j: usize| noise::unit(options.seed ^ what, band as i64, j as i64, 1) - 0.5;
    let shift = if around {
        RAY_OFFSET + step * (random(purpose::SHIFT, 0) + 0.5)
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
            let angle = place + 0.7 * step * random(purpose::WALL, j);
            let slant = 0.16 * step * random(purpose::TILT, j);
            let slant = slant.clamp(-steepest, steepest);
            (angle - slant, angle + slant)
        })
        .collect()
}

/// A boundary between two rings: its nodes by ascending angle, and which of them end the walls of the bands on both sides.
struct Boundary {
    nodes: Vec<(f64, u32)>,
    /// For the band inside, then for the one outside: the index in `nodes` of each wall's end.
    ends: [Vec<usize>; 2],
    /// Nodes just beyond the bark of the section, one before each of `nodes`; empty where those lie no farther out.
    before: Vec<u32>,
}

/// The end of a wall at a boundary.
#[derive(Clone, Copy)]
struct WallEnd {
    /// Angle, rad.
    angle: f64,
    /// 0 for a wall of the band inside the boundary, 1 for one of the band outside.
    side: usize,
    /// Number of the wall in its band.
    wall: usize,
}

/// Returns the ends of the walls of both bands at the boundary between them, by angle and some distance apart.
fn wall_ends(
    options: &LayoutOptions,
    inside: Option<&RingBand>,
    outside: Option<&RingBand>,
) -> Vec<WallEnd> {
    let around = options.arc.is_none();
    // Angles from 0 to a turn, so that the ends of both bands sort together.
    let within = |angle: f64| {
        if around {
            angle - TAU * (angle / TAU).floor()
        } else {
            angle
        }
    };
    let inner = inside.iter().flat_map(|band| &band.walls).enumerate();
    let inner = inner.map(|(wall, w)| (within(w.1), 0, wall));
    let outer = outside.iter().flat_map(|band| &band.walls).enumerate();
    let outer = outer.map(|(wall, w)| (within(w.0), 1, wall));
    let mut ends: Vec<WallEnd> = (inner.chain(outer))
        .map(|(angle, side, wall)| WallEnd { angle, side, wall })
        .collect();
    ends.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    let width = options.arc.map_or(TAU, |(a, b)| b - a);
    let min_distance = 0.12 * width / ends.len() as f64;
    let last = ends.len() - 1;
    for i in 1..ends.len() {
        // The two borders of a board's arc are shared by both bands and may coincide.
        let shared = !around && (i == 1 || i == last);
        if !shared && ends[i].angle < ends[i - 1].angle + min_distance {
            ends[i].angle = ends[i - 1].angle + min_distance;
        }
    }
    ends
}

/// How far nodes are shifted across a boundary, in thicknesses of the thinner band: anywhere, and at the edge of an annual
/// ring, which tears more evenly than the wood between.
const UNEVENNESS: f64 = 0.36;
const RING_UNEVENNESS: f64 = 0.12;
/// The same under the outer bark: what that comes off is smooth.
const BARK_UNEVENNESS: f64 = 0.06;

/// Ring coordinate of nodes just beyond the bark of the section, and that of the outermost nodes from which on those are needed: bark
/// breaks on the slant, which facets that reach far beyond it would flatten.
pub(crate) const BEYOND_BARK: f64 = 1.08;
const FAR_BEYOND: f64 = 1.3;

/// Returns how far nodes are shifted across the boundary between two bands, in thicknesses of the thinner one.
fn unevenness(inside: Option<&RingBand>, outside: Option<&RingBand>) -> f64 {
    if outside.is_some_and(|band| band.bark) {
        BARK_UNEVENNESS
    } else if inside.is_some_and(|band| band.at_ring) {
        RING_UNEVENNESS
    } else {
        UNEVENNESS
    }
}

/// Makes the nodes of boundary `number` between two bands.
fn boundary(
    builder: &mut NodeBuilder,
    options: &LayoutOptions,
    inside: Option<&RingBand>,
    outside: Option<&RingBand>,
    (number, fineness): (usize, f64),
) -> Boundary {
    let rho = inside.map_or_else(|| outside.map_or(0.0, |b| b.between.0), |b| b.between.1);
    let around = options.arc.is_none();
    let ends = wall_ends(options, inside, outside);
    let thinner = inside
        .into_iter()
        .chain(outside)
        .map(|b| b.between.1 - b.between.0)
        .fold(f64::INFINITY, f64::min);
    // Chords must not sag by more than a fraction of the thinner band.
    let max_step = if rho > 0.0 {
        2.0 * fineness * (0.5 * thinner / rho).min(0.5).sqrt()
    } else {
        1.0
    };
    let jitter = |n: usize| {
        // The innermost boundary of a board must stay outside the wood.
        if inside.is_none() {
            return 0.0;
        }
        unevenness(inside, outside)
            * fineness
            * thinner
            * (noise::unit(options.seed ^ purpose::NODE, number as i64, n as i64, 2) - 0.5)
    };
    let is_outermost = outside.is_none();
    let is_far = is_outermost && inside.is_some_and(|b| b.bark) && rho > FAR_BEYOND;
    let mut before = Vec::new();
    let mut add = |nodes: &mut Vec<(f64, u32)>, angle: f64| {
        let node = if is_outermost {
            builder.beyond(options, angle, max_step)
        } else {
            builder.node(below_skin(options, rho + jitter(nodes.len()), angle), angle)
        };
        nodes.push((angle, node));
        if is_far {
            before.push(builder.node(BEYOND_BARK, angle));
        }
    };
    let mut result = Boundary {
        nodes: Vec::new(),
        ends: [
            vec![0; inside.map_or(0, |b| b.walls.len())],
            vec![0; outside.map_or(0, |b| b.walls.len())],
        ],
        before: Vec::new(),
    };
    for (i, end) in ends.iter().enumerate() {
        let angle = end.angle;
        let is_joined = !around && result.nodes.last().is_some_and(|n| n.0 == angle);
        if !is_joined {
            add(&mut result.nodes, angle);
        }
        result.ends[end.side][end.wall] = result.nodes.len() - 1;
        let next = match ends.get(i + 1) {
            Some(next) => next.angle,
            None if around => ends[0].angle + TAU,
            None => continue,
        };
        let steps = ((next - angle) / max_step).ceil() as usize;
        for m in 1..steps {
            add(
                &mut result.nodes,
                angle + (next - angle) * m as f64 / steps as f64,
            );
        }
    }
    result.before = before;
    result
}

impl Boundary {
    /// Returns the nodes before a [run](Boundary::run) of the band inside, just beyond the bark; `None` where there are none.
    fn run_before(&self, run: &[(f64, u32)], j: usize) -> Option<Vec<(f64, u32)>> {
        let from = self.ends[0][j];
        let node = |(k, &(angle, _)): (usize, &(f64, u32))| {
            let node = self.before.get((from + k) % self.nodes.len())?;
            Some((angle, *node))
        };
        run.iter().enumerate().map(node).collect()
    }

    /// Returns the nodes from wall `j` of the band on `side` to the next wall, with unwrapped angles.
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
    builder: &mut NodeBuilder,
    build: &mut LayoutBuilder,
    band: &RingBand,
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
        build.bundles.push(FibreBundle {
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
            if let Some(before) = outer.run_before(&high, j) {
                strip(&mut build.facets, &low, &before, &builder.nodes);
                low = before;
            }
            strip(&mut build.facets, &low, &high, &builder.nodes);
            if band.bark {
                crate::surface::NONE
            } else {
                add_tip(builder, &mut build.facets, first)
            }
        };
        build.tips.push(tip);
        build.cells.resize(build.facets.len(), cell);
    }
}

/// Adds the triangles between two chains of ascending angle.
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

/// Returns twice the signed area of a facet.
fn area(facet: [u32; 3], nodes: &[DVec2]) -> f64 {
    let [a, b, c] = facet.map(|n| nodes[n as usize]);
    (b - a).perp_dot(c - a)
}

/// Adds the tip of a bundle: a node inside its largest facet, of those from `first` on. Returns the node.
fn add_tip(builder: &mut NodeBuilder, facets: &mut Vec<[u32; 3]>, first: usize) -> u32 {
    let size = |f: usize| area(facets[f], &builder.nodes);
    let largest = (first..facets.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
    let Some(largest) = largest else {
        return crate::surface::NONE;
    };
    let [a, b, c] = facets[largest];
    let place = (0..3)
        .map(|i| builder.nodes[facets[largest][i] as usize])
        .sum::<DVec2>()
        / 3.0;
    builder.nodes.push(place);
    builder.addresses.push(builder.field.address(place));
    let tip = builder.nodes.len() as u32 - 1;
    facets[largest] = [a, b, tip];
    facets.extend([[b, c, tip], [c, a, tip]]);
    tip
}
