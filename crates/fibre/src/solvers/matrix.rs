//! Symmetric positive definite matrices of blocks in an envelope, and their Cholesky factors.
//!
//! Stems are slender. Numbered along the stem (reverse Cuthill–McKee 1969), the matrix of a bundle is a band about as
//! wide as a section, its factor has no entry outside that band, and no ordering fills in much less: so rows are kept
//! dense from their first entry to the diagonal. Every sum runs in one order, in eight lanes without fused operations,
//! whatever instructions the processor has: the same bits on every machine, which no linear algebra library offers.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::wide;
use std::collections::VecDeque;

/// Lanes of sums.
const LANES: usize = 8;
/// A pivot below this part of its entry on the diagonal is not told from 0.
const LEAST_PIVOT: f64 = 1e-13;

/// The order in which nodes are numbered, from their neighbours (each pair once or twice).
pub fn order(nodes: usize, pairs: &[(u32, u32)]) -> Vec<u32> {
    let mut first = vec![0usize; nodes + 1];
    for &(a, b) in pairs {
        first[a as usize + 1] += 1;
        first[b as usize + 1] += 1;
    }
    for i in 0..nodes {
        first[i + 1] += first[i];
    }
    let mut next = first.clone();
    let mut list = vec![0u32; 2 * pairs.len()];
    for &(a, b) in pairs {
        for (from, to) in [(a, b), (b, a)] {
            list[next[from as usize]] = to;
            next[from as usize] += 1;
        }
    }
    let near = |v: u32| &list[first[v as usize]..first[v as usize + 1]];
    let mut made = Vec::with_capacity(nodes);
    let mut seen = vec![u32::MAX; nodes];
    let mut queue = VecDeque::new();
    let mut round = 0;
    // Nodes in order of breadth from a start; the last is far from it.
    let mut walk = |start: u32, mark: u32, seen: &mut Vec<u32>, out: &mut Vec<u32>| {
        queue.push_back(start);
        seen[start as usize] = mark;
        while let Some(v) = queue.pop_front() {
            out.push(v);
            let from = queue.len();
            for &w in near(v) {
                if seen[w as usize] != mark {
                    seen[w as usize] = mark;
                    queue.push_back(w);
                }
            }
            queue.make_contiguous()[from..].sort_by_key(|&w| (near(w).len(), w));
        }
    };
    for v in 0..nodes as u32 {
        if seen[v as usize] != u32::MAX {
            continue;
        }
        let mut start = v;
        let mut found = Vec::new();
        for _ in 0..3 {
            found.clear();
            walk(start, round, &mut seen, &mut found);
            start = found.last().copied().unwrap_or(v);
            round += 1;
        }
        made.append(&mut found);
    }
    made.reverse();
    made
}

/// A symmetric matrix of `block` × `block` blocks; of each row the entries from its first to the diagonal.
#[derive(Debug, Clone, Default)]
pub struct Envelope {
    block: usize,
    /// Per block row: its first block column.
    first: Vec<u32>,
    /// Per row: where it starts in `values`.
    start: Vec<usize>,
    values: Vec<f64>,
}

impl Envelope {
    /// Zeros where `pairs` of nodes (already numbered) have entries, and all inside the envelope.
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
        Envelope {
            block,
            first,
            start,
            values: vec![0.0; total],
        }
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.start.len().saturating_sub(1)
    }

    /// Entries kept.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
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

    /// Adds to entries of a row from `column` on, which must lie in the envelope.
    #[inline]
    pub fn add_row(&mut self, row: usize, column: usize, values: &[f64]) {
        let at = self.start[row] + column - self.first_of(row);
        axpy(&mut self.values[at..at + values.len()], values, 1.0);
    }

    /// The entry on the diagonal.
    pub fn diagonal(&self, row: usize) -> f64 {
        self.values[self.start[row + 1] - 1]
    }

    /// `out` = matrix × `x`.
    pub fn multiply(&self, x: &[f64], out: &mut [f64]) {
        wide(
            #[inline(always)]
            || {
                out.fill(0.0);
                for i in 0..self.rows() {
                    let (f, row) = (self.first_of(i), self.row(i));
                    let (last, below) = (row[row.len() - 1], &row[..row.len() - 1]);
                    out[i] += dot(below, &x[f..i]) + last * x[i];
                    axpy(&mut out[f..i], below, x[i]);
                }
            },
        );
    }

    /// Takes rows and columns out of the system: zero, with 1 on the diagonal.
    pub fn hold(&mut self, held: &[bool]) {
        for i in 0..self.rows() {
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

    /// Replaces the matrix by its Cholesky factor. Where a pivot is not positive, its row is returned.
    ///
    /// # Errors
    /// The row of the pivot.
    pub fn factor(&mut self) -> Result<(), usize> {
        wide(
            #[inline(always)]
            || match self.block {
                3 => self.factor_blocks::<3>(),
                _ => self.factor_blocks::<4>(),
            },
        )
    }

    #[inline(always)]
    fn factor_blocks<const B: usize>(&mut self) -> Result<(), usize> {
        for i in 0..self.first.len() {
            let first = self.first[i] as usize;
            let (done, rest) = self.values.split_at_mut(self.start[i * B]);
            // The block row copied so that its rows begin at one column.
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
                        if v.is_nan() || v <= LEAST_PIVOT * entry.abs() {
                            return Err(i * B + r);
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

    /// Solves with the factor that [`Envelope::factor`] made, in place.
    pub fn solve(&self, x: &mut [f64]) {
        wide(
            #[inline(always)]
            || {
                for i in 0..self.rows() {
                    let (f, row) = (self.first_of(i), self.row(i));
                    let last = row.len() - 1;
                    x[i] = (x[i] - dot(&row[..last], &x[f..i])) / row[last];
                }
                for i in (0..self.rows()).rev() {
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

/// Products of all pairs of rows.
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

/// Solves A x = b by conjugate gradients, with a factor of a matrix near A. Returns the iterations done, or `None` where
/// `most` of them do not bring the residual down to `tolerance` of b.
pub fn conjugate_gradients(
    a: &Envelope,
    factor: &Envelope,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    most: usize,
) -> Option<usize> {
    let n = b.len();
    x.fill(0.0);
    let goal = tolerance * dot(b, b).sqrt();
    let mut r = b.to_vec();
    let mut z = r.clone();
    factor.solve(&mut z);
    let mut p = z.clone();
    let mut q = vec![0.0; n];
    let mut rz = dot(&r, &z);
    for iteration in 0..=most {
        if dot(&r, &r).sqrt() <= goal {
            return Some(iteration);
        }
        a.multiply(&p, &mut q);
        let curvature = dot(&p, &q);
        if curvature.is_nan() || curvature <= 0.0 {
            return None;
        }
        let alpha = rz / curvature;
        axpy(x, &p, alpha);
        axpy(&mut r, &q, -alpha);
        z.copy_from_slice(&r);
        factor.solve(&mut z);
        let next = dot(&r, &z);
        let beta = next / rz;
        rz = next;
        for (p, z) in p.iter_mut().zip(&z) {
            *p = z + beta * *p;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_wood::noise::unit;

    /// A diagonally dominant matrix of a graph of chance, dense, and the same in an envelope.
    fn example(block: usize, nodes: usize) -> (Vec<Vec<f64>>, Envelope) {
        let mut pairs = Vec::new();
        for i in 0..nodes as i64 {
            for j in 0..i {
                if unit(1, i, j, 0) < 0.15 {
                    pairs.push((i as u32, j as u32));
                }
            }
        }
        let order = order(nodes, &pairs);
        let mut place = vec![u32::MAX; nodes];
        for (k, &v) in order.iter().enumerate() {
            place[v as usize] = k as u32;
        }
        assert!(place.iter().all(|&p| p != u32::MAX));
        let moved: Vec<(u32, u32)> = pairs
            .iter()
            .map(|&(a, b)| (place[a as usize], place[b as usize]))
            .collect();
        let n = block * nodes;
        let mut dense = vec![vec![0.0; n]; n];
        let mut envelope = Envelope::zeros(block, nodes, moved.iter().copied());
        let own = (0..nodes as u32).map(|v| (v, v));
        for (a, b) in moved.into_iter().chain(own) {
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
    fn factor_and_gradients_solve_what_the_dense_matrix_says() {
        for block in [3, 4] {
            let (dense, a) = example(block, 40);
            let n = a.rows();
            let x: Vec<f64> = (0..n).map(|i| unit(3, i as i64, 0, 0) - 0.5).collect();
            let b: Vec<f64> = dense
                .iter()
                .map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum())
                .collect();
            let mut product = vec![0.0; n];
            a.multiply(&x, &mut product);
            let mut l = a.clone();
            l.factor().unwrap();
            let mut solved = b.clone();
            l.solve(&mut solved);
            // A factor of another matrix: only the diagonal is the same.
            let mut near = Envelope::zeros(block, n / block, std::iter::empty());
            (0..n).for_each(|i| near.add(i, i, a.diagonal(i)));
            near.factor().unwrap();
            let mut found = vec![0.0; n];
            assert!(conjugate_gradients(&a, &near, &b, &mut found, 1e-13, 200).is_some());
            for i in 0..n {
                assert!((product[i] - b[i]).abs() < 1e-12 * n as f64);
                assert!((solved[i] - x[i]).abs() < 1e-13, "{} {}", solved[i], x[i]);
                assert!((found[i] - x[i]).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_refused() {
        let mut a = Envelope::zeros(3, 2, [(0, 1)].into_iter());
        (0..6).for_each(|i| a.add(i, i, 1.0));
        a.add(4, 0, 2.0);
        assert_eq!(a.factor(), Err(4));
    }
}
