//! The front of an erosion: a bitmap that shrinks pass by pass, 64 pixels at a time.

use super::kernel::{Kernel, Least, shift, windows_with};
use greenstick_geometry::Bitmap;
use std::ops::Range;

/// Visits the words of a bitmap that are not 0 (row, word, bits).
pub(super) fn for_words(map: &Bitmap, mut visit: impl FnMut(usize, usize, u64)) {
    for y in 0..map.height() {
        for (word, &bits) in map.row(y).iter().enumerate() {
            if bits != 0 {
                visit(y, word, bits);
            }
        }
    }
}

/// A bitmap that is eroded in place, and the rows and words in which it is not all black.
pub(super) struct Front {
    pub map: Bitmap,
    rows: Range<usize>,
    words: Range<usize>,
}

impl Front {
    pub fn new(map: &Bitmap) -> Self {
        let mut front = Front {
            rows: 0..map.height(),
            words: 0..map.stride(),
            map: map.clone(),
        };
        front.shrink();
        front
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Finds the rows and words that hold pixels, among those that did.
    pub fn shrink(&mut self) {
        let (mut rows, mut words) = (0..0, 0..0);
        for y in self.rows.clone() {
            let row = &self.map.row(y)[self.words.clone()];
            let Some(first) = row.iter().position(|&w| w != 0) else {
                continue;
            };
            let last = row.iter().rposition(|&w| w != 0).unwrap_or(first);
            let (first, end) = (self.words.start + first, self.words.start + last + 1);
            if rows.is_empty() {
                (rows, words) = (y..y + 1, first..end);
            } else {
                rows.end = y + 1;
                words = words.start.min(first)..words.end.max(end);
            }
        }
        (self.rows, self.words) = (rows, words);
    }

    pub fn remove(&mut self, other: &Bitmap) {
        for_words(other, |y, word, bits| self.map.row_mut(y)[word] &= !bits);
        self.shrink();
    }

    pub fn add(&mut self, other: &Bitmap) {
        for_words(other, |y, word, bits| self.map.row_mut(y)[word] |= bits);
        *self = Front::new(&self.map);
    }

    /// Visits what is left, in words (row, word, bits).
    pub fn for_rest(&self, mut visit: impl FnMut(usize, usize, u64)) {
        for y in self.rows.clone() {
            for word in self.words.clone() {
                visit(y, word, self.map.row(y)[word]);
            }
        }
    }

    /// Erodes by one pass and visits the pixels that went, in words (row, word, bits).
    pub fn pass(&mut self, kernel: &Kernel, visit: impl FnMut(usize, usize, u64)) {
        if self.is_empty() {
            return;
        }
        let all = u64::from(kernel.width) * u64::from(kernel.height);
        match kernel.required_whites() {
            Least::Always => {}
            Least::Never => {
                let rows = self.rows.len();
                self.retain(&vec![0; rows * self.map.stride()], visit);
            }
            Least::Count(least) if least < all => {
                let remaining = windows_with(
                    &self.map,
                    kernel,
                    least,
                    self.rows.clone(),
                    self.rows.clone(),
                );
                self.retain(&remaining, visit);
            }
            Least::Count(_) if *kernel == Kernel::square(3) => self.thin(visit),
            Least::Count(_) => {
                let remaining = self.full_windows(kernel);
                self.retain(&remaining, visit);
            }
        }
        self.shrink();
    }

    /// Retains of the rows that hold pixels what `mask`, whole rows of words, holds too.
    fn retain(&mut self, mask: &[u64], mut visit: impl FnMut(usize, usize, u64)) {
        for (y, mask) in self
            .rows
            .clone()
            .zip(mask.chunks_exact(self.map.stride().max(1)))
        {
            for word in self.words.clone() {
                let here = &mut self.map.row_mut(y)[word];
                let gone = *here & !mask[word];
                if gone != 0 {
                    *here &= mask[word];
                    visit(y, word, gone);
                }
            }
        }
    }

    /// One pass of 3 × 3 pixels of which all must be white. The three across of a row are computed when the row above is
    /// done, so that rows can be overwritten in place.
    fn thin(&mut self, mut visit: impl FnMut(usize, usize, u64)) {
        let (words, count) = (self.words.clone(), self.words.len());
        let mut padded = vec![0; count + 2];
        let [mut above, mut here, mut below] = [const { Vec::new() }; 3].map(|mut v: Vec<u64>| {
            v.resize(count, 0);
            v
        });
        let mut across = |map: &Bitmap, y: usize, out: &mut [u64]| {
            padded[1..=count].copy_from_slice(&map.row(y)[words.clone()]);
            let (left, right) = (&padded[..count], &padded[2..]);
            for (((out, &w), &l), &r) in out.iter_mut().zip(&padded[1..=count]).zip(left).zip(right)
            {
                *out = w & (w << 1 | l >> 63) & (w >> 1 | r << 63);
            }
        };
        across(&self.map, self.rows.start, &mut here);
        for y in self.rows.clone() {
            if y + 1 < self.rows.end {
                across(&self.map, y + 1, &mut below);
            } else {
                below.fill(0);
            }
            let row = &mut self.map.row_mut(y)[self.words.clone()];
            for (i, w) in row.iter_mut().enumerate() {
                let remaining = above[i] & here[i] & below[i];
                let gone = *w & !remaining;
                if gone != 0 {
                    *w = remaining;
                    visit(y, self.words.start + i, gone);
                }
            }
            std::mem::swap(&mut above, &mut here);
            std::mem::swap(&mut here, &mut below);
        }
    }

    /// The pixels whose whole window is white, for the rows that hold pixels: windows of twice the size by AND of two,
    /// across and then down.
    fn full_windows(&self, kernel: &Kernel) -> Vec<u64> {
        let stride = self.map.stride();
        let rows = self.rows.len();
        let mut out = vec![0; stride * rows];
        if kernel.width as usize > self.map.width() || kernel.height as usize > rows {
            return out;
        }
        let mut run = vec![0; stride * rows];
        let mut moved = vec![0; stride];
        for (y, run) in self.rows.clone().zip(run.chunks_exact_mut(stride)) {
            run.copy_from_slice(self.map.row(y));
            for step in doublings(kernel.width as usize) {
                shift(run, step as i64, &mut moved);
                for (a, b) in run.iter_mut().zip(&moved) {
                    *a &= b;
                }
            }
            shift(run, kernel.left(), &mut moved);
            run.copy_from_slice(&moved);
        }
        let mut tall = 1;
        for step in doublings(kernel.height as usize) {
            tall += step;
            for i in 0..(rows + 1 - tall) * stride {
                run[i] &= run[i + step * stride];
            }
        }
        // Row i of `run` now holds the windows that begin there; the others reach beyond the bitmap's rows.
        for (i, out) in out.chunks_exact_mut(stride).enumerate() {
            let from = usize::try_from(i as i64 + kernel.top());
            if let Some(from) = from.ok().filter(|&from| from + tall <= rows) {
                out.copy_from_slice(&run[from * stride..][..stride]);
            }
        }
        out
    }
}

/// Steps by which windows of one pixel grow to `size`, none larger than the window so far.
fn doublings(size: usize) -> impl Iterator<Item = usize> {
    let mut now = 1;
    std::iter::from_fn(move || {
        let step = now.min(size - now);
        now += step;
        (step > 0).then_some(step)
    })
}
