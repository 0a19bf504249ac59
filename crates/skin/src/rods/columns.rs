//! The section of a bundle as columns: the Voronoi cells of the rods, each split into finer fibre bundles and clipped by the
//! stem's outline (Sutherland 2012 §5.1.1, with the stem's own contour in place of a hull).
//!
//! Columns run along the grain. Their corners are lines along the grain, which all columns that meet there share.

use glam::DVec2;
use greenstick_fibre::placement::{VoronoiCell, voronoi_cells};
use greenstick_geometry::Unions;
use greenstick_wood::noise::unit;
use std::collections::{BTreeMap, BTreeSet};

/// The column beyond a side that lies on the outline.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// A fibre bundle: part of a rod's cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The rod of the unbroken bundle that it is a part of.
    pub rod: u32,
    /// Corners, counter-clockwise.
    pub corners: Vec<u32>,
    /// The column beyond the side from each corner to the next, or `OUTSIDE`.
    pub beyond: Vec<u32>,
    /// Centroid, m.
    pub centre: DVec2,
    /// Area, m².
    pub area: f64,
}

/// A section split into columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// Positions of the corners in the section, grain coordinates, m.
    pub corners: Vec<DVec2>,
    /// The columns.
    pub columns: Vec<Column>,
    /// Whether each corner lies on the outline.
    pub outer: Vec<bool>,
    /// Mean distance between columns, m.
    pub spacing: f64,
}

/// Corners nearer to each other than this part of the mean distance between columns are one corner, computed twice.
const WELD_DISTANCE: f64 = 1e-7;
/// Corners nearer than this part are merged, so that no side is a sliver.
const MERGE_DISTANCE: f64 = 0.03;
/// Width of fibre bundles along the ring over that across it: earlywood breaks first.
const BUNDLE_ASPECT: f64 = 3.0;
/// Greatest deviation of bundles from their rows across the ring, and from even spacing along it, in their own sizes.
const UNEVENNESS: [f64; 2] = [0.22, 0.3];

/// Pairs of rods with bonds between them, the smaller number first.
pub type BondedRods = BTreeSet<(u32, u32)>;

/// Splits a section into about `fibres` columns for each rod; 1 gives the rods' cells themselves.
///
/// `rods` are the cells of the rods and `outline` bounds the section (m, counter-clockwise, not closed). Columns are wide
/// along the rings about `pith` and thin across them. They are assigned to rods so that neighbours are `bonded` where
/// possible.
pub fn columns(
    rods: &[VoronoiCell],
    outline: &[DVec2],
    bonded: &BondedRods,
    fibres: u32,
    pith: DVec2,
    seed: u64,
) -> Columns {
    let centres: Vec<DVec2> = rods.iter().map(|c| c.centroid).collect();
    let area: f64 = rods.iter().map(|c| c.area).sum();
    let (column_cells, rod_of) = if fibres <= 1 || rods.is_empty() {
        (rods.to_vec(), (0..rods.len() as u32).collect())
    } else {
        let wanted = f64::from(fibres) * rods.len() as f64;
        let mut points = bundle_positions(outline, pith, area / wanted, seed);
        // A rod without a column would have no skin.
        let mut has_column = vec![false; rods.len()];
        for &p in &points {
            has_column[nearest(&centres, p)] = true;
        }
        points.extend(
            centres
                .iter()
                .zip(&has_column)
                .filter(|(_, has)| !**has)
                .map(|(c, _)| *c),
        );
        let rod_of: Vec<u32> = points
            .iter()
            .map(|&p| nearest(&centres, p) as u32)
            .collect();
        (voronoi_cells(outline, &points), rod_of)
    };
    let spacing = (area / column_cells.len().max(1) as f64).sqrt();
    let mut columns = weld(&column_cells, &rod_of, outline, spacing);
    columns.reassign_unbonded(bonded, rods.len());
    columns
}

/// Returns the positions of fibre bundles of about `area` (m²), in rows along the rings about `pith`. Neighbouring rows are
/// shifted against each other, so that three bundles meet in a corner.
fn bundle_positions(outline: &[DVec2], pith: DVec2, area: f64, seed: u64) -> Vec<DVec2> {
    let (across, along) = ((area / BUNDLE_ASPECT).sqrt(), (area * BUNDLE_ASPECT).sqrt());
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
            let angle = start + (k as f64 + offset + off(0xb1f, UNEVENNESS[1])) * step;
            let r = r + off(0xb2f, UNEVENNESS[0]) * across;
            let (sin, cos) = libm::sincos(angle);
            let p = pith + r * DVec2::new(cos, sin);
            if inside(outline, p) {
                points.push(p);
            }
        }
    }
    points
}

/// Whether a point is inside an outline.
fn inside(outline: &[DVec2], p: DVec2) -> bool {
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossed = ends.filter(|(a, b)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

/// Most rounds in which columns between rods that were never bonded are assigned to other rods.
const MAX_ROUNDS: usize = 8;

impl Columns {
    /// Where columns of two rods meet that were never bonded, because the border between rods follows their columns,
    /// assigns one of the columns to a neighbouring rod that is bonded with more of its neighbours.
    fn reassign_unbonded(&mut self, bonded: &BondedRods, rods: usize) {
        let mut column_count = vec![0u32; rods];
        self.columns
            .iter()
            .for_each(|c| column_count[c.rod as usize] += 1);
        for _ in 0..MAX_ROUNDS {
            let mut changed = false;
            for a in 0..self.columns.len() {
                let beside: Vec<u32> = (self.columns[a].beyond.iter())
                    .filter_map(|&b| self.columns.get(b as usize))
                    .map(|c| c.rod)
                    .collect();
                let unbonded = |rod: u32| {
                    let apart = |&o: &u32| o != rod && !bonded.contains(&(o.min(rod), o.max(rod)));
                    beside.iter().copied().filter(apart).count()
                };
                let own = self.columns[a].rod;
                let (now, best) = (
                    unbonded(own),
                    beside.iter().map(|&r| (unbonded(r), r)).min(),
                );
                if let Some((fewer, rod)) = best
                    && fewer < now
                    && column_count[own as usize] > 1
                {
                    column_count[own as usize] -= 1;
                    column_count[rod as usize] += 1;
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

/// Returns the distinct positions of all cells' corners, and for each corner the number of its position. Corners nearer than
/// `tolerance` (m) have one position.
fn distinct_positions(cells: &[VoronoiCell], tolerance: f64) -> (Vec<DVec2>, Vec<u32>) {
    let mut positions: Vec<DVec2> = Vec::new();
    let mut number = Vec::new();
    // By the square of side 4 × `tolerance` that they lie in; corners of one position may lie in neighbouring squares.
    let mut boxes: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
    let size = 4.0 * tolerance.max(f64::MIN_POSITIVE);
    for &p in cells.iter().flat_map(|c| &c.corners) {
        let (x, y) = ((p.x / size).floor() as i64, (p.y / size).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (x + i, y + j)));
        let known = around
            .filter_map(|b| boxes.get(&b))
            .flatten()
            .copied()
            .find(|&c| positions[c as usize].distance_squared(p) <= tolerance * tolerance);
        number.push(known.unwrap_or_else(|| {
            positions.push(p);
            let new = positions.len() as u32 - 1;
            boxes.entry((x, y)).or_default().push(new);
            new
        }));
    }
    (positions, number)
}

/// Returns for each position the one that represents it. Positions no farther apart than `max_size` (m) are merged, the
/// nearest first, as long as no cluster is larger than that.
fn cluster(positions: &[DVec2], max_size: f64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (positions[a as usize], positions[b as usize]);
        p.x.total_cmp(&q.x)
            .then(p.y.total_cmp(&q.y))
            .then(a.cmp(&b))
    });
    let mut pairs: Vec<(f64, u32, u32)> = Vec::new();
    for (i, &a) in order.iter().enumerate() {
        let p = positions[a as usize];
        let beside = order[i + 1..]
            .iter()
            .take_while(|&&b| positions[b as usize].x - p.x <= max_size);
        for &b in beside {
            let d = p.distance(positions[b as usize]);
            if d <= max_size {
                pairs.push((d, a.min(b), a.max(b)));
            }
        }
    }
    pairs.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut unions = Unions::new(positions.len());
    let mut bounds: Vec<(DVec2, DVec2)> = positions.iter().map(|&p| (p, p)).collect();
    for (_, a, b) in pairs {
        let (a, b) = (unions.root(a) as usize, unions.root(b) as usize);
        let (low, high) = (bounds[a].0.min(bounds[b].0), bounds[a].1.max(bounds[b].1));
        if a != b && low.distance(high) <= max_size {
            unions.join(a as u32, b as u32);
            bounds[a.min(b)] = (low, high);
        }
    }
    (0..positions.len() as u32)
        .map(|i| unions.root(i))
        .collect()
}

/// Returns the distance of `p` from a closed outline, m.
fn distance_to(outline: &[DVec2], p: DVec2) -> f64 {
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    ends.map(|(&a, &b)| {
        let side = b - a;
        let t = (p - a).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
        (a + side * t.clamp(0.0, 1.0)).distance(p)
    })
    .fold(f64::INFINITY, f64::min)
}

/// Returns the number of the nearest point.
fn nearest(points: &[DVec2], p: DVec2) -> usize {
    let distance = |q: &DVec2| q.distance_squared(p);
    let all = points.iter().enumerate();
    all.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))
        .map_or(0, |(i, _)| i)
}

/// Merges corners of different cells that coincide, and finds the cell beyond each side. `rod_of` are the cells' rods.
fn weld(cells: &[VoronoiCell], rod_of: &[u32], outline: &[DVec2], spacing: f64) -> Columns {
    let (positions, number) = distinct_positions(cells, WELD_DISTANCE * spacing);
    let representative = cluster(&positions, MERGE_DISTANCE * spacing);
    let mut section = Columns {
        spacing,
        ..Columns::default()
    };
    let mut corner_of = vec![OUTSIDE; positions.len()];
    let mut at = 0;
    for (cell, &rod) in cells.iter().zip(rod_of) {
        let mut corners: Vec<u32> = Vec::new();
        for _ in &cell.corners {
            let root = representative[number[at] as usize] as usize;
            at += 1;
            if corner_of[root] == OUTSIDE {
                corner_of[root] = section.corners.len() as u32;
                section.corners.push(positions[root]);
            }
            if corners.last() != Some(&corner_of[root]) {
                corners.push(corner_of[root]);
            }
        }
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            continue;
        }
        section.columns.push(Column {
            rod,
            beyond: vec![OUTSIDE; corners.len()],
            corners,
            centre: cell.centroid,
            area: cell.area,
        });
    }
    let tolerance = MERGE_DISTANCE * spacing;
    section.outer = section
        .corners
        .iter()
        .map(|&p| distance_to(outline, p) <= tolerance)
        .collect();
    let mut sides: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (number, column) in section.columns.iter().enumerate() {
        for (a, b) in column.sides() {
            sides.insert((a, b), number as u32);
        }
    }
    for column in &mut section.columns {
        let pairs: Vec<(u32, u32)> = column.sides().collect();
        for (k, (a, b)) in pairs.into_iter().enumerate() {
            if let Some(&other) = sides.get(&(b, a)) {
                column.beyond[k] = other;
            }
        }
    }
    section
}

impl Column {
    /// Returns the sides as pairs of corners, counter-clockwise.
    pub(super) fn sides(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Returns the diameter of the circle of the same area, m.
    pub(super) fn width(&self) -> f64 {
        2.0 * (self.area / std::f64::consts::PI).sqrt()
    }
}
