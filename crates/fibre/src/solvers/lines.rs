//! Rods solved exactly along themselves: the blocks between vertices of one rod that are at most two apart, as a band, in
//! Cholesky's factors. Rods lie side by side in the lanes of a register. Factors are rounded to half the width, which
//! leaves what they stand for symmetric and positive, and halves what a solution has to read.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::iterative::Blocks;
use super::wide;
use crate::bundle::Bundle;
use crate::kernel::Row;
use rayon::prelude::*;

/// Rods that are solved side by side.
const LANES: usize = 8;
/// Groups of rods that one task takes.
const GRAIN: usize = 2;
/// Entries of a row of the widest band: the diagonal and what is below it.
const MOST: usize = 12;

type Lane = [f64; LANES];

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
                wide(
                    #[inline(always)]
                    || {
                        if B == 3 {
                            cholesky::<8>(&mut group.band);
                            group.keep::<8>();
                        } else {
                            cholesky::<11>(&mut group.band);
                            group.keep::<11>();
                        }
                    },
                );
            });
    }

    /// `z` = inverse of the bands × `r`.
    pub fn solve(&self, r: &[Row], z: &mut [Row]) {
        let mut left = z;
        let mut parts = Vec::new();
        for groups in self.groups.chunks(GRAIN) {
            let (from, to) = (groups[0].first[0], groups[groups.len() - 1].first[LANES]);
            let (own, rest) = left.split_at_mut(to - from);
            parts.push((groups, from, own));
            left = rest;
        }
        parts.into_par_iter().for_each(|(groups, from, own)| {
            let mut x = Vec::new();
            for group in groups {
                let longest = group.longest();
                x.clear();
                // Room for the columns of the last rows.
                x.resize(longest * B + MOST, [0.0; LANES]);
                for l in 0..LANES {
                    for (i, v) in (group.first[l]..group.first[l + 1]).enumerate() {
                        (0..B).for_each(|a| x[i * B + a][l] = r[v].0[a]);
                    }
                }
                wide(
                    #[inline(always)]
                    || {
                        if B == 3 {
                            substitute::<8>(&group.factor, &mut x, longest * B);
                        } else {
                            substitute::<11>(&group.factor, &mut x, longest * B);
                        }
                    },
                );
                for l in 0..LANES {
                    for (i, v) in (group.first[l]..group.first[l + 1]).enumerate() {
                        let node = |a: usize| if a < B { x[i * B + a][l] } else { 0.0 };
                        own[v - from].0 = std::array::from_fn(node);
                    }
                }
            }
        });
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

    #[inline(always)]
    fn keep<const W: usize>(&mut self) {
        self.factor.clear();
        for row in &self.band {
            let kept = row[..=W].iter().map(|lane| lane.map(|v| v as f32));
            self.factor.extend(kept);
        }
    }
}

/// Factors bands of `W` entries below the diagonal: of each row the inverse of the pivot and the column of L, whose
/// diagonal is 1. A pivot that is not positive leaves its freedom out.
#[inline(always)]
fn cholesky<const W: usize>(band: &mut [[Lane; MOST]]) {
    let n = band.len();
    for i in 0..n {
        let (done, rest) = band.split_at_mut(i + 1);
        let row = &mut done[i];
        let mut inverse = [0.0; LANES];
        for l in 0..LANES {
            let pivot = row[0][l];
            inverse[l] = if pivot > 0.0 && pivot.is_finite() {
                1.0 / pivot
            } else {
                0.0
            };
        }
        let own = *row;
        for k in 0..W.min(n - 1 - i) {
            let mut by = own[1 + k];
            for l in 0..LANES {
                by[l] *= inverse[l];
            }
            let below = &mut rest[k];
            for m in k..W {
                for l in 0..LANES {
                    below[m - k][l] -= by[l] * own[1 + m][l];
                }
            }
        }
        row[0] = inverse;
        for k in 0..W {
            for l in 0..LANES {
                row[1 + k][l] *= inverse[l];
            }
        }
    }
}

#[inline(always)]
fn double(v: &[f32; LANES]) -> Lane {
    std::array::from_fn(|l| f64::from(v[l]))
}

#[inline(always)]
fn substitute<const W: usize>(factor: &[[f32; LANES]], x: &mut [Lane], rows: usize) {
    for i in 0..rows {
        let column = &factor[i * (W + 1)..(i + 1) * (W + 1)];
        let part = &mut x[i..i + W + 1];
        let v = part[0];
        for k in 1..=W {
            let c = double(&column[k]);
            for l in 0..LANES {
                part[k][l] -= c[l] * v[l];
            }
        }
    }
    x[rows..].fill([0.0; LANES]);
    for i in (0..rows).rev() {
        let column = &factor[i * (W + 1)..(i + 1) * (W + 1)];
        let part = &mut x[i..i + W + 1];
        let mut sums = [[0.0; LANES]; 2];
        for k in 1..=W {
            let c = double(&column[k]);
            for l in 0..LANES {
                sums[k % 2][l] += c[l] * part[k][l];
            }
        }
        let inverse = double(&column[0]);
        for l in 0..LANES {
            part[0][l] = part[0][l] * inverse[l] - (sums[0][l] + sums[1][l]);
        }
    }
}
