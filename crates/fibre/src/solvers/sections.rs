//! Sections of a bundle that move as a whole: the coarse part of a two-level method. Vertices of one slab of the stem, an
//! edge thick, that bonds hold together are one piece; its displacement is u = c + a ξ + b η with ξ, η the places of its
//! vertices at rest across the stem: translation, rotation, and stretch and shear of the section.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::band::{Blocks, Column};
use super::direct::touch_block;
use super::matrix::Envelope;
use super::wide;
use crate::bundle::Bundle;
use crate::kernel::{Block, Evaluator, Line, Row, Slope, add_rows};
use crate::solver::Touch;
use glam::DVec3;

/// No piece.
const NONE: u32 = u32::MAX;
/// Parts that the matrix is summed in, each by a thread of its own.
const PARTS: usize = 2;
/// Freedoms of a piece.
const FREEDOMS: usize = 9;
/// A piece of fewer vertices is left to its rods.
const LEAST: u32 = 5;
/// Added to the diagonal, of itself: pieces all of whose vertices lie in a line do not tell all freedoms apart.
const RIDGE: f64 = 1e-9;

/// Force on a piece or its motion: of all of it, and what grows with ξ and with η.
pub(super) type Motion = [[f64; 4]; 3];

/// Pieces and the matrix of their freedoms.
#[derive(Debug, Clone, Default)]
pub(super) struct Sections {
    /// Per vertex.
    piece: Vec<u32>,
    /// Per vertex: 1, ξ, η over the size of the piece.
    weight: Vec<[f64; 3]>,
    count: usize,
    /// Whether the matrix is factored.
    ready: bool,
    /// Per piece: the lowest that it is joined to, and where the blocks of these pairs begin.
    lowest: Vec<(u32, u32)>,
    blocks: [[Vec<Block>; 2]; PARTS],
    matrix: Envelope,
}

impl Sections {
    /// Makes everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        let axis = main_axis(bundle);
        self.find_pieces(bundle, &slabs(bundle, axis));
        self.find_weights(bundle, axis);
        let mut lowest: Vec<u32> = (0..self.count as u32).collect();
        let mut join = |u: usize, v: usize| {
            let (a, b) = (self.piece[u], self.piece[v]);
            if a != NONE && b != NONE {
                let row = &mut lowest[a.max(b) as usize];
                *row = (*row).min(a.min(b));
            }
        };
        for v in (0..n).filter(|&v| bundle.is_edge(v)) {
            join(v, v + 1);
            if bundle.bend[v] > 0.0 {
                join(v - 1, v + 1);
            }
        }
        for (v, e) in live_bonds(bundle) {
            join(v, e);
            join(v, e + 1);
        }
        let pairs = (lowest.iter().enumerate())
            .flat_map(|(p, &low)| (0..3).map(move |k| (3 * p as u32 + k, 3 * low)));
        self.matrix = Envelope::zeros(3, 3 * self.count, pairs);
        let mut next = 0;
        self.lowest.clear();
        for (p, low) in lowest.into_iter().enumerate() {
            self.lowest.push((low, next));
            next += p as u32 - low + 1;
        }
        for blocks in self.blocks.iter_mut().flatten() {
            blocks.resize(next as usize, [[0.0; 16]; FREEDOMS]);
        }
    }

    /// Pieces: vertices of one slab that bonds join.
    fn find_pieces(&mut self, bundle: &Bundle, slab: &[u32]) {
        let n = bundle.vertices();
        let mut parent: Vec<u32> = (0..n as u32).collect();
        fn root(parent: &mut [u32], mut v: u32) -> u32 {
            while parent[v as usize] != v {
                parent[v as usize] = parent[parent[v as usize] as usize];
                v = parent[v as usize];
            }
            v
        }
        let mut join = |a: usize, b: usize| {
            if slab[a] == slab[b] {
                let (a, b) = (root(&mut parent, a as u32), root(&mut parent, b as u32));
                parent[a.max(b) as usize] = a.min(b);
            }
        };
        for (v, e) in live_bonds(bundle) {
            join(v, e);
            join(v, e + 1);
        }
        for j in (0..n).filter(|&j| bundle.is_edge(j)) {
            join(j, j + 1);
        }
        let roots: Vec<u32> = (0..n as u32).map(|v| root(&mut parent, v)).collect();
        let mut size = vec![0u32; n];
        roots.iter().for_each(|r| size[*r as usize] += 1);
        let mut order: Vec<(u32, u32)> = (0..n as u32)
            .filter(|&v| roots[v as usize] == v && size[v as usize] >= LEAST)
            .map(|v| (slab[v as usize], v))
            .collect();
        // Along the stem, for a narrow matrix.
        order.sort_unstable();
        let mut number = vec![NONE; n];
        for (k, (_, v)) in order.iter().enumerate() {
            number[*v as usize] = k as u32;
        }
        self.piece = roots.iter().map(|r| number[*r as usize]).collect();
        self.count = order.len();
    }

    fn find_weights(&mut self, bundle: &Bundle, axis: DVec3) {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.count];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                sums[p as usize].0 += bundle.rest.get(v);
                sums[p as usize].1 += 1.0;
            }
        }
        let side = axis.any_orthonormal_vector();
        let up = axis.cross(side);
        let from = |v: usize, p: u32| bundle.rest.get(v) - sums[p as usize].0 / sums[p as usize].1;
        let mut reach = vec![f64::MIN_POSITIVE; self.count];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                reach[p as usize] = reach[p as usize].max(from(v, p).length());
            }
        }
        self.weight = (self.piece.iter().enumerate())
            .map(|(v, &p)| {
                if p == NONE {
                    return [0.0; 3];
                }
                let d = from(v, p) / reach[p as usize];
                [1.0, d.dot(side), d.dot(up)]
            })
            .collect();
    }

    /// Sums rods' blocks, with what bonds have between vertices of one rod, and bonds to the matrix of the pieces, and
    /// factors it. Freedoms whose `free` is 0 are held.
    pub fn factor<const B: usize>(
        &mut self,
        band: &[Blocks<B>],
        bonds: &Evaluator,
        touches: &[Touch],
        free: &[Row],
    ) {
        let (piece, weight, lowest) = (&self.piece, &self.weight, &self.lowest);
        let sum = |part: usize, blocks: &mut [Vec<Block>; 2]| {
            let mut pairs = Pairs { lowest, blocks };
            pairs
                .blocks
                .iter_mut()
                .for_each(|of| of.fill([[0.0; 16]; FREEDOMS]));
            let end = |k: usize| band.len() * k / PARTS;
            let range = end(part)..end(part + 1);
            wide(
                #[inline(always)]
                || {
                    for v in range.clone() {
                        for (k, block) in band[v].iter().enumerate() {
                            let c = v + k;
                            if c < band.len() && piece[v] != NONE && piece[c] != NONE {
                                let by = if k == 0 { 0.5 } else { 1.0 };
                                let rows = spread(&weight[c], by, |a, b| block[b][a]);
                                pairs.add(piece[v], piece[c], &weight[v], &rows);
                            }
                        }
                    }
                    bonds.each_slope(
                        part,
                        PARTS,
                        #[inline(always)]
                        |slope| pairs.add_slope(piece, weight, free, slope),
                    );
                },
            );
        };
        let [first, second] = &mut self.blocks;
        rayon::join(|| sum(0, first), || sum(1, second));
        let mut pairs = Pairs {
            lowest,
            blocks: first,
        };
        touches
            .iter()
            .for_each(|touch| pairs.add_touch(piece, weight, free, touch));
        self.add_up();
        let matrix = &mut self.matrix;
        for row in 0..matrix.rows() {
            let more = RIDGE * matrix.diagonal(row);
            matrix.add(row, row, more);
        }
        // Without it rods alone still solve.
        self.ready = self.count > 0 && self.matrix.factor().is_ok();
    }

    /// Takes the sums of all parts into the matrix.
    fn add_up(&mut self) {
        let matrix = &mut self.matrix;
        matrix.clear();
        for (p, &(low, at)) in self.lowest.iter().enumerate() {
            for q in low as usize..=p {
                let k = at as usize + q - low as usize;
                for [lower, upper] in &self.blocks {
                    let (lower, upper) = (&lower[k], &upper[k]);
                    // What was added to a piece with itself is half of it.
                    let across = if p == q { lower } else { upper };
                    for a in 0..FREEDOMS {
                        let count = if p == q { a + 1 } else { FREEDOMS };
                        let sum: [f64; FREEDOMS] =
                            std::array::from_fn(|c| lower[a][c] + across[c][a]);
                        matrix.add_row(p * FREEDOMS + a, q * FREEDOMS, &sum[..count]);
                    }
                }
            }
        }
    }

    /// How many pieces take part.
    pub fn pieces(&self) -> usize {
        if self.ready { self.count } else { 0 }
    }

    /// Adds forces `r` on the vertices from `first` on to those on pieces.
    #[inline(always)]
    pub fn gather(&self, first: usize, r: &[Row], sums: &mut [Motion]) {
        if !self.ready {
            return;
        }
        let own = self.piece[first..].iter().zip(&self.weight[first..]);
        for ((&p, weight), r) in own.zip(r) {
            if p != NONE {
                for (sum, w) in sums[p as usize].iter_mut().zip(weight) {
                    (0..4).for_each(|a| sum[a] += w * r.0[a]);
                }
            }
        }
    }

    /// Replaces forces on pieces by the motion that they make, and returns their work on it.
    pub fn solve(&self, sums: &mut [Motion]) -> f64 {
        let force = |m: &Motion| -> [f64; FREEDOMS] { std::array::from_fn(|f| m[f / 3][f % 3]) };
        let forces: Vec<f64> = sums.iter().flat_map(force).collect();
        let mut x = forces.clone();
        self.matrix.solve(&mut x);
        for (motion, x) in sums.iter_mut().zip(x.chunks_exact(FREEDOMS)) {
            *motion = [[0.0; 4]; 3];
            (0..FREEDOMS).for_each(|f| motion[f / 3][f % 3] = x[f]);
        }
        forces.iter().zip(&x).fold(0.0, |sum, (f, x)| sum + f * x)
    }

    /// Adds the pieces' motion to the vertices from `first` on.
    #[inline(always)]
    pub fn add(&self, motion: &[Motion], first: usize, z: &mut [Row]) {
        if motion.is_empty() {
            return;
        }
        let own = self.piece[first..].iter().zip(&self.weight[first..]);
        for ((&p, weight), z) in own.zip(z) {
            if p != NONE {
                for (motion, w) in motion[p as usize].iter().zip(weight) {
                    (0..4).for_each(|a| z.0[a] += w * motion[a]);
                }
            }
        }
    }
}

/// Rows of a block of the matrix between a vertex and one of a piece, over the freedoms of the piece: the entries `block`
/// (row, column), `by` times.
#[inline(always)]
fn spread(weight: &[f64; 3], by: f64, block: impl Fn(usize, usize) -> f64) -> [Line; 3] {
    let mut rows = [[0.0; 16]; 3];
    for (a, row) in rows.iter_mut().enumerate() {
        for (t, w) in weight.iter().enumerate() {
            (0..3).for_each(|b| row[3 * t + b] = by * w * block(a, b));
        }
    }
    rows
}

/// Blocks of pairs of pieces, the first not below the second, with rows of the first; and with rows of the second. Of a
/// piece with itself what is to be added to its mirror image.
struct Pairs<'a> {
    lowest: &'a [(u32, u32)],
    blocks: &'a mut [Vec<Block>; 2],
}

impl Pairs<'_> {
    /// Adds a block with rows of a vertex of piece `p` and columns of piece `q`.
    #[inline(always)]
    fn add(&mut self, p: u32, q: u32, weight: &[f64; 3], rows: &[Line; 3]) {
        let (low, at) = self.lowest[p.max(q) as usize];
        let block = &mut self.blocks[usize::from(p < q)][(at + p.min(q) - low) as usize];
        add_rows(block, weight, rows);
    }

    /// Adds what a bond has between its vertex and its edge. What it has of each alone is in the rods' blocks.
    #[inline(always)]
    fn add_slope(&mut self, piece: &[u32], weight: &[[f64; 3]], free: &[Row], slope: &Slope) {
        let [x, y, z] = slope.nodes.map(|v| v as usize);
        if piece[x] == NONE {
            return;
        }
        let held =
            |of: &Column, v: usize| -> Column { std::array::from_fn(|a| of[a] * free[v].0[a]) };
        let (u, w) = (held(&slope.length[0], x), held(&slope.cosine[0], x));
        let rows = |n: usize, v: usize| {
            let (g, h) = (held(&slope.length[n], v), held(&slope.cosine[n], v));
            spread(&weight[v], 1.0, |a, b| u[a] * g[b] + w[a] * h[b])
        };
        let (p, q, r) = (piece[x], piece[y], piece[z]);
        if q == r && q != NONE {
            let (mut sum, more) = (rows(1, y), rows(2, z));
            for (sum, more) in sum.iter_mut().zip(&more) {
                (0..16).for_each(|k| sum[k] += more[k]);
            }
            self.add(p, q, &weight[x], &sum);
            return;
        }
        if q != NONE {
            self.add(p, q, &weight[x], &rows(1, y));
        }
        if r != NONE {
            self.add(p, r, &weight[x], &rows(2, z));
        }
    }

    /// Adds a contact, along its normal and across it. Between pieces that the matrix does not join what joins them is left
    /// out.
    fn add_touch(&mut self, piece: &[u32], weight: &[[f64; 3]], free: &[Row], touch: &Touch) {
        for (v, left) in touch.shares() {
            for (c, right) in touch.shares() {
                let (p, q) = (piece[v], piece[c]);
                if p == NONE || q == NONE || p < q || self.lowest[p as usize].0 > q {
                    continue;
                }
                let by = left * right * if p == q { 0.5 } else { 1.0 };
                let rows = spread(&weight[c], by, |a, b| {
                    touch_block(touch, touch.normal, a, b) * free[v].0[a] * free[c].0[b]
                });
                self.add(p, q, &weight[v], &rows);
            }
        }
    }
}

/// Vertices and edges of bonds that have stiffness.
pub(super) fn live_bonds(bundle: &Bundle) -> impl Iterator<Item = (usize, usize)> + '_ {
    let b = &bundle.bonds;
    (0..b.len())
        .filter(|&i| b.transverse[i] > 0.0 || b.shear[i] > 0.0)
        .map(|i| (b.vertex[i] as usize, b.edge[i] as usize))
}

/// The direction in which most rods run.
fn main_axis(bundle: &Bundle) -> DVec3 {
    let mut way = DVec3::ZERO;
    for rod in 0..bundle.rods() {
        let range = bundle.rod(rod);
        way += bundle.rest.get(range.end - 1) - bundle.rest.get(range.start);
    }
    way.normalize_or(DVec3::X)
}

/// The slab of each vertex, a mean edge thick.
fn slabs(bundle: &Bundle, axis: DVec3) -> Vec<u32> {
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    let (sum, count) = edges.fold((0.0, 0.0), |(s, c), j| (s + bundle.rest_length[j], c + 1.0));
    let thick = f64::max(sum / f64::max(count, 1.0), f64::MIN_POSITIVE);
    let along: Vec<f64> = bundle.rest.iter().map(|p| p.dot(axis)).collect();
    let least = along.iter().copied().fold(f64::INFINITY, f64::min);
    along.iter().map(|s| ((s - least) / thick) as u32).collect()
}
