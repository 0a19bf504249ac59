//! A radius over (angle, length) on a grid, with its holes filled smoothly.

use super::points::Point;

/// Values at the middles of cells, angle by angle, ring by ring.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub around: usize,
    pub along: usize,
    pub length: f64,
    pub values: Vec<f64>,
    pub known: Vec<bool>,
}

impl Field {
    pub fn new(around: usize, along: usize, length: f64) -> Self {
        Field {
            around,
            along,
            length,
            values: vec![0.0; around * along],
            known: vec![false; around * along],
        }
    }

    /// The cell of an address.
    pub fn cell(s: f64, turn: f64, around: usize, along: usize, length: f64) -> usize {
        let i = ((s / length * along as f64).max(0.0) as usize).min(along - 1);
        let j = ((turn * around as f64) as usize).min(around - 1);
        i * around + j
    }

    /// The points (their places in the list) in each cell.
    pub fn cells(points: &[Point], around: usize, along: usize, length: f64) -> Vec<Vec<u32>> {
        let mut cells = vec![Vec::new(); around * along];
        for (p, i) in points.iter().zip(0..) {
            cells[Self::cell(p.s, p.turn, around, along, length)].push(i);
        }
        cells
    }

    pub fn set(&mut self, cell: usize, value: f64) {
        (self.values[cell], self.known[cell]) = (value, true);
    }

    /// Length of the middles of ring `i`.
    pub fn length_of(&self, i: usize) -> f64 {
        (i as f64 + 0.5) / self.along as f64 * self.length
    }

    /// Replaces each known value by the median of the known ones about it: single cells full of strangers vanish.
    pub fn calm(&mut self) {
        let old = self.values.clone();
        let mut near = Vec::with_capacity(9);
        for i in 0..self.along {
            for j in 0..self.around {
                if !self.known[i * self.around + j] {
                    continue;
                }
                near.clear();
                for a in i.saturating_sub(1)..(i + 2).min(self.along) {
                    for b in [self.around - 1, 0, 1] {
                        let k = a * self.around + (j + b) % self.around;
                        if self.known[k] {
                            near.push(old[k]);
                        }
                    }
                }
                near.sort_unstable_by(f64::total_cmp);
                self.values[i * self.around + j] = near[near.len() / 2];
            }
        }
    }

    /// Fills the holes: what is known departs from `form` (a radius by length), and the departure is carried into holes
    /// by averages over ever larger neighbourhoods (Gortler et al. 1996), then made smooth (a membrane).
    pub fn complete(&mut self, form: impl Fn(f64) -> f64) {
        const RELAXED: usize = 60;
        let base: Vec<f64> = (0..self.along).map(|i| form(self.length_of(i))).collect();
        for k in 0..self.values.len() {
            self.values[k] = if self.known[k] {
                self.values[k] - base[k / self.around]
            } else {
                0.0
            };
        }
        let weights: Vec<f64> = self.known.iter().map(|k| f64::from(u8::from(*k))).collect();
        let filled = pull_push(&self.values, &weights, self.around, self.along);
        let holes: Vec<usize> = (0..self.values.len()).filter(|&k| !self.known[k]).collect();
        holes.iter().for_each(|&k| self.values[k] = filled[k]);
        for _ in 0..RELAXED {
            for &k in &holes {
                let (i, j) = (k / self.around, k % self.around);
                let row = |i: usize| self.values[i * self.around + j];
                let up = row(if i + 1 < self.along { i + 1 } else { i });
                let down = row(i.saturating_sub(1));
                let ring = &self.values[i * self.around..][..self.around];
                let sides = ring[(j + 1) % self.around] + ring[(j + self.around - 1) % self.around];
                self.values[k] = 0.25 * (up + down + sides);
            }
        }
        for k in 0..self.values.len() {
            let base = base[k / self.around];
            self.values[k] = (self.values[k] + base).max(0.2 * base);
        }
    }

    /// The value at an address, linear between the cells' middles.
    pub fn at(&self, s: f64, turn: f64) -> f64 {
        let split = |x: f64| (x.floor(), x - x.floor());
        let y = (s / self.length * self.along as f64 - 0.5).clamp(0.0, (self.along - 1) as f64);
        let ((i, v), (j, u)) = (split(y), split(turn * self.around as f64 - 0.5));
        let i = i as usize;
        let next = (i + 1).min(self.along - 1);
        let wrap = |j: f64| (j as i64).rem_euclid(self.around as i64) as usize;
        let get = |i: usize, j: f64| self.values[i * self.around + wrap(j)];
        let low = get(i, j) + (get(i, j + 1.0) - get(i, j)) * u;
        let high = get(next, j) + (get(next, j + 1.0) - get(next, j)) * u;
        low + (high - low) * v
    }
}

/// Weighted values of a grid that closes around, with those of weight 0 filled from averages of two by two cells.
fn pull_push(values: &[f64], weights: &[f64], around: usize, along: usize) -> Vec<f64> {
    if around <= 1 && along <= 1 {
        return values.to_vec();
    }
    let (half_around, half_along) = (around.div_ceil(2), along.div_ceil(2));
    let count = half_around * half_along;
    let (mut sums, mut totals) = (vec![0.0; count], vec![0.0; count]);
    let coarse = |k: usize| (k / around / 2) * half_around + (k % around) / 2;
    for k in 0..values.len() {
        sums[coarse(k)] += values[k] * weights[k];
        totals[coarse(k)] += weights[k];
    }
    for (sum, total) in sums.iter_mut().zip(&mut totals) {
        if *total > 0.0 {
            *sum /= *total;
            *total = total.min(1.0);
        }
    }
    let wide = pull_push(&sums, &totals, half_around, half_along);
    (0..values.len())
        .map(|k| values[k] * weights[k] + wide[coarse(k)] * (1.0 - weights[k]))
        .collect()
}
