//! The fine level of the preconditioner: each rod solved exactly along itself. Its blocks between vertices that are at most
//! two apart form a band, of which there is a Cholesky factor. Rods lie side by side in the lanes of a register. Factors are
//! rounded to single precision; the matrix that they stand for is still symmetric and positive, and a solution reads half
//! the bytes.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::rod_blocks::RodBlocks;
use crate::rod_bundle::RodBundle;
use crate::simd::banded_cholesky::{Lane, MAX_ROW, factor_bands, solve_bands};
use crate::simd::lanes::PaddedVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Rods that are solved side by side.
const LANES: usize = 8;
/// Groups of rods that one task factors.
const GROUPS_PER_TASK: usize = 2;

/// Factored bands of all rods, with `B` degrees of freedom at a vertex.
#[derive(Debug, Clone, Default)]
pub(super) struct BandedPreconditioner<const B: usize> {
    groups: Vec<Group>,
}

/// Rods that lie one after another in the bundle.
#[derive(Debug, Clone)]
struct Group {
    /// First vertex of each rod, and the vertex behind the last rod's last; empty lanes have no vertices.
    first: [usize; LANES + 1],
    /// Per degree of freedom of the longest rod: the inverse of the pivot and the column below it; 0 behind the ends of
    /// shorter rods.
    factor: Vec<[f32; LANES]>,
    /// Buffer for the band.
    band: Vec<[Lane; MAX_ROW]>,
}

impl<const B: usize> BandedPreconditioner<B> {
    /// Entries below the diagonal.
    const WIDTH: usize = 3 * B - 1;

    /// Groups the rods of a bundle.
    pub fn prepare(&mut self, bundle: &RodBundle) {
        self.groups = (0..bundle.rods())
            .step_by(LANES)
            .map(|rod| Group {
                first: std::array::from_fn(|l| {
                    bundle.rod_offsets[(rod + l).min(bundle.rods())] as usize
                }),
                factor: Vec::new(),
                band: Vec::new(),
            })
            .collect();
    }

    /// Factors the bands.
    pub fn factor(&mut self, value: &[RodBlocks<B>]) {
        self.groups
            .par_iter_mut()
            .with_min_len(GROUPS_PER_TASK)
            .for_each(|group| {
                group.fill(value);
                let width = Self::WIDTH;
                (group.factor).resize(group.band.len() * (width + 1), [0.0; LANES]);
                factor_bands(&mut group.band, width, &mut group.factor);
            });
    }

    /// Returns the number of groups of rods.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Returns the vertices of some groups.
    pub fn vertices(&self, groups: Range<usize>) -> Range<usize> {
        self.groups[groups.start].first[0]..self.groups[groups.end - 1].first[LANES]
    }

    /// Solves the bands of some groups for the right side `r`, into `z`; both begin with the first group's first vertex.
    #[inline(always)]
    pub fn solve(
        &self,
        groups: Range<usize>,
        r: &[PaddedVec3],
        z: &mut [PaddedVec3],
        x: &mut Vec<Lane>,
    ) {
        let from = self.groups[groups.start].first[0];
        for group in &self.groups[groups] {
            let longest = group.longest();
            x.clear();
            // The columns of the last rows reach beyond the end.
            x.resize(longest * B + Self::WIDTH, [0.0; LANES]);
            for l in 0..LANES {
                let own = &r[group.first[l] - from..group.first[l + 1] - from];
                for (x, r) in x.chunks_exact_mut(B).zip(own) {
                    (0..B).for_each(|a| x[a][l] = r.0[a]);
                }
            }
            solve_bands(&group.factor, Self::WIDTH, x);
            for l in 0..LANES {
                let own = &mut z[group.first[l] - from..group.first[l + 1] - from];
                for (x, z) in x.chunks_exact(B).zip(own) {
                    z.0 = [0.0; 4];
                    (0..B).for_each(|a| z.0[a] = x[a][l]);
                }
            }
        }
    }
}

impl Group {
    fn longest(&self) -> usize {
        let lengths = self.first.windows(2).map(|r| r[1] - r[0]);
        lengths.max().unwrap_or(0)
    }

    /// Copies the rods' blocks into the band. The matrix is symmetric: a row to the right of the diagonal is the column below
    /// it.
    fn fill<const B: usize>(&mut self, value: &[RodBlocks<B>]) {
        let rows = self.longest() * B;
        self.band.clear();
        self.band.resize(rows, [[0.0; LANES]; MAX_ROW]);
        for l in 0..LANES {
            let (start, end) = (self.first[l], self.first[l + 1]);
            for v in start..end {
                for (k, block) in value[v].iter().enumerate() {
                    if v + k >= end {
                        break;
                    }
                    for a in 0..B {
                        let row = &mut self.band[(v - start) * B + a];
                        for b in if k == 0 { a } else { 0 }..B {
                            row[k * B + b - a][l] = block[b][a];
                        }
                    }
                }
            }
        }
    }
}
