//! Sections of a bundle that move as a whole: the coarse part of a two-level method. Vertices of one slab of the stem, an
//! edge thick, that bonds hold together are one piece; its displacement is u = c + a ξ + b η with ξ, η the places of its
//! vertices at rest across the stem: translation, rotation, and stretch and shear of the section.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::iterative::Node;
use super::matrix::Envelope;
use crate::bundle::Bundle;
use glam::DVec3;

/// No piece.
const NONE: u32 = u32::MAX;
/// Freedoms of a piece.
const FREEDOMS: usize = 9;
/// A piece of fewer vertices is left to its rods.
const LEAST: u32 = 5;
/// Added to the diagonal, of itself: pieces all of whose vertices lie in a line do not tell all freedoms apart.
const RIDGE: f64 = 1e-9;

type Block = [[f64; FREEDOMS]; FREEDOMS];

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
    /// Pairs of pieces, the first not below the second.
    pairs: Vec<(u32, u32)>,
    /// Per block of the fine matrix that joins a pair: the pair.
    slots: Vec<u32>,
    /// The same: its place, row and column.
    entries: Vec<[u32; 3]>,
    blocks: Vec<Block>,
    matrix: Envelope,
}

impl Sections {
    /// Makes everything that depends on which rods and bonds there are, for a matrix whose rows begin at `first` and have
    /// their blocks in `column`.
    pub fn prepare(&mut self, bundle: &Bundle, first: &[u32], column: &[u32]) {
        let n = bundle.vertices();
        let axis = main_axis(bundle);
        let before = std::mem::take(&mut self.piece);
        self.find_pieces(bundle, &slabs(bundle, axis));
        let piece = &self.piece;
        let pair = |v: usize, c: usize| {
            let (a, b) = (piece[v], piece[c]);
            (a != NONE && b != NONE).then(|| u64::from(a.max(b)) << 32 | u64::from(a.min(b)))
        };
        let mut all: Vec<u64> = (0..n).filter_map(|v| pair(v, v)).collect();
        for v in (0..n).filter(|&v| bundle.is_edge(v)) {
            all.extend(pair(v, v + 1));
            if bundle.bend[v] > 0.0 {
                all.extend(pair(v - 1, v + 1));
            }
        }
        for (&v, &e) in bundle.bonds.vertex.iter().zip(&bundle.bonds.edge) {
            all.extend(pair(v as usize, e as usize));
            all.extend(pair(v as usize, e as usize + 1));
        }
        all.sort_unstable();
        all.dedup();
        let pairs: Vec<(u32, u32)> = all.iter().map(|p| ((p >> 32) as u32, *p as u32)).collect();
        if before == self.piece && pairs == self.pairs {
            return;
        }
        self.pairs = pairs;
        self.entries.clear();
        self.slots.clear();
        for v in 0..n {
            for k in first[v]..first[v + 1] {
                let c = column[k as usize] as usize;
                let found = pair(v, c).filter(|_| piece[v] >= piece[c]);
                if let Some(at) = found.and_then(|p| all.binary_search(&p).ok()) {
                    self.slots.push(at as u32);
                    self.entries.push([k, v as u32, c as u32]);
                }
            }
        }
        self.find_weights(bundle, axis);
        self.blocks = vec![[[0.0; FREEDOMS]; FREEDOMS]; self.pairs.len()];
        let fine = (self.pairs.iter())
            .flat_map(|&(a, b)| (0..9).map(move |k| (3 * a + k / 3, 3 * b + k % 3)));
        self.matrix = Envelope::zeros(3, 3 * self.count, fine);
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
        for (&v, &e) in bundle.bonds.vertex.iter().zip(&bundle.bonds.edge) {
            join(v as usize, e as usize);
            join(v as usize, e as usize + 1);
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

    /// Sums a matrix of blocks to that of the pieces, and factors it.
    pub fn factor<const B: usize>(&mut self, value: &[[[f64; 4]; B]]) {
        self.blocks
            .iter_mut()
            .for_each(|b| *b = [[0.0; FREEDOMS]; FREEDOMS]);
        for (&slot, &[k, v, c]) in self.slots.iter().zip(&self.entries) {
            let (left, right) = (&self.weight[v as usize], &self.weight[c as usize]);
            let fine = &value[k as usize];
            let block = &mut self.blocks[slot as usize];
            for (s, l) in left.iter().enumerate() {
                for (t, r) in right.iter().enumerate() {
                    let w = l * r;
                    for a in 0..3 {
                        for b in 0..3 {
                            block[3 * s + a][3 * t + b] += w * fine[b][a];
                        }
                    }
                }
            }
        }
        self.matrix.clear();
        for (&(p, q), block) in self.pairs.iter().zip(&self.blocks) {
            let (row, column) = (p as usize * FREEDOMS, q as usize * FREEDOMS);
            for a in 0..FREEDOMS {
                for b in 0..FREEDOMS {
                    if column + b <= row + a {
                        let more = if row + a == column + b {
                            1.0 + RIDGE
                        } else {
                            1.0
                        };
                        self.matrix.add(row + a, column + b, more * block[a][b]);
                    }
                }
            }
        }
        // Without it rods alone still solve.
        self.ready = self.count > 0 && self.matrix.factor().is_ok();
    }

    /// The pieces' motion under forces `r`.
    pub fn solve(&self, r: &[Node]) -> Vec<f64> {
        if !self.ready {
            return Vec::new();
        }
        let mut sums = vec![0.0; self.count * FREEDOMS];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                let at = p as usize * FREEDOMS;
                for (s, w) in self.weight[v].iter().enumerate() {
                    (0..3).for_each(|a| sums[at + 3 * s + a] += w * r[v][a]);
                }
            }
        }
        self.matrix.solve(&mut sums);
        sums
    }

    /// Adds the pieces' motion to vertices.
    pub fn add(&self, motion: &[f64], z: &mut [Node]) {
        if motion.is_empty() {
            return;
        }
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NONE {
                let at = p as usize * FREEDOMS;
                for (s, w) in self.weight[v].iter().enumerate() {
                    (0..3).for_each(|a| z[v][a] += w * motion[at + 3 * s + a]);
                }
            }
        }
    }
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
