//! Rods solved exactly along themselves: the blocks between vertices of one rod that are at most two apart, as a band, in
//! Cholesky's factors. Rods lie side by side in the lanes of a register. Factors are rounded to half the width, which
//! leaves what they stand for symmetric and positive, and halves what a solution has to read.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::band::Blocks;
use crate::bundle::Bundle;
use crate::kernel::{Lane, Row, WIDEST_BAND as MOST, factor_bands, solve_bands};
use rayon::prelude::*;
use std::ops::Range;

/// Rods that are solved side by side.
const LANES: usize = 8;
/// Groups of rods that one task takes.
const GRAIN: usize = 2;

/// Bands of all rods, with `B` freedoms at a vertex.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines<const B: usize> {
    groups: Vec<Group>,
}

/// Rods that lie one after another in the bundle.
#[derive(Debug, Clone)]
struct Group {
    /// First vertex of each rod, and that after the last rod's last; empty lanes have no vertices.
    first: [usize; LANES + 1],
    /// Per freedom of the longest rod: the inverse of the pivot and the column below it; 0 behind the ends of others.
    factor: Vec<[f32; LANES]>,
    /// Room for a band.
    band: Vec<[Lane; MOST]>,
}

impl<const B: usize> Lines<B> {
    /// Entries below the diagonal.
    const WIDTH: usize = 3 * B - 1;

    pub fn prepare(&mut self, bundle: &Bundle) {
        self.groups = (0..bundle.rods())
            .step_by(LANES)
            .map(|rod| Group {
                first: std::array::from_fn(|l| bundle.first[(rod + l).min(bundle.rods())] as usize),
                factor: Vec::new(),
                band: Vec::new(),
            })
            .collect();
    }

    /// Factors the bands.
    pub fn factor(&mut self, value: &[Blocks<B>]) {
        self.groups
            .par_iter_mut()
            .with_min_len(GRAIN)
            .for_each(|group| {
                group.fill(value);
                let width = Self::WIDTH;
                (group.factor).resize(group.band.len() * (width + 1), [0.0; LANES]);
                factor_bands(&mut group.band, width, &mut group.factor);
            });
    }

    /// How many groups of rods there are.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Vertices of some groups.
    pub fn vertices(&self, groups: Range<usize>) -> Range<usize> {
        self.groups[groups.start].first[0]..self.groups[groups.end - 1].first[LANES]
    }

    /// `z` = inverse of the bands of some groups × `r`, of which both begin with the first group's first vertex.
    #[inline(always)]
    pub fn solve(&self, groups: Range<usize>, r: &[Row], z: &mut [Row], x: &mut Vec<Lane>) {
        let from = self.groups[groups.start].first[0];
        for group in &self.groups[groups] {
            let longest = group.longest();
            x.clear();
            // Room for the columns of the last rows.
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

    /// Takes the rods' blocks into the band. The matrix is symmetric: a row to the right is the column below.
    fn fill<const B: usize>(&mut self, value: &[Blocks<B>]) {
        let rows = self.longest() * B;
        self.band.clear();
        self.band.resize(rows, [[0.0; LANES]; MOST]);
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
