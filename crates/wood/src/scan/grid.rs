//! Values over the unrolled bark, (angle, length), on a grid with its holes filled smoothly.

use greenstick_geometry::{Cancelled, Context};

/// The divisions of a grid over (angle, length).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GridSize {
    pub around: usize,
    pub along: usize,
    /// Length of the stem, m.
    pub length: f64,
}

impl GridSize {
    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.around * self.along
    }

    /// The cell of length `s` (m) and angle `turn` (0 to 1).
    pub fn cell(&self, s: f64, turn: f64) -> usize {
        let i = ((s / self.length * self.along as f64).max(0.0) as usize).min(self.along - 1);
        let j = ((turn * self.around as f64) as usize).min(self.around - 1);
        i * self.around + j
    }

    /// Length of the middles of row `i`, m.
    pub fn length_of(&self, i: usize) -> f64 {
        (i as f64 + 0.5) / self.along as f64 * self.length
    }
}

/// Values at the middles of cells, angle by angle, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnrolledGrid {
    pub size: GridSize,
    pub values: Vec<f64>,
    pub known: Vec<bool>,
}

/// Rounds of smoothing of what fills a hole.
const MEMBRANE_ROUNDS: usize = 60;
/// Least radius of what fills a hole, relative to the base radius there.
const MIN_FILLED_RADIUS: f64 = 0.2;

impl UnrolledGrid {
    /// A grid without known values.
    pub fn new(size: GridSize) -> Self {
        UnrolledGrid {
            size,
            values: vec![0.0; size.cells()],
            known: vec![false; size.cells()],
        }
    }

    pub fn set(&mut self, cell: usize, value: f64) {
        (self.values[cell], self.known[cell]) = (value, true);
    }

    /// Replaces each known value by the median of the known ones about it: single cells full of foreign points vanish.
    pub fn median_filter(&mut self) {
        let (around, along) = (self.size.around, self.size.along);
        let old = self.values.clone();
        let mut near = Vec::with_capacity(9);
        for i in 0..along {
            for j in 0..around {
                if !self.known[i * around + j] {
                    continue;
                }
                near.clear();
                for a in i.saturating_sub(1)..(i + 2).min(along) {
                    for b in [around - 1, 0, 1] {
                        let k = a * around + (j + b) % around;
                        if self.known[k] {
                            near.push(old[k]);
                        }
                    }
                }
                near.sort_unstable_by(f64::total_cmp);
                self.values[i * around + j] = near[near.len() / 2];
            }
        }
    }

    /// Fills the holes. What is known departs from `base` (a radius by length, m); the departure is extended into holes by
    /// averages over ever larger neighbourhoods (Gortler et al. 1996, The Lumigraph, §3.4), then smoothed as a membrane.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn complete(
        &mut self,
        base: impl Fn(f64) -> f64,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let (around, along) = (self.size.around, self.size.along);
        let base: Vec<f64> = (0..along).map(|i| base(self.size.length_of(i))).collect();
        for k in 0..self.values.len() {
            self.values[k] = if self.known[k] {
                self.values[k] - base[k / around]
            } else {
                0.0
            };
        }
        let weights: Vec<f64> = self.known.iter().map(|k| f64::from(u8::from(*k))).collect();
        let filled = pull_push(&self.values, &weights, around, along);
        let holes: Vec<usize> = (0..self.values.len()).filter(|&k| !self.known[k]).collect();
        holes.iter().for_each(|&k| self.values[k] = filled[k]);
        for _ in 0..MEMBRANE_ROUNDS {
            context.check()?;
            for &k in &holes {
                let (i, j) = (k / around, k % around);
                let in_row = |i: usize| self.values[i * around + j];
                let up = in_row(if i + 1 < along { i + 1 } else { i });
                let down = in_row(i.saturating_sub(1));
                let row = &self.values[i * around..][..around];
                let sides = row[(j + 1) % around] + row[(j + around - 1) % around];
                self.values[k] = 0.25 * (up + down + sides);
            }
        }
        for k in 0..self.values.len() {
            let base = base[k / around];
            self.values[k] = (self.values[k] + base).max(MIN_FILLED_RADIUS * base);
        }
        Ok(())
    }

    /// The value at an address, linear between the cells' middles.
    pub fn at(&self, s: f64, turn: f64) -> f64 {
        let split = |x: f64| (x.floor(), x - x.floor());
        let GridSize {
            around,
            along,
            length,
        } = self.size;
        let y = (s / length * along as f64 - 0.5).clamp(0.0, (along - 1) as f64);
        let ((i, v), (j, u)) = (split(y), split(turn * around as f64 - 0.5));
        let i = i as usize;
        let next = (i + 1).min(along - 1);
        let wrap = |j: f64| (j as i64).rem_euclid(around as i64) as usize;
        let get = |i: usize, j: f64| self.values[i * around + wrap(j)];
        let low = get(i, j) + (get(i, j + 1.0) - get(i, j)) * u;
        let high = get(next, j) + (get(next, j + 1.0) - get(next, j)) * u;
        low + (high - low) * v
    }
}

/// Weighted values of a grid that closes around, those of weight 0 filled from averages of two by two cells.
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
