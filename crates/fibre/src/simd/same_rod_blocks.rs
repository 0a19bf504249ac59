//! Blocks of the bonds' stiffness matrix between vertices of the same rod: g gᵀ of a bond's gradients with respect to its
//! vertex, and to the two of its edge ([`super::bond_gradients`]), summed for each vertex and each edge.

use super::bond_gradients::{GradientBatch, load_single3};
use super::bonds::{BondBatch, BondTable};
use super::dispatch::for_each_level;
use super::lanes::{Lanes, PaddedPair, WIDTH};
use super::level::SimdLevel;

/// Blocks of one vertex and of the edge that begins there. Symmetric ones are xx, yy, zz, –, xy, xz, yz, –.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SameRodBlocks {
    /// Sum over bonds whose vertex x it is.
    pub vertex: PaddedPair,
    /// Sums over bonds to the edge: of the edge's first vertex, and of its second.
    pub start: PaddedPair,
    pub end: PaddedPair,
    /// The same between the edge's first (rows) and second vertex (columns): xx, yx, zx, –, xy, yy, zy, – and xz, yz, zz.
    pub across: [PaddedPair; 2],
}

impl SameRodBlocks {
    pub(crate) const ZERO: SameRodBlocks = SameRodBlocks {
        vertex: PaddedPair([0.0; 8]),
        start: PaddedPair([0.0; 8]),
        end: PaddedPair([0.0; 8]),
        across: [PaddedPair([0.0; 8]); 2],
    };
}

impl BondTable {
    /// Sets `out`, one entry for each vertex, to the blocks of all bonds.
    pub(crate) fn same_rod_blocks(
        &self,
        level: SimdLevel,
        gradients: &[GradientBatch],
        out: &mut [SameRodBlocks],
    ) {
        assert!(out.len() == self.vertices && gradients.len() == self.batches.len());
        out.fill(SameRodBlocks::ZERO);
        // Safety: `BondTable::new` makes vertices and edges less than the number of vertices.
        unsafe { blocks_at(level, &self.batches, gradients, out) }
    }
}

/// Returns the diagonal of u vᵀ + v uᵀ, and the entries above it.
#[inline(always)]
unsafe fn symmetric_product<L: Lanes>(u: [L; 3], v: [L; 3]) -> [[L; 3]; 2] {
    unsafe {
        let sum = |a: usize, b: usize| u[a].mul(v[b]).add(u[b].mul(v[a]));
        [
            [sum(0, 0), sum(1, 1), sum(2, 2)],
            [sum(0, 1), sum(0, 2), sum(1, 2)],
        ]
    }
}

/// Returns the same of u uᵀ.
#[inline(always)]
unsafe fn square<L: Lanes>(u: [L; 3]) -> [[L; 3]; 2] {
    unsafe {
        [
            [u[0].mul(u[0]), u[1].mul(u[1]), u[2].mul(u[2])],
            [u[0].mul(u[1]), u[0].mul(u[2]), u[1].mul(u[2])],
        ]
    }
}

/// Returns the columns of the block between an edge's two vertices, of which the share `t` is the second's: from the derivatives
/// `w` and `turn` of slip and the symmetric parts by d, by both and by e.
#[inline(always)]
unsafe fn across<L: Lanes>(
    t: L,
    [w, turn]: [[L; 3]; 2],
    [by_d, tilts, by_e]: [[[L; 3]; 2]; 3],
) -> [[L; 3]; 3] {
    unsafe {
        let s = L::splat(1.0).sub(t);
        // Rows belong to the first vertex, columns to the second.
        let entries = [
            [(0, 0), (1, 0), (1, 1)],
            [(1, 0), (0, 1), (1, 2)],
            [(1, 1), (1, 2), (0, 2)],
        ];
        let st = s.mul(t);
        let mut across = [[L::splat(0.0); 3]; 3];
        for b in 0..3 {
            for a in 0..3 {
                let (h, k) = entries[a][b];
                across[b][a] = st
                    .mul(by_d[h][k])
                    .sub(s.mul(w[a]).mul(turn[b]))
                    .add(t.mul(w[b]).mul(turn[a]))
                    .add(t.sub(s).mul(tilts[h][k]))
                    .sub(by_e[h][k]);
            }
        }
        across
    }
}

#[inline(always)]
unsafe fn blocks_of<L: Lanes>(
    batches: &[BondBatch],
    gradients: &[GradientBatch],
    out: &mut [SameRodBlocks],
) {
    unsafe {
        let zero = L::splat(0.0);
        let out = out.as_mut_ptr();
        let mut sums = [zero; 4];
        for (batch, gradient) in batches.iter().zip(gradients) {
            let t = L::load(batch.t.as_ptr());
            let s = L::splat(1.0).sub(t);
            let (u, w, turn) = (
                load_single3::<L>(&gradient.opening),
                load_single3::<L>(&gradient.slip_by_d),
                load_single3::<L>(&gradient.slip_by_e),
            );
            let tilt = L::load_single(gradient.opening_by_e.as_ptr());
            let (mut by_d, of_w, mut by_e, mut mixed) = (
                square(u),
                square(w),
                square(turn),
                symmetric_product(w, turn),
            );
            let (mut start, mut end, mut tilts) = ([[zero; 3]; 2], [[zero; 3]; 2], [[zero; 3]; 2]);
            for h in 0..2 {
                for k in 0..3 {
                    let tilted = by_d[h][k].mul(tilt);
                    by_e[h][k] = by_e[h][k].add(tilted.mul(tilt));
                    mixed[h][k] = mixed[h][k].add(tilted.add(tilted));
                    tilts[h][k] = tilted;
                    let a = by_d[h][k].add(of_w[h][k]);
                    by_d[h][k] = a;
                    start[h][k] = s.mul(s.mul(a).add(mixed[h][k])).add(by_e[h][k]);
                    end[h][k] = t.mul(t.mul(a).sub(mixed[h][k])).add(by_e[h][k]);
                }
            }
            let across = across(t, [w, turn], [by_d, tilts, by_e]);
            let vertex = L::pairs(by_d[0], by_d[1]);
            for (k, pair) in vertex.into_iter().enumerate() {
                let to = (&raw mut (*out.add(batch.vertex[k] as usize)).vertex).cast::<f64>();
                L::load(to).add(pair).store(to);
            }
            let edge = [
                L::pairs(start[0], start[1]),
                L::pairs(end[0], end[1]),
                L::pairs(across[0], across[1]),
                L::pairs(across[2], [zero; 3]),
            ];
            for k in 0..WIDTH {
                let keep = (batch.same_edge >> k) & 1;
                for (sum, pairs) in sums.iter_mut().zip(&edge) {
                    *sum = sum.keep_if(keep).add(pairs[k]);
                }
                let to = &mut *out.add(batch.edge[k] as usize);
                sums[0].store(to.start.0.as_mut_ptr());
                sums[1].store(to.end.0.as_mut_ptr());
                sums[2].store(to.across[0].0.as_mut_ptr());
                sums[3].store(to.across[1].0.as_mut_ptr());
            }
        }
    }
}

for_each_level! {
    /// [`blocks_of`] at a level.
    blocks_at = blocks_of(batches: &[BondBatch], gradients: &[GradientBatch], out: &mut [SameRodBlocks])
}
