//! Sections of a bundle that move as a whole: the coarse part of a two-level method. Vertices of one slab of the stem, an
//! edge thick, that bonds hold together are one piece; its displacement is u = c + a ξ + b η with ξ, η the places of its
//! vertices at rest across the stem: translation, rotation, and stretch and shear of the section.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::iterative::{Blocks, Column};
use super::matrix::Envelope;
use super::wide;
use crate::bundle::Bundle;
use crate::kernel::{Block, Evaluator, Line, Row, Slope, add_outer};
use glam::DVec3;

/// No piece.
const NONE: u32 = u32::MAX;
/// Freedoms of a piece.
const FREEDOMS: usize = 9;
/// A piece of fewer vertices is left to its rods.
const LEAST: u32 = 5;
/// Added to the diagonal, of itself: pieces all of whose vertices lie in a line do not tell all freedoms apart.
const RIDGE: f64 = 1e-9;

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
    blocks: Vec<Block>,
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
        self.blocks = vec![[[0.0; 16]; FREEDOMS]; next as usize];
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

    /// Sums rods' blocks and bonds to the matrix of the pieces, and factors it. Freedoms whose `free` is 0 are held.
    pub fn factor<const B: usize>(&mut self, band: &[Blocks<B>], bonds: &Evaluator, free: &[Row]) {
        let (piece, weight) = (&self.piece, &self.weight);
        let mut pairs = Pairs {
            lowest: &self.lowest,
            blocks: &mut self.blocks,
        };
        pairs.blocks.fill([[0.0; 16]; FREEDOMS]);
        wide(
            #[inline(always)]
            || {
                for (v, blocks) in band.iter().enumerate() {
                    for (k, block) in blocks.iter().enumerate() {
                        let c = v + k;
                        if c < band.len() && piece[v] != NONE && piece[c] != NONE {
                            pairs.add_block(
                                [piece[v], piece[c]],
                                [&weight[v], &weight[c]],
                                block,
                                k == 0,
                            );
                        }
                    }
                }
                bonds.each_slope(
                    #[inline(always)]
                    |slope| pairs.add_slope(piece, weight, free, slope),
                );
            },
        );
        let matrix = &mut self.matrix;
        matrix.clear();
        for (p, &(low, at)) in self.lowest.iter().enumerate() {
            for (q, block) in (low as usize..=p).zip(&self.blocks[at as usize..]) {
                for (a, row) in block.iter().enumerate() {
                    let count = if p == q { a + 1 } else { FREEDOMS };
                    matrix.add_row(p * FREEDOMS + a, q * FREEDOMS, &row[..count]);
                }
            }
        }
        for row in 0..matrix.rows() {
            let more = RIDGE * matrix.diagonal(row);
            matrix.add(row, row, more);
        }
        // Without it rods alone still solve.
        self.ready = self.count > 0 && self.matrix.factor().is_ok();
    }

    /// The pieces' motion under forces `r`.
    pub fn solve(&self, r: &[Row]) -> Vec<f64> {
        if !self.ready {
            return Vec::new();
        }
        let mut sums = vec![0.0; self.count * FREEDOMS];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                let at = p as usize * FREEDOMS;
                for (s, w) in self.weight[v].iter().enumerate() {
                    (0..3).for_each(|a| sums[at + 3 * s + a] += w * r[v].0[a]);
                }
            }
        }
        self.matrix.solve(&mut sums);
        sums
    }

    /// Adds the pieces' motion to vertices.
    pub fn add(&self, motion: &[f64], z: &mut [Row]) {
        if motion.is_empty() {
            return;
        }
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                let at = p as usize * FREEDOMS;
                for (s, w) in self.weight[v].iter().enumerate() {
                    (0..3).for_each(|a| z[v].0[a] += w * motion[at + 3 * s + a]);
                }
            }
        }
    }
}

/// Blocks of pairs of pieces, the first not below the second.
struct Pairs<'a> {
    lowest: &'a [(u32, u32)],
    blocks: &'a mut [Block],
}

impl Pairs<'_> {
    #[inline(always)]
    fn block(&mut self, p: u32, q: u32) -> &mut Block {
        let (low, at) = self.lowest[p as usize];
        &mut self.blocks[(at + q - low) as usize]
    }

    /// Adds a block of the matrix between two vertices and its mirror image, of one vertex the block alone. Of a piece with
    /// itself only what is on and below the diagonal is whole.
    #[inline(always)]
    fn add_block<const B: usize>(
        &mut self,
        [p, q]: [u32; 2],
        [left, right]: [&[f64; 3]; 2],
        block: &[Column; B],
        own: bool,
    ) {
        let sum = self.block(p.max(q), p.min(q));
        for (s, l) in left.iter().enumerate() {
            for (t, r) in right.iter().enumerate() {
                let w = l * r;
                for a in 0..3 {
                    for b in 0..3 {
                        let (row, column, v) = (3 * s + a, 3 * t + b, w * block[b][a]);
                        if p >= q {
                            sum[row][column] += v;
                        }
                        if p < q || p == q && !own {
                            sum[column][row] += v;
                        }
                    }
                }
            }
        }
    }

    /// Adds g gᵀ of a bond's two gradients by its three vertices.
    #[inline(always)]
    fn add_slope(&mut self, piece: &[u32], weight: &[[f64; 3]], free: &[Row], slope: &Slope) {
        let mut pieces = [NONE; 3];
        let mut sums: [[Line; 2]; 3] = [[[0.0; 16]; 2]; 3];
        for n in 0..3 {
            let v = slope.nodes[n] as usize;
            let p = piece[v];
            if p == NONE {
                continue;
            }
            let mut at = 0;
            while pieces[at] != p && pieces[at] != NONE {
                at += 1;
            }
            pieces[at] = p;
            let held = &free[v].0;
            for s in 0..3 {
                for a in 0..3 {
                    let w = weight[v][s] * held[a];
                    sums[at][0][3 * s + a] += w * slope.length[n][a];
                    sums[at][1][3 * s + a] += w * slope.cosine[n][a];
                }
            }
        }
        for i in 0..3 {
            for k in 0..3 {
                if pieces[i] == NONE || pieces[k] > pieces[i] {
                    continue;
                }
                let block = self.block(pieces[i], pieces[k]);
                add_outer(block, &sums[i], &sums[k]);
            }
        }
    }
}

/// Vertices and edges of bonds that have stiffness.
fn live_bonds(bundle: &Bundle) -> impl Iterator<Item = (usize, usize)> + '_ {
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
