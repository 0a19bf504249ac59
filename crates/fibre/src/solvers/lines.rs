//! Rods solved exactly along themselves: of the matrix of a bundle the blocks between vertices of one rod that are at
//! most two apart, as a band, in Cholesky's factors.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::iterative::Node;
use crate::bundle::Bundle;
use rayon::prelude::*;

/// Rods that one task takes.
const GRAIN: usize = 8;
/// Most entries below the diagonal: of three blocks of four.
const MOST: usize = 11;

/// Bands of all rods, with `B` freedoms at a vertex.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines<const B: usize> {
    /// First vertex of each rod, and the number of vertices at the end.
    first: Vec<u32>,
    /// Per vertex: entries of the blocks with itself and the next two; `u32::MAX` for none.
    entries: Vec<[u32; 3]>,
    /// Per freedom: the inverse of the pivot, and the column below it.
    factor: Vec<(f64, [f64; MOST])>,
}

impl<const B: usize> Lines<B> {
    pub fn prepare(&mut self, bundle: &Bundle, first: &[u32], column: &[u32]) {
        self.first.clone_from(&bundle.first);
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
        self.factor = vec![(0.0, [0.0; MOST]); bundle.vertices() * B];
    }

    /// Factors the bands of a matrix of blocks.
    pub fn factor(&mut self, value: &[[[f64; 4]; B]]) {
        let (first, entries) = (&self.first, &self.entries);
        let mut left = self.factor.as_mut_slice();
        let mut parts = Vec::new();
        for rod in first.windows(2) {
            let (own, rest) = left.split_at_mut((rod[1] - rod[0]) as usize * B);
            parts.push((rod[0] as usize, own));
            left = rest;
        }
        for (start, own) in &mut parts {
            for (i, column) in own.iter_mut().enumerate() {
                // The matrix is symmetric: its row to the right is the column below.
                let (v, a) = (*start + i / B, i % B);
                *column = (0.0, [0.0; MOST]);
                for k in 0..3 {
                    let at = entries[v][k];
                    if at == u32::MAX {
                        continue;
                    }
                    for b in 0..B {
                        let entry = value[at as usize][b][a];
                        match (k * B + b).cmp(&a) {
                            std::cmp::Ordering::Equal => column.0 = entry,
                            std::cmp::Ordering::Greater => column.1[k * B + b - a - 1] = entry,
                            std::cmp::Ordering::Less => {}
                        }
                    }
                }
            }
            cholesky(own, 3 * B - 1);
        }
    }

    /// `z` = inverse of the bands × `r`.
    pub fn solve(&self, r: &[Node], z: &mut [Node]) {
        let mut left = z;
        let mut parts = Vec::new();
        for rods in self.first.windows(2).collect::<Vec<_>>().chunks(GRAIN) {
            let (from, to) = (rods[0][0] as usize, rods[rods.len() - 1][1] as usize);
            let (own, rest) = left.split_at_mut(to - from);
            parts.push((rods.to_vec(), from, own));
            left = rest;
        }
        parts.into_par_iter().for_each(|(rods, from, own)| {
            let mut x = Vec::new();
            for rod in rods {
                let (start, end) = (rod[0] as usize, rod[1] as usize);
                x.clear();
                x.extend(r[start..end].iter().flat_map(|r| &r[..B]));
                // Room for the columns of the last rows.
                x.resize((end - start) * B + MOST, 0.0);
                let factor = &self.factor[start * B..end * B];
                pulp::Arch::new().dispatch(|| substitute(factor, &mut x));
                for v in start..end {
                    let at = (v - start) * B;
                    own[v - from] = std::array::from_fn(|a| if a < B { x[at + a] } else { 0.0 });
                }
            }
        });
    }
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
fn substitute(factor: &[(f64, [f64; MOST])], x: &mut [f64]) {
    for (i, (_, column)) in factor.iter().enumerate() {
        let v = x[i];
        for k in 0..MOST {
            x[i + 1 + k] -= column[k] * v;
        }
    }
    let n = factor.len();
    x[n..].fill(0.0);
    for (i, (inverse, column)) in factor.iter().enumerate().rev() {
        let mut sums = [0.0; 2];
        for k in 0..MOST {
            sums[k % 2] += column[k] * x[i + 1 + k];
        }
        x[i] = x[i] * inverse - (sums[0] + sums[1]);
    }
}
