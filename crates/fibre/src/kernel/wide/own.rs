//! What linear bonds have between vertices of one rod, of the matrix of all of them: blocks g gᵀ of a bond's gradients by
//! its vertex, and by the two of its edge ([`super::slopes`]), summed for each vertex and each edge.

use super::bonds::{BondTable, Eight};
use super::lanes::{Lanes, Level, Pair, WIDTH, for_each_level};
use super::slopes::{Slopes, single3};

/// Blocks of one vertex and of the edge that begins there. Symmetric ones are xx, yy, zz, –, xy, xz, yz, –.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Own {
    /// Of bonds that start at the vertex.
    pub vertex: Pair,
    /// Of bonds that end on the edge: with its first vertex, and with its second.
    pub start: Pair,
    pub end: Pair,
    /// Between its first (rows) and second vertex (columns): xx, yx, zx, –, xy, yy, zy, – and xz, yz, zz.
    pub across: [Pair; 2],
}

impl Own {
    pub(crate) const NONE: Own = Own {
        vertex: Pair([0.0; 8]),
        start: Pair([0.0; 8]),
        end: Pair([0.0; 8]),
        across: [Pair([0.0; 8]); 2],
    };
}

impl BondTable {
    /// Sets `out`, of as many as there are vertices, to the blocks of all bonds.
    pub(crate) fn own_blocks(&self, level: Level, slopes: &[Slopes], out: &mut [Own]) {
        assert!(out.len() == self.vertices && slopes.len() == self.eights.len());
        out.fill(Own::NONE);
        // Safety: vertices and edges are below the number of vertices, by `BondTable::new`.
        unsafe { own_at(level, &self.eights, slopes, out) }
    }
}

/// Entries on the diagonal and above it of u vᵀ + v uᵀ.
#[inline(always)]
unsafe fn twice<L: Lanes>(u: [L; 3], v: [L; 3]) -> [[L; 3]; 2] {
    unsafe {
        let both = |a: usize, b: usize| u[a].mul(v[b]).add(u[b].mul(v[a]));
        [
            [both(0, 0), both(1, 1), both(2, 2)],
            [both(0, 1), both(0, 2), both(1, 2)],
        ]
    }
}

/// Those of u uᵀ.
#[inline(always)]
unsafe fn square<L: Lanes>(u: [L; 3]) -> [[L; 3]; 2] {
    unsafe {
        [
            [u[0].mul(u[0]), u[1].mul(u[1]), u[2].mul(u[2])],
            [u[0].mul(u[1]), u[0].mul(u[2]), u[1].mul(u[2])],
        ]
    }
}

#[inline(always)]
unsafe fn own_of<L: Lanes>(eights: &[Eight], slopes: &[Slopes], out: &mut [Own]) {
    unsafe {
        let zero = L::splat(0.0);
        let out = out.as_mut_ptr();
        let mut sums = [zero; 4];
        for (eight, slope) in eights.iter().zip(slopes) {
            let t = L::load(eight.t.as_ptr());
            let s = L::splat(1.0).sub(t);
            let (u, w, turn) = (
                single3::<L>(&slope.length),
                single3::<L>(&slope.by_d),
                single3::<L>(&slope.by_e),
            );
            let (mut by_d, of_w, by_e, mixed) =
                (square(u), square(w), square(turn), twice(w, turn));
            let (mut start, mut end) = ([[zero; 3]; 2], [[zero; 3]; 2]);
            for h in 0..2 {
                for k in 0..3 {
                    let a = by_d[h][k].add(of_w[h][k]);
                    by_d[h][k] = a;
                    start[h][k] = s.mul(s.mul(a).add(mixed[h][k])).add(by_e[h][k]);
                    end[h][k] = t.mul(t.mul(a).sub(mixed[h][k])).add(by_e[h][k]);
                }
            }
            // Rows of the first vertex, columns of the second.
            let place = [
                [(0, 0), (1, 0), (1, 1)],
                [(1, 0), (0, 1), (1, 2)],
                [(1, 1), (1, 2), (0, 2)],
            ];
            let st = s.mul(t);
            let mut across = [[zero; 3]; 3];
            for b in 0..3 {
                for a in 0..3 {
                    let (h, k) = place[a][b];
                    across[b][a] = st
                        .mul(by_d[h][k])
                        .sub(s.mul(w[a]).mul(turn[b]))
                        .add(t.mul(w[b]).mul(turn[a]))
                        .sub(by_e[h][k]);
                }
            }
            let vertex = L::pairs(by_d[0], by_d[1]);
            for (k, pair) in vertex.into_iter().enumerate() {
                let to = (&raw mut (*out.add(eight.vertex[k] as usize)).vertex).cast::<f64>();
                L::load(to).add(pair).store(to);
            }
            let edge = [
                L::pairs(start[0], start[1]),
                L::pairs(end[0], end[1]),
                L::pairs(across[0], across[1]),
                L::pairs(across[2], [zero; 3]),
            ];
            for k in 0..WIDTH {
                let keep = (eight.same >> k) & 1;
                for (sum, pairs) in sums.iter_mut().zip(&edge) {
                    *sum = sum.kept(keep).add(pairs[k]);
                }
                let to = &mut *out.add(eight.edge[k] as usize);
                sums[0].store(to.start.0.as_mut_ptr());
                sums[1].store(to.end.0.as_mut_ptr());
                sums[2].store(to.across[0].0.as_mut_ptr());
                sums[3].store(to.across[1].0.as_mut_ptr());
            }
        }
    }
}

for_each_level! {
    /// [`own_of`] at a level.
    own_at = own_of(eights: &[Eight], slopes: &[Slopes], out: &mut [Own])
}
