//! The section of a bundle as columns: the Voronoi cells of the rods, each parted into finer fibre bundles, clipped by
//! the stem's outline (Sutherland 2012 §5.1.1, with the stem's own contour in place of a hull).
//!
//! Columns run along the grain. They share corners: a corner is a line along the grain, and where three columns meet in
//! one, it is one for all three.

use glam::DVec2;
use greenstick_fibre::placement::{VoronoiCell, voronoi_cells};
use greenstick_geometry::Unions;
use greenstick_wood::noise::unit;
use std::collections::{BTreeMap, BTreeSet};

/// The side of a column that lies on the outline.
pub const OUTSIDE: u32 = u32::MAX;

/// A fibre bundle: part of a rod's cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The rod of the unbroken bundle that it is a part of.
    pub rod: u32,
    /// Corners, counter-clockwise.
    pub corners: Vec<u32>,
    /// The column beyond the side from each corner to the next, or [`OUTSIDE`].
    pub beyond: Vec<u32>,
    /// Centroid, m.
    pub centre: DVec2,
    /// Area, m².
    pub area: f64,
}

/// A section parted into columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// Places of the corners in the section, grain coordinates, m.
    pub corners: Vec<DVec2>,
    /// The columns.
    pub columns: Vec<Column>,
    /// Whether each corner lies on the outline.
    pub outer: Vec<bool>,
    /// Mean distance between columns, m.
    pub spacing: f64,
}

/// Corners nearer to each other than this part of the mean distance between columns are the same, computed twice.
const SAME: f64 = 1e-7;
/// Corners nearer than this part are drawn together, so that no side is a sliver.
const NEAR: f64 = 0.03;
/// How many times wider along the ring fibre bundles are than across it: earlywood lets go first.
const FLAT: f64 = 3.0;
/// How far bundles lie off their rows across the ring, and off even spacing along it, in their own measures.
const UNEVEN: [f64; 2] = [0.22, 0.3];

/// Pairs of rods with bonds between them, the smaller number first.
pub type Bonded = BTreeSet<(u32, u32)>;

/// Parts the section with the rods' `cells` and the `outline` (m, counter-clockwise, not closed) into about `fibres`
/// columns a rod, wide along the rings about `pith` and thin across; 1 gives the cells themselves. Columns are given to rods so that neighbours are `bonded` where that can
/// be had.
pub fn columns(
    rods: &[VoronoiCell],
    outline: &[DVec2],
    bonded: &Bonded,
    fibres: u32,
    pith: DVec2,
    seed: u64,
) -> Columns {
    let centres: Vec<DVec2> = rods.iter().map(|c| c.centroid).collect();
    let area: f64 = rods.iter().map(|c| c.area).sum();
    let (found, of) = if fibres <= 1 || rods.is_empty() {
        (rods.to_vec(), (0..rods.len() as u32).collect())
    } else {
        let wanted = f64::from(fibres) * rods.len() as f64;
        let mut points = bundles(outline, pith, area / wanted, seed);
        // A rod without a column would have no skin.
        let mut has = vec![false; rods.len()];
        for &p in &points {
            has[nearest(&centres, p)] = true;
        }
        points.extend(
            centres
                .iter()
                .zip(&has)
                .filter(|(_, h)| !**h)
                .map(|(c, _)| *c),
        );
        let of: Vec<u32> = points
            .iter()
            .map(|&p| nearest(&centres, p) as u32)
            .collect();
        (voronoi_cells(outline, &points), of)
    };
    let spacing = (area / found.len().max(1) as f64).sqrt();
    let mut made = weld(&found, &of, outline, spacing);
    made.hand_over(bonded, rods.len());
    made
}

/// Places of fibre bundles of about `area` (m²): in rows along the rings about `pith`, those of one row apart from those
/// beside it, so that three meet in a corner.
fn bundles(outline: &[DVec2], pith: DVec2, area: f64, seed: u64) -> Vec<DVec2> {
    let (across, along) = ((area / FLAT).sqrt(), (area * FLAT).sqrt());
    let far = outline.iter().map(|p| p.distance(pith)).fold(0.0, f64::max);
    // Seen from a pith outside, as that of a board is, the section takes up a part of the circle only.
    let middle = outline.iter().sum::<DVec2>() / outline.len().max(1) as f64 - pith;
    let half = if inside(outline, pith) {
        std::f64::consts::PI
    } else {
        (outline.iter())
            .map(|&p| middle.angle_to(p - pith).abs())
            .fold(0.0, f64::max)
    };
    let near = if inside(outline, pith) {
        0.0
    } else {
        distance_to(outline, pith)
    };
    let start = libm::atan2(middle.y, middle.x) - half;
    let mut points = Vec::new();
    let first = (near / across).floor() as i64;
    for row in first..=(far / across).ceil() as i64 {
        let r = (row as f64 + 0.5) * across;
        let count = (2.0 * half * r / along).round().max(1.0) as i64;
        let step = 2.0 * half / count as f64;
        let offset = unit(seed ^ 0xb0f, row, 0, 0);
        for k in 0..count {
            let off = |what: u64, part: f64| part * (2.0 * unit(seed ^ what, row, k, 1) - 1.0);
            let angle = start + (k as f64 + offset + off(0xb1f, UNEVEN[1])) * step;
            let r = r + off(0xb2f, UNEVEN[0]) * across;
            let (sin, cos) = libm::sincos(angle);
            let p = pith + r * DVec2::new(cos, sin);
            if inside(outline, p) {
                points.push(p);
            }
        }
    }
    points
}

/// Whether a place is inside of an outline.
fn inside(outline: &[DVec2], p: DVec2) -> bool {
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossed = ends.filter(|(a, b)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

/// Rounds in which columns between rods that were never bonded are given to others.
const ROUNDS: usize = 8;

impl Columns {
    /// Where columns of two rods meet that were never bonded, because the border between rods follows their columns,
    /// gives one of the columns to a rod beside it that is bonded with more of its neighbours.
    fn hand_over(&mut self, bonded: &Bonded, rods: usize) {
        let mut left = vec![0u32; rods];
        self.columns.iter().for_each(|c| left[c.rod as usize] += 1);
        for _ in 0..ROUNDS {
            let mut changed = false;
            for a in 0..self.columns.len() {
                let beside: Vec<u32> = (self.columns[a].beyond.iter())
                    .filter_map(|&b| self.columns.get(b as usize))
                    .map(|c| c.rod)
                    .collect();
                let strange = |rod: u32| {
                    let apart = |&o: &u32| o != rod && !bonded.contains(&(o.min(rod), o.max(rod)));
                    beside.iter().copied().filter(apart).count()
                };
                let own = self.columns[a].rod;
                let (now, best) = (strange(own), beside.iter().map(|&r| (strange(r), r)).min());
                if let Some((fewer, rod)) = best
                    && fewer < now
                    && left[own as usize] > 1
                {
                    left[own as usize] -= 1;
                    left[rod as usize] += 1;
                    self.columns[a].rod = rod;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
    }
}

/// The different places of all cells' corners, those nearer than `same` (m) being one, and the number of each corner's.
fn same_places(cells: &[VoronoiCell], same: f64) -> (Vec<DVec2>, Vec<u32>) {
    let mut places: Vec<DVec2> = Vec::new();
    let mut number = Vec::new();
    // By the square of side 4 × `same` that they lie in; those that are one may lie in neighbouring ones.
    let mut boxes: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
    let size = 4.0 * same.max(f64::MIN_POSITIVE);
    for &p in cells.iter().flat_map(|c| &c.corners) {
        let (x, y) = ((p.x / size).floor() as i64, (p.y / size).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (x + i, y + j)));
        let known = around
            .filter_map(|b| boxes.get(&b))
            .flatten()
            .copied()
            .find(|&c| places[c as usize].distance_squared(p) <= same * same);
        number.push(known.unwrap_or_else(|| {
            places.push(p);
            let new = places.len() as u32 - 1;
            boxes.entry((x, y)).or_default().push(new);
            new
        }));
    }
    (places, number)
}

/// For each place the one that stands for it: places no farther apart than `near` (m) are drawn together, the nearest
/// first, as long as what stands for them all is no larger.
fn cluster(places: &[DVec2], near: f64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (places[a as usize], places[b as usize]);
        p.x.total_cmp(&q.x)
            .then(p.y.total_cmp(&q.y))
            .then(a.cmp(&b))
    });
    let mut pairs: Vec<(f64, u32, u32)> = Vec::new();
    for (i, &a) in order.iter().enumerate() {
        let p = places[a as usize];
        let beside = order[i + 1..]
            .iter()
            .take_while(|&&b| places[b as usize].x - p.x <= near);
        for &b in beside {
            let d = p.distance(places[b as usize]);
            if d <= near {
                pairs.push((d, a.min(b), a.max(b)));
            }
        }
    }
    pairs.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut unions = Unions::new(places.len());
    let mut bounds: Vec<(DVec2, DVec2)> = places.iter().map(|&p| (p, p)).collect();
    for (_, a, b) in pairs {
        let (a, b) = (unions.root(a) as usize, unions.root(b) as usize);
        let (low, high) = (bounds[a].0.min(bounds[b].0), bounds[a].1.max(bounds[b].1));
        if a != b && low.distance(high) <= near {
            unions.join(a as u32, b as u32);
            bounds[a.min(b)] = (low, high);
        }
    }
    (0..places.len() as u32).map(|i| unions.root(i)).collect()
}

/// How far `p` is from a closed outline, m.
fn distance_to(outline: &[DVec2], p: DVec2) -> f64 {
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    ends.map(|(&a, &b)| {
        let side = b - a;
        let t = (p - a).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
        (a + side * t.clamp(0.0, 1.0)).distance(p)
    })
    .fold(f64::INFINITY, f64::min)
}

fn nearest(points: &[DVec2], p: DVec2) -> usize {
    let far = |q: &DVec2| q.distance_squared(p);
    let all = points.iter().enumerate();
    all.min_by(|a, b| far(a.1).total_cmp(&far(b.1)))
        .map_or(0, |(i, _)| i)
}

/// Gives corners of different cells that lie at one place one number, and finds each side's other cell.
fn weld(cells: &[VoronoiCell], of: &[u32], outline: &[DVec2], spacing: f64) -> Columns {
    let (places, number) = same_places(cells, SAME * spacing);
    let near = cluster(&places, NEAR * spacing);
    let mut made = Columns {
        spacing,
        ..Columns::default()
    };
    let mut named = vec![OUTSIDE; places.len()];
    let mut at = 0;
    for (cell, &rod) in cells.iter().zip(of) {
        let mut corners: Vec<u32> = Vec::new();
        for _ in &cell.corners {
            let root = near[number[at] as usize] as usize;
            at += 1;
            if named[root] == OUTSIDE {
                named[root] = made.corners.len() as u32;
                made.corners.push(places[root]);
            }
            if corners.last() != Some(&named[root]) {
                corners.push(named[root]);
            }
        }
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            continue;
        }
        made.columns.push(Column {
            rod,
            beyond: vec![OUTSIDE; corners.len()],
            corners,
            centre: cell.centroid,
            area: cell.area,
        });
    }
    let same = NEAR * spacing;
    made.outer = made
        .corners
        .iter()
        .map(|&p| distance_to(outline, p) <= same)
        .collect();
    let mut sides: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (number, column) in made.columns.iter().enumerate() {
        for (a, b) in column.sides() {
            sides.insert((a, b), number as u32);
        }
    }
    for column in &mut made.columns {
        let pairs: Vec<(u32, u32)> = column.sides().collect();
        for (k, (a, b)) in pairs.into_iter().enumerate() {
            if let Some(&other) = sides.get(&(b, a)) {
                column.beyond[k] = other;
            }
        }
    }
    made
}

impl Column {
    /// Sides from corner to corner, counter-clockwise.
    pub fn sides(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Diameter of the circle of the same area, m.
    pub fn width(&self) -> f64 {
        2.0 * (self.area / std::f64::consts::PI).sqrt()
    }
}
