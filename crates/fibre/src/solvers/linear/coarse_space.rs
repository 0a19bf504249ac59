//! The coarse level of the preconditioner: pieces of cross-sections that move as a whole. Vertices in one slab of the stem,
//! an edge thick, that bonds connect are one piece. Its displacement is u = c + a ξ + b η, with ξ and η the positions of its
//! vertices at rest across the stem: translation, rotation, stretch and shear of the cross-section.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::envelope::{EnvelopeMatrix, FactorError};
use super::rod_blocks::{Column, RodBlocks};
use crate::contact::ContactSpring;
use crate::evaluator::ForceEvaluator;
use crate::rod_bundle::RodBundle;
use crate::simd::bond_gradients::BondGradient;
use crate::simd::dispatch::with_widest_registers;
use crate::simd::lanes::PaddedVec3;
use crate::simd::rank_update::{Block, BlockRow, add_rows};
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context, Unions};

/// Marks vertices that belong to no piece.
const NO_PIECE: u32 = u32::MAX;
/// Parts in which the matrix is summed, each by a thread of its own. Their number is fixed, so that the bits of the sum are.
const PARTS: usize = 2;
/// Degrees of freedom of a piece.
const PIECE_DOFS: usize = 9;
/// Smaller pieces are left to the fine level.
const MIN_PIECE_VERTICES: u32 = 5;
/// Fraction of the diagonal that is added to it: a piece whose vertices lie in a line does not determine all of its degrees of
/// freedom.
const REGULARISATION: f64 = 1e-9;

/// Forces on a piece, or its displacement: the constant part, and those proportional to ξ and η.
pub(super) type PieceVector = [[f64; 4]; 3];

/// A block row of the matrix.
#[derive(Debug, Clone, Copy)]
struct PieceRow {
    /// The lowest piece that this one is connected with.
    lowest: u32,
    /// Where the blocks with that piece, and all up to this one, begin.
    start: u32,
}

/// Pieces and the factored matrix of their degrees of freedom.
#[derive(Debug, Clone, Default)]
pub(super) struct CoarseSpace {
    /// Per vertex: its piece.
    piece: Vec<u32>,
    /// Per vertex: 1, ξ and η over the size of the piece.
    weight: Vec<[f64; 3]>,
    count: usize,
    /// Whether the matrix is factored.
    ready: bool,
    rows: Vec<PieceRow>,
    blocks: [[Vec<Block>; 2]; PARTS],
    matrix: EnvelopeMatrix,
}

impl CoarseSpace {
    /// Derives everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &RodBundle) {
        let n = bundle.vertices();
        let axis = main_axis(bundle);
        self.find_pieces(bundle, &slabs(bundle, axis));
        self.find_weights(bundle, axis);
        let mut lowest: Vec<u32> = (0..self.count as u32).collect();
        let mut connect = |u: usize, v: usize| {
            let (a, b) = (self.piece[u], self.piece[v]);
            if a != NO_PIECE && b != NO_PIECE {
                let row = &mut lowest[a.max(b) as usize];
                *row = (*row).min(a.min(b));
            }
        };
        for v in (0..n).filter(|&v| bundle.is_edge(v)) {
            connect(v, v + 1);
            if bundle.bend[v] > 0.0 {
                connect(v - 1, v + 1);
            }
        }
        for (v, e) in bundle.bonds.with_stiffness() {
            connect(v, e);
            connect(v, e + 1);
        }
        let pairs = (lowest.iter().enumerate())
            .flat_map(|(p, &low)| (0..3).map(move |k| (3 * p as u32 + k, 3 * low)));
        self.matrix = EnvelopeMatrix::zeros(3, 3 * self.count, pairs);
        let mut next = 0;
        self.rows.clear();
        for (p, lowest) in lowest.into_iter().enumerate() {
            self.rows.push(PieceRow {
                lowest,
                start: next,
            });
            next += p as u32 - lowest + 1;
        }
        for blocks in self.blocks.iter_mut().flatten() {
            blocks.resize(next as usize, [[0.0; 16]; PIECE_DOFS]);
        }
    }

    /// Finds the pieces: vertices in one slab that edges and bonds connect.
    fn find_pieces(&mut self, bundle: &RodBundle, slab: &[u32]) {
        let n = bundle.vertices();
        let mut parts = Unions::new(n);
        let mut connect = |a: usize, b: usize| {
            if slab[a] == slab[b] {
                parts.join(a as u32, b as u32);
            }
        };
        for (v, e) in bundle.bonds.with_stiffness() {
            connect(v, e);
            connect(v, e + 1);
        }
        for j in (0..n).filter(|&j| bundle.is_edge(j)) {
            connect(j, j + 1);
        }
        let roots: Vec<u32> = (0..n as u32).map(|v| parts.root(v)).collect();
        let mut size = vec![0u32; n];
        roots.iter().for_each(|r| size[*r as usize] += 1);
        let mut order: Vec<u32> = (0..n as u32)
            .filter(|&v| roots[v as usize] == v && size[v as usize] >= MIN_PIECE_VERTICES)
            .collect();
        // Along the stem, for a narrow matrix.
        order.sort_unstable_by_key(|&v| (slab[v as usize], v));
        let mut number = vec![NO_PIECE; n];
        for (k, v) in order.iter().enumerate() {
            number[*v as usize] = k as u32;
        }
        self.piece = roots.iter().map(|r| number[*r as usize]).collect();
        self.count = order.len();
    }

    /// Sets the weights of all vertices.
    fn find_weights(&mut self, bundle: &RodBundle, axis: DVec3) {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.count];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NO_PIECE {
                sums[p as usize].0 += bundle.rest.get(v);
                sums[p as usize].1 += 1.0;
            }
        }
        let side = axis.any_orthonormal_vector();
        let up = axis.cross(side);
        let from = |v: usize, p: u32| bundle.rest.get(v) - sums[p as usize].0 / sums[p as usize].1;
        let mut reach = vec![f64::MIN_POSITIVE; self.count];
        for (v, &p) in self.piece.iter().enumerate() {
            if p != NO_PIECE {
                reach[p as usize] = reach[p as usize].max(from(v, p).length());
            }
        }
        self.weight = (self.piece.iter().enumerate())
            .map(|(v, &p)| {
                if p == NO_PIECE {
                    return [0.0; 3];
                }
                let d = from(v, p) / reach[p as usize];
                [1.0, d.dot(side), d.dot(up)]
            })
            .collect();
    }

    /// Sums rods' blocks (with those of bonds between vertices of one rod), bonds and contacts to the matrix of the pieces, and
    /// factors it. Degrees of freedom whose `free` is 0 are held.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn factor<const B: usize>(
        &mut self,
        band: &[RodBlocks<B>],
        bonds: &ForceEvaluator,
        springs: &[ContactSpring],
        free: &[PaddedVec3],
        context: &Context,
    ) -> Result<(), Cancelled> {
        let (piece, weight, rows) = (&self.piece, &self.weight, &self.rows);
        let sum = |part: usize, blocks: &mut [Vec<Block>; 2]| {
            let mut pairs = Pairs { rows, blocks };
            pairs
                .blocks
                .iter_mut()
                .for_each(|of| of.fill([[0.0; 16]; PIECE_DOFS]));
            let end = |k: usize| band.len() * k / PARTS;
            let range = end(part)..end(part + 1);
            with_widest_registers(
                #[inline(always)]
                || {
                    for v in range.clone() {
                        for (k, block) in band[v].iter().enumerate() {
                            let c = v + k;
                            if c < band.len() && piece[v] != NO_PIECE && piece[c] != NO_PIECE {
                                let factor = if k == 0 { 0.5 } else { 1.0 };
                                let rows = weighted_rows(&weight[c], factor, |a, b| block[b][a]);
                                pairs.add(piece[v], piece[c], &weight[v], &rows);
                            }
                        }
                    }
                    bonds.for_each_gradient(
                        part,
                        PARTS,
                        #[inline(always)]
                        |bond| pairs.add_bond(piece, weight, free, bond),
                    );
                },
            );
        };
        let [first, second] = &mut self.blocks;
        rayon::join(|| sum(0, first), || sum(1, second));
        let mut pairs = Pairs {
            rows,
            blocks: first,
        };
        for spring in springs {
            pairs.add_contact(piece, weight, free, spring);
        }
        self.ready = false;
        self.sum_parts(context)?;
        let matrix = &mut self.matrix;
        for row in 0..matrix.rows() {
            let more = REGULARISATION * matrix.diagonal(row);
            matrix.add(row, row, more);
        }
        // Without a factor the fine level works alone.
        self.ready = match self.matrix.factor(context) {
            Ok(()) => self.count > 0,
            Err(FactorError::NotPositive { .. }) => false,
            Err(FactorError::Cancelled) => return Err(Cancelled),
        };
        Ok(())
    }

    /// Sums all parts into the matrix.
    fn sum_parts(&mut self, context: &Context) -> Result<(), Cancelled> {
        let matrix = &mut self.matrix;
        matrix.clear(context)?;
        for (p, row) in self.rows.iter().enumerate() {
            for q in row.lowest as usize..=p {
                let k = row.start as usize + q - row.lowest as usize;
                for [lower, upper] in &self.blocks {
                    let (lower, upper) = (&lower[k], &upper[k]);
                    // Of a piece with itself half of the sum was added.
                    let across = if p == q { lower } else { upper };
                    for a in 0..PIECE_DOFS {
                        let count = if p == q { a + 1 } else { PIECE_DOFS };
                        let sum: [f64; PIECE_DOFS] =
                            std::array::from_fn(|c| lower[a][c] + across[c][a]);
                        matrix.add_row(p * PIECE_DOFS + a, q * PIECE_DOFS, &sum[..count]);
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the number of pieces that take part.
    pub fn pieces(&self) -> usize {
        if self.ready { self.count } else { 0 }
    }

    /// Adds the forces `r` on the vertices from `first` on to the forces on pieces.
    #[inline(always)]
    pub fn restrict(&self, first: usize, r: &[PaddedVec3], sums: &mut [PieceVector]) {
        if !self.ready {
            return;
        }
        let own = self.piece[first..].iter().zip(&self.weight[first..]);
        for ((&p, weight), r) in own.zip(r) {
            if p != NO_PIECE {
                for (sum, w) in sums[p as usize].iter_mut().zip(weight) {
                    (0..4).for_each(|a| sum[a] += w * r.0[a]);
                }
            }
        }
    }

    /// Replaces forces on pieces by the displacement that they cause, and returns their work along it: 0 without a factor.
    pub fn solve(&self, sums: &mut [PieceVector]) -> f64 {
        if !self.ready {
            return 0.0;
        }
        let force =
            |m: &PieceVector| -> [f64; PIECE_DOFS] { std::array::from_fn(|f| m[f / 3][f % 3]) };
        let forces: Vec<f64> = sums.iter().flat_map(force).collect();
        let mut x = forces.clone();
        self.matrix.solve(&mut x);
        for (displacement, x) in sums.iter_mut().zip(x.chunks_exact(PIECE_DOFS)) {
            *displacement = [[0.0; 4]; 3];
            (0..PIECE_DOFS).for_each(|f| displacement[f / 3][f % 3] = x[f]);
        }
        forces.iter().zip(&x).fold(0.0, |sum, (f, x)| sum + f * x)
    }

    /// Adds the pieces' displacements to those of the vertices from `first` on.
    #[inline(always)]
    pub fn prolong(&self, pieces: &[PieceVector], first: usize, z: &mut [PaddedVec3]) {
        if pieces.is_empty() {
            return;
        }
        let own = self.piece[first..].iter().zip(&self.weight[first..]);
        for ((&p, weight), z) in own.zip(z) {
            if p != NO_PIECE {
                for (part, w) in pieces[p as usize].iter().zip(weight) {
                    (0..4).for_each(|a| z.0[a] += w * part[a]);
                }
            }
        }
    }
}

/// Returns the rows of a block of the matrix between a vertex and a vertex of a piece, over the degrees of freedom of the
/// piece: the entries `block` (row, column), times `factor`.
#[inline(always)]
fn weighted_rows(
    weight: &[f64; 3],
    factor: f64,
    block: impl Fn(usize, usize) -> f64,
) -> [BlockRow; 3] {
    let mut rows = [[0.0; 16]; 3];
    for (a, row) in rows.iter_mut().enumerate() {
        for (t, w) in weight.iter().enumerate() {
            (0..3).for_each(|b| row[3 * t + b] = factor * w * block(a, b));
        }
    }
    rows
}

/// Blocks of pairs of pieces, with rows of the piece with the higher number, and with rows of the other. The blocks of a
/// piece with itself are summed with their transposes at the end.
struct Pairs<'a> {
    rows: &'a [PieceRow],
    blocks: &'a mut [Vec<Block>; 2],
}

impl Pairs<'_> {
    /// Adds a block with rows of a vertex of piece `p` and columns of piece `q`.
    #[inline(always)]
    fn add(&mut self, p: u32, q: u32, weight: &[f64; 3], rows: &[BlockRow; 3]) {
        let row = self.rows[p.max(q) as usize];
        let number = row.start + p.min(q) - row.lowest;
        let block = &mut self.blocks[usize::from(p < q)][number as usize];
        add_rows(block, weight, rows);
    }

    /// Adds the blocks of a bond between its vertex and its edge. The blocks of each alone are among the rods' blocks.
    #[inline(always)]
    fn add_bond(
        &mut self,
        piece: &[u32],
        weight: &[[f64; 3]],
        free: &[PaddedVec3],
        bond: &BondGradient,
    ) {
        let [x, y, z] = bond.vertices.map(|v| v as usize);
        if piece[x] == NO_PIECE {
            return;
        }
        let masked =
            |of: &Column, v: usize| -> Column { std::array::from_fn(|a| of[a] * free[v].0[a]) };
        let (u, w) = (masked(&bond.opening[0], x), masked(&bond.slip[0], x));
        let rows = |n: usize, v: usize| {
            let (g, h) = (masked(&bond.opening[n], v), masked(&bond.slip[n], v));
            weighted_rows(&weight[v], 1.0, |a, b| u[a] * g[b] + w[a] * h[b])
        };
        let (p, q, r) = (piece[x], piece[y], piece[z]);
        if q == r && q != NO_PIECE {
            let (mut sum, more) = (rows(1, y), rows(2, z));
            for (sum, more) in sum.iter_mut().zip(&more) {
                (0..16).for_each(|k| sum[k] += more[k]);
            }
            self.add(p, q, &weight[x], &sum);
            return;
        }
        if q != NO_PIECE {
            self.add(p, q, &weight[x], &rows(1, y));
        }
        if r != NO_PIECE {
            self.add(p, r, &weight[x], &rows(2, z));
        }
    }

    /// Adds a contact, along its normal and across it. A contact between pieces that have no block in the matrix is left out.
    fn add_contact(
        &mut self,
        piece: &[u32],
        weight: &[[f64; 3]],
        free: &[PaddedVec3],
        spring: &ContactSpring,
    ) {
        for (v, left) in spring.shares() {
            for (c, right) in spring.shares() {
                let (p, q) = (piece[v], piece[c]);
                let paired = p != NO_PIECE && q != NO_PIECE && p >= q;
                if !paired || self.rows[p as usize].lowest > q {
                    continue;
                }
                let factor = left * right * if p == q { 0.5 } else { 1.0 };
                let rows = weighted_rows(&weight[c], factor, |a, b| {
                    spring.stiffness(a, b) * free[v].0[a] * free[c].0[b]
                });
                self.add(p, q, &weight[v], &rows);
            }
        }
    }
}

/// Returns the mean direction of the rods.
fn main_axis(bundle: &RodBundle) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for rod in 0..bundle.rods() {
        let range = bundle.rod(rod);
        sum += bundle.rest.get(range.end - 1) - bundle.rest.get(range.start);
    }
    sum.normalize_or(DVec3::X)
}

/// Returns the slab of each vertex, as thick as the mean edge is long.
fn slabs(bundle: &RodBundle, axis: DVec3) -> Vec<u32> {
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    let (sum, count) = edges.fold((0.0, 0.0), |(s, c), j| (s + bundle.rest_length[j], c + 1.0));
    let thickness = f64::max(sum / f64::max(count, 1.0), f64::MIN_POSITIVE);
    let along: Vec<f64> = bundle.rest.iter().map(|p| p.dot(axis)).collect();
    let least = along.iter().copied().fold(f64::INFINITY, f64::min);
    along
        .iter()
        .map(|s| ((s - least) / thickness) as u32)
        .collect()
}
