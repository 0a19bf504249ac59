//! Symmetric positive definite matrices of blocks in an envelope, and their Cholesky factors.
//!
//! Stems are slender. Numbered along the stem ([`super::ordering`]), the matrix of a bundle is a band about as wide as a
//! cross-section, its factor has no entry outside that band, and no ordering fills in much less. Rows are therefore stored
//! dense from their first entry to the diagonal. Every sum runs in one order, in eight lanes without fused operations,
//! whatever instructions the processor has, so that the bits are the same on every machine, which no linear algebra library
//! offers.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use crate::simd::dispatch::with_widest_registers;
use greenstick_geometry::{Cancelled, Context};
use std::ops::Range;

/// Lanes of sums.
const LANES: usize = 8;
/// A pivot below this fraction of its entry on the diagonal cannot be distinguished from 0.
const PIVOT_TOLERANCE: f64 = 1e-13;

/// Multiplications of a factorisation between two checks for cancellation: some milliseconds.
const FACTOR_WORK_PER_CHECK: usize = 1 << 23;
/// Entries that other work goes through between two checks: some milliseconds.
const ENTRIES_PER_CHECK: usize = 1 << 21;

/// Why a matrix has no Cholesky factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FactorError {
    /// The pivot of this row is not positive.
    NotPositive { row: usize },
    /// The caller cancelled the work.
    Cancelled,
}

impl From<Cancelled> for FactorError {
    fn from(_: Cancelled) -> Self {
        FactorError::Cancelled
    }
}

/// A symmetric matrix of `block` × `block` blocks, stored by rows from the first entry to the diagonal.
#[derive(Debug, Clone, Default)]
pub(super) struct EnvelopeMatrix {
    block: usize,
    /// Per block row: its first block column.
    first: Vec<u32>,
    /// Per row: where it starts in `values`.
    start: Vec<usize>,
    values: Vec<f64>,
}

impl EnvelopeMatrix {
    /// Returns a zero matrix with an entry for each of the `pairs` of (numbered) nodes, and all inside the envelope.
    pub fn zeros(block: usize, nodes: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut first: Vec<u32> = (0..nodes as u32).collect();
        for (a, b) in pairs {
            let (low, high) = (a.min(b), a.max(b) as usize);
            first[high] = first[high].min(low);
        }
        let mut start = Vec::with_capacity(nodes * block + 1);
        let mut total = 0;
        for (i, &f) in first.iter().enumerate() {
            for r in 0..block {
                start.push(total);
                total += (i - f as usize) * block + r + 1;
            }
        }
        start.push(total);
        EnvelopeMatrix {
            block,
            first,
            start,
            values: vec![0.0; total],
        }
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.start.len().saturating_sub(1)
    }

    /// Sets all entries to zero.
    ///
    /// # Errors
    /// [`Cancelled`]. Some entries are then as they were.
    pub fn clear(&mut self, context: &Context) -> Result<(), Cancelled> {
        for values in self.values.chunks_mut(ENTRIES_PER_CHECK) {
            context.check()?;
            values.fill(0.0);
        }
        Ok(())
    }

    /// Returns a copy.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn copy(&self, context: &Context) -> Result<Self, Cancelled> {
        let mut values = Vec::with_capacity(self.values.len());
        for part in self.values.chunks(ENTRIES_PER_CHECK) {
            context.check()?;
            values.extend_from_slice(part);
        }
        Ok(EnvelopeMatrix {
            block: self.block,
            first: self.first.clone(),
            start: self.start.clone(),
            values,
        })
    }

    /// Returns the rows in ranges between which work checks for cancellation.
    fn row_ranges(&self) -> Vec<Range<usize>> {
        let (mut ranges, mut from) = (Vec::new(), 0);
        while from < self.rows() {
            let goal = self.start[from] + ENTRIES_PER_CHECK;
            let to = self.start.partition_point(|&s| s <= goal) - 1;
            let to = to.clamp(from + 1, self.rows());
            ranges.push(from..to);
            from = to;
        }
        ranges
    }

    fn first_of(&self, row: usize) -> usize {
        self.first[row / self.block] as usize * self.block
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.values[self.start[row]..self.start[row + 1]]
    }

    /// Adds to an entry below or on the diagonal, which must lie in the envelope.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.start[row] + column - self.first_of(row);
        self.values[at] += value;
    }

    /// Adds to the entries of a row from `column` on, which must lie in the envelope.
    #[inline]
    pub fn add_row(&mut self, row: usize, column: usize, values: &[f64]) {
        let at = self.start[row] + column - self.first_of(row);
        axpy(&mut self.values[at..at + values.len()], values, 1.0);
    }

    /// Returns the entry on the diagonal.
    pub fn diagonal(&self, row: usize) -> f64 {
        self.values[self.start[row + 1] - 1]
    }

    /// Sets `out` to matrix × `x`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn multiply(&self, x: &[f64], out: &mut [f64], context: &Context) -> Result<(), Cancelled> {
        out.fill(0.0);
        for rows in self.row_ranges() {
            context.check()?;
            with_widest_registers(
                #[inline(always)]
                || {
                    for i in rows {
                        let (f, row) = (self.first_of(i), self.row(i));
                        let (last, below) = (row[row.len() - 1], &row[..row.len() - 1]);
                        out[i] += dot(below, &x[f..i]) + last * x[i];
                        axpy(&mut out[f..i], below, x[i]);
                    }
                },
            );
        }
        Ok(())
    }

    /// Removes held rows and columns from the system: zero, with 1 on the diagonal.
    ///
    /// # Errors
    /// [`Cancelled`]. Some rows are then as they were.
    pub fn remove_held(&mut self, held: &[bool], context: &Context) -> Result<(), Cancelled> {
        for rows in self.row_ranges() {
            context.check()?;
            self.remove_held_of(rows, held);
        }
        Ok(())
    }

    fn remove_held_of(&mut self, rows: Range<usize>, held: &[bool]) {
        for i in rows {
            let (f, range) = (self.first_of(i), self.start[i]..self.start[i + 1]);
            let row = &mut self.values[range];
            let last = row.len() - 1;
            if held[i] {
                row.fill(0.0);
                row[last] = 1.0;
            } else {
                for (v, h) in row[..last].iter_mut().zip(&held[f..i]) {
                    if *h {
                        *v = 0.0;
                    }
                }
            }
        }
    }

    /// Replaces the matrix by its Cholesky factor.
    ///
    /// # Errors
    /// [`FactorError`]. The contents of the matrix are then lost.
    pub fn factor(&mut self, context: &Context) -> Result<(), FactorError> {
        let rows = self.first.len();
        let mut start = 0;
        while start < rows {
            context.check()?;
            let end = self.rows_worth(start, FACTOR_WORK_PER_CHECK);
            with_widest_registers(
                #[inline(always)]
                || match self.block {
                    3 => self.factor_rows::<3>(start..end),
                    _ => self.factor_rows::<4>(start..end),
                },
            )?;
            start = end;
        }
        Ok(())
    }

    /// Returns the end of the block rows from `start` on whose factor takes about `work` multiplications.
    fn rows_worth(&self, start: usize, work: usize) -> usize {
        let mut done = 0;
        for i in start..self.first.len() {
            let width = (i - self.first[i] as usize + 1) * self.block;
            done += width * width * self.block / 2;
            if done >= work {
                return i + 1;
            }
        }
        self.first.len()
    }

    /// Factors block rows, after all those before them.
    #[inline(always)]
    fn factor_rows<const B: usize>(&mut self, rows: Range<usize>) -> Result<(), FactorError> {
        for i in rows {
            let first = self.first[i] as usize;
            let (done, rest) = self.values.split_at_mut(self.start[i * B]);
            // Where the rows of the block row begin; all of them begin at the same column.
            let mut offsets = [0; B];
            let mut length = 0;
            for (r, o) in offsets.iter_mut().enumerate() {
                *o = length;
                length += (i - first) * B + r + 1;
            }
            for j in first..i {
                let from = (self.first[j] as usize).max(first) * B;
                let count = j * B - from;
                let skip = from - self.first[j] as usize * B;
                let lower: [&[f64]; B] = std::array::from_fn(|c| {
                    let at = self.start[j * B + c] + skip;
                    &done[at..at + count + c + 1]
                });
                let here = from - first * B;
                let sums = {
                    let upper: [&[f64]; B] = std::array::from_fn(|r| {
                        &rest[offsets[r] + here..offsets[r] + here + count]
                    });
                    products(&upper, &lower, count)
                };
                for r in 0..B {
                    let row = &mut rest[offsets[r] + here + count..][..B];
                    for c in 0..B {
                        let mut v = row[c] - sums[r][c];
                        for k in 0..c {
                            v -= row[k] * lower[c][count + k];
                        }
                        row[c] = v / lower[c][count + c];
                    }
                }
            }
            let count = (i - first) * B;
            let own = {
                let rows: [&[f64]; B] =
                    std::array::from_fn(|r| &rest[offsets[r]..offsets[r] + count]);
                products(&rows, &rows, count)
            };
            let mut small = [[0.0; B]; B];
            for r in 0..B {
                for c in 0..=r {
                    let entry = rest[offsets[r] + count + c];
                    let mut v = entry - own[r][c];
                    for k in 0..c {
                        v -= small[r][k] * small[c][k];
                    }
                    if r == c {
                        if v.is_nan() || v <= PIVOT_TOLERANCE * entry.abs() {
                            return Err(FactorError::NotPositive { row: i * B + r });
                        }
                        small[r][c] = v.sqrt();
                    } else {
                        small[r][c] = v / small[c][c];
                    }
                    rest[offsets[r] + count + c] = small[r][c];
                }
            }
        }
        Ok(())
    }

    /// Solves with the factor that [`EnvelopeMatrix::factor`] made, in place. This is for small matrices.
    pub fn solve(&self, x: &mut [f64]) {
        self.solve_forwards(0..self.rows(), x);
        self.solve_backwards(0..self.rows(), x);
    }

    /// The same for matrices of any size.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn solve_large(&self, x: &mut [f64], context: &Context) -> Result<(), Cancelled> {
        let ranges = self.row_ranges();
        for rows in &ranges {
            context.check()?;
            self.solve_forwards(rows.clone(), x);
        }
        for rows in ranges.iter().rev() {
            context.check()?;
            self.solve_backwards(rows.clone(), x);
        }
        Ok(())
    }

    fn solve_forwards(&self, rows: Range<usize>, x: &mut [f64]) {
        with_widest_registers(
            #[inline(always)]
            || {
                for i in rows {
                    let (f, row) = (self.first_of(i), self.row(i));
                    let last = row.len() - 1;
                    x[i] = (x[i] - dot(&row[..last], &x[f..i])) / row[last];
                }
            },
        );
    }

    fn solve_backwards(&self, rows: Range<usize>, x: &mut [f64]) {
        with_widest_registers(
            #[inline(always)]
            || {
                for i in rows.rev() {
                    let (f, row) = (self.first_of(i), self.row(i));
                    let last = row.len() - 1;
                    x[i] /= row[last];
                    let v = -x[i];
                    axpy(&mut x[f..i], &row[..last], v);
                }
            },
        );
    }
}

/// Returns the products of all pairs of rows.
#[inline(always)]
fn products<const B: usize>(a: &[&[f64]; B], b: &[&[f64]; B], count: usize) -> [[f64; B]; B] {
    let mut lanes = [[[0.0; LANES]; B]; B];
    let whole = count / LANES * LANES;
    let mut k = 0;
    while k < whole {
        let left: [[f64; LANES]; B] = std::array::from_fn(|r| eight(&a[r][k..k + LANES]));
        for c in 0..B {
            let right = eight(&b[c][k..k + LANES]);
            for r in 0..B {
                for l in 0..LANES {
                    lanes[r][c][l] += left[r][l] * right[l];
                }
            }
        }
        k += LANES;
    }
    let mut sums = [[0.0; B]; B];
    for r in 0..B {
        for c in 0..B {
            let mut sum = total(&lanes[r][c]);
            for k in whole..count {
                sum += a[r][k] * b[c][k];
            }
            sums[r][c] = sum;
        }
    }
    sums
}

#[inline(always)]
fn eight(from: &[f64]) -> [f64; LANES] {
    let mut made = [0.0; LANES];
    made.copy_from_slice(from);
    made
}

#[inline(always)]
fn total(l: &[f64; LANES]) -> f64 {
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (aw, bw) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let (ar, br) = (aw.remainder(), bw.remainder());
    for (x, y) in aw.zip(bw) {
        for l in 0..LANES {
            lanes[l] += x[l] * y[l];
        }
    }
    let mut sum = total(&lanes);
    for (x, y) in ar.iter().zip(br) {
        sum += x * y;
    }
    sum
}

#[inline(always)]
fn axpy(to: &mut [f64], from: &[f64], by: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += f * by;
    }
}

/// Solves A x = b by conjugate gradients, preconditioned with the factor of a matrix similar to A. Returns whether at most
/// `max_iterations` reduce the residual to `tolerance` of b.
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(super) fn conjugate_gradients(
    a: &EnvelopeMatrix,
    factor: &EnvelopeMatrix,
    b: &[f64],
    x: &mut [f64],
    Accuracy {
        tolerance,
        max_iterations,
    }: Accuracy,
    context: &Context,
) -> Result<bool, Cancelled> {
    let n = b.len();
    x.fill(0.0);
    let goal = tolerance * dot(b, b).sqrt();
    let mut r = b.to_vec();
    let mut z = r.clone();
    factor.solve_large(&mut z, context)?;
    let mut p = z.clone();
    let mut q = vec![0.0; n];
    let mut rz = dot(&r, &z);
    for _ in 0..=max_iterations {
        context.check()?;
        if dot(&r, &r).sqrt() <= goal {
            return Ok(true);
        }
        a.multiply(&p, &mut q, context)?;
        let curvature = dot(&p, &q);
        if curvature.is_nan() || curvature <= 0.0 {
            return Ok(false);
        }
        let alpha = rz / curvature;
        axpy(x, &p, alpha);
        axpy(&mut r, &q, -alpha);
        z.copy_from_slice(&r);
        factor.solve_large(&mut z, context)?;
        let next = dot(&r, &z);
        let beta = next / rz;
        rz = next;
        for (p, z) in p.iter_mut().zip(&z) {
            *p = z + beta * *p;
        }
    }
    Ok(false)
}

/// When conjugate gradients stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    /// The residual over b at which the solution is accepted.
    pub tolerance: f64,
    pub max_iterations: usize,
}

#[cfg(test)]
mod tests {
    use super::super::ordering::reverse_cuthill_mckee;
    use super::*;
    use greenstick_wood::noise::unit;

    /// A diagonally dominant matrix of a random graph, dense and in an envelope.
    fn example(block: usize, nodes: usize) -> (Vec<Vec<f64>>, EnvelopeMatrix) {
        let mut pairs = Vec::new();
        for i in 0..nodes as i64 {
            for j in 0..i {
                if unit(1, i, j, 0) < 0.15 {
                    pairs.push((i as u32, j as u32));
                }
            }
        }
        let order = reverse_cuthill_mckee(nodes, &pairs);
        let mut number = vec![u32::MAX; nodes];
        for (k, &v) in order.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        assert!(number.iter().all(|&p| p != u32::MAX));
        let numbered: Vec<(u32, u32)> = pairs
            .iter()
            .map(|&(a, b)| (number[a as usize], number[b as usize]))
            .collect();
        let n = block * nodes;
        let mut dense = vec![vec![0.0; n]; n];
        let mut envelope = EnvelopeMatrix::zeros(block, nodes, numbered.iter().copied());
        let own = (0..nodes as u32).map(|v| (v, v));
        for (a, b) in numbered.into_iter().chain(own) {
            for r in 0..block {
                for c in 0..block {
                    let (i, j) = (a as usize * block + r, b as usize * block + c);
                    let (i, j) = (i.max(j), i.min(j));
                    if dense[i][j] == 0.0 {
                        let v = if i == j {
                            n as f64
                        } else {
                            unit(2, i as i64, j as i64, 0) - 0.5
                        };
                        (dense[i][j], dense[j][i]) = (v, v);
                        envelope.add(i, j, v);
                    }
                }
            }
        }
        (dense, envelope)
    }

    #[test]
    fn factors_and_conjugate_gradients_solve_the_dense_system() {
        for block in [3, 4] {
            let (dense, a) = example(block, 40);
            let n = a.rows();
            let x: Vec<f64> = (0..n).map(|i| unit(3, i as i64, 0, 0) - 0.5).collect();
            let b: Vec<f64> = dense
                .iter()
                .map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum())
                .collect();
            let mut product = vec![0.0; n];
            a.multiply(&x, &mut product, &Context::quiet()).unwrap();
            let mut l = a.clone();
            l.factor(&Context::quiet()).unwrap();
            let mut solved = b.clone();
            l.solve(&mut solved);
            // The factor of another matrix, which has only the diagonal in common.
            let mut near = EnvelopeMatrix::zeros(block, n / block, std::iter::empty());
            (0..n).for_each(|i| near.add(i, i, a.diagonal(i)));
            near.factor(&Context::quiet()).unwrap();
            let mut found = vec![0.0; n];
            let accuracy = Accuracy {
                tolerance: 1e-13,
                max_iterations: 200,
            };
            let context = Context::quiet();
            let done = conjugate_gradients(&a, &near, &b, &mut found, accuracy, &context);
            assert_eq!(done, Ok(true));
            for i in 0..n {
                assert!((product[i] - b[i]).abs() < 1e-12 * n as f64);
                assert!((solved[i] - x[i]).abs() < 1e-13, "{} {}", solved[i], x[i]);
                assert!((found[i] - x[i]).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_refused() {
        let mut a = EnvelopeMatrix::zeros(3, 2, [(0, 1)].into_iter());
        (0..6).for_each(|i| a.add(i, i, 1.0));
        a.add(4, 0, 2.0);
        assert_eq!(
            a.factor(&Context::quiet()),
            Err(FactorError::NotPositive { row: 4 })
        );
    }
}
