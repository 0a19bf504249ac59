//! Rods solved exactly along themselves: of the matrix of a bundle the blocks between vertices of one rod that are at
//! most two apart, as a band, in Cholesky's factors.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::iterative::Node;
use crate::bundle::Bundle;
use rayon::prelude::*;

/// Rods that are solved side by side, in the lanes of a register.
const LANES: usize = 4;
/// Groups of rods that one task takes.
const GRAIN: usize = 4;
/// Most entries below the diagonal: of three blocks of four.
const MOST: usize = 11;

/// The inverse of a pivot, and the column below it, of all lanes.
type Pivot = ([f64; LANES], [[f64; LANES]; MOST]);

/// Bands of all rods, with `B` freedoms at a vertex.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines<const B: usize> {
    groups: Vec<Group>,
    /// Per vertex: entries of the blocks with itself and the next two; `u32::MAX` for none.
    entries: Vec<[u32; 3]>,
}

/// Rods that lie one after another in the bundle.
#[derive(Debug, Clone)]
struct Group {
    /// First vertex of each rod, and that after the last rod's last; empty lanes have no vertices.
    first: [usize; LANES + 1],
    /// Per freedom of the longest rod; 0 behind the ends of the others.
    factor: Vec<Pivot>,
}

impl<const B: usize> Lines<B> {
    pub fn prepare(&mut self, bundle: &Bundle, first: &[u32], column: &[u32]) {
        self.entries.clear();
        for rod in 0..bundle.rods() {
            for v in bundle.rod(rod) {
                let row = first[v] as usize..first[v + 1] as usize;
                self.entries.push([0, 1, 2].map(|k| {
                    let inside = v + k < bundle.first[rod + 1] as usize;
                    let found = column[row.clone()].binary_search(&((v + k) as u32));
                    match found {
                        Ok(at) if inside => (row.start + at) as u32,
                        _ => u32::MAX,
                    }
                }));
            }
        }
        self.groups = (0..bundle.rods())
            .step_by(LANES)
            .map(|rod| {
                let first =
                    std::array::from_fn(|l| bundle.first[(rod + l).min(bundle.rods())] as usize);
                Group {
                    first,
                    factor: Vec::new(),
                }
            })
            .collect();
    }

    /// Factors the bands of a matrix of blocks.
    pub fn factor(&mut self, value: &[[[f64; 4]; B]]) {
        let entries = &self.entries;
        let mut band: Vec<(f64, [f64; MOST])> = Vec::new();
        for group in &mut self.groups {
            let longest = group.first.windows(2).map(|r| r[1] - r[0]).max();
            group.factor.clear();
            group.factor.resize(
                longest.unwrap_or(0) * B,
                ([0.0; LANES], [[0.0; LANES]; MOST]),
            );
            for l in 0..LANES {
                let (start, end) = (group.first[l], group.first[l + 1]);
                band.clear();
                for i in 0..(end - start) * B {
                    band.push(column::<B>(entries, value, start + i / B, i % B));
                }
                cholesky(&mut band, 3 * B - 1);
                for (into, (pivot, column)) in group.factor.iter_mut().zip(&band) {
                    into.0[l] = *pivot;
                    (0..MOST).for_each(|k| into.1[k][l] = column[k]);
                }
            }
        }
    }

    /// `z` = inverse of the bands × `r`.
    pub fn solve(&self, r: &[Node], z: &mut [Node]) {
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
                x.clear();
                // Room for the columns of the last rows.
                x.resize(group.factor.len() + MOST, [0.0; LANES]);
                for l in 0..LANES {
                    for (i, v) in (group.first[l]..group.first[l + 1]).enumerate() {
                        (0..B).for_each(|a| x[i * B + a][l] = r[v][a]);
                    }
                }
                pulp::Arch::new().dispatch(|| {
                    if B == 3 {
                        substitute::<8>(&group.factor, &mut x);
                    } else {
                        substitute::<MOST>(&group.factor, &mut x);
                    }
                });
                for l in 0..LANES {
                    for (i, v) in (group.first[l]..group.first[l + 1]).enumerate() {
                        let node = |a: usize| if a < B { x[i * B + a][l] } else { 0.0 };
                        own[v - from] = std::array::from_fn(node);
                    }
                }
            }
        });
    }
}

/// Freedom `a` of vertex `v`: its diagonal entry and the column below it. The matrix is symmetric: its row to the right is
/// the column below.
fn column<const B: usize>(
    entries: &[[u32; 3]],
    value: &[[[f64; 4]; B]],
    v: usize,
    a: usize,
) -> (f64, [f64; MOST]) {
    let mut made = (0.0, [0.0; MOST]);
    for k in 0..3 {
        let at = entries[v][k];
        if at == u32::MAX {
            continue;
        }
        for b in 0..B {
            let entry = value[at as usize][b][a];
            match (k * B + b).cmp(&a) {
                std::cmp::Ordering::Equal => made.0 = entry,
                std::cmp::Ordering::Greater => made.1[k * B + b - a - 1] = entry,
                std::cmp::Ordering::Less => {}
            }
        }
    }
    made
}

/// Factors a band of `width` entries below the diagonal. A pivot that is not positive leaves its freedom out.
fn cholesky(band: &mut [(f64, [f64; MOST])], width: usize) {
    let n = band.len();
    for i in 0..n {
        let (done, rest) = band.split_at_mut(i + 1);
        let (pivot, column) = &mut done[i];
        if !(*pivot > 0.0 && pivot.is_finite()) {
            (*pivot, *column) = (0.0, [0.0; MOST]);
            continue;
        }
        let inverse = 1.0 / *pivot;
        for k in 0..width.min(n - 1 - i) {
            let by = column[k] * inverse;
            let (diagonal, below) = &mut rest[k];
            *diagonal -= by * column[k];
            for m in k + 1..width {
                below[m - k - 1] -= by * column[m];
            }
        }
        // Columns of L, whose diagonal is 1.
        column.iter_mut().for_each(|c| *c *= inverse);
        *pivot = inverse;
    }
}

#[inline(always)]
fn substitute<const W: usize>(factor: &[Pivot], x: &mut [[f64; LANES]]) {
    for (i, (_, column)) in factor.iter().enumerate() {
        let v = x[i];
        for k in 0..W {
            for l in 0..LANES {
                x[i + 1 + k][l] -= column[k][l] * v[l];
            }
        }
    }
    let n = factor.len();
    x[n..].fill([0.0; LANES]);
    for (i, (inverse, column)) in factor.iter().enumerate().rev() {
        let mut sums = [[0.0; LANES]; 2];
        for k in 0..W {
            for l in 0..LANES {
                sums[k % 2][l] += column[k][l] * x[i + 1 + k][l];
            }
        }
        for l in 0..LANES {
            x[i][l] = x[i][l] * inverse[l] - (sums[0][l] + sums[1][l]);
        }
    }
}
