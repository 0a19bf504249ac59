//! Annual rings by erosion of a section's picture (Forests 2023 §3.3): every pass takes off the white pixels whose
//! window holds enough black ones, all reading the picture as it was before the pass.
//!
//! Square kernels measure Chebyshev distance: rings are up to 41 % wider on the diagonals than along x and y.

use super::kernel::{Least, shift, windows_with};
use super::{Kernel, Kind, Schedule};
use glam::DVec2;
use greenstick_geometry::Bitmap;
use rayon::prelude::*;
use std::ops::Range;

/// The number of a pixel that no pass takes off: the schedule's kernels cannot, or it takes more passes than fit.
pub const NEVER: u16 = u16::MAX;

/// One pass: the pixels of `map` that stay.
pub fn erode(map: &Bitmap, kernel: &Kernel) -> Bitmap {
    let mut front = Front::of(map);
    front.pass(kernel, |_, _, _| {});
    front.map
}

/// For every pixel, row by row, the number of the pass that took it off, counted from 1; 0 outside the section and
/// [`NEVER`] where none does.
pub fn passes(section: &Bitmap, schedule: &Schedule) -> Vec<u16> {
    let mut front = Front::of(section);
    let width = section.width();
    let mut out = vec![0; width * section.height()];
    let mut idle = 0;
    let mut number: u16 = 0;
    while !front.is_empty() && idle < schedule.period() && number + 1 < NEVER {
        number += 1;
        let mut any = false;
        front.pass(
            &schedule.pass(usize::from(number)).kernel,
            |y, word, bits| {
                any = true;
                mark(&mut out[y * width..][..width], word, bits, number);
            },
        );
        idle = if any { 0 } else { idle + 1 };
    }
    front.rest(|y, word, bits| mark(&mut out[y * width..][..width], word, bits, NEVER));
    out
}

/// [`passes`] of many sections, in their order, by all threads of the current pool.
pub fn passes_of_all(sections: &[Bitmap], schedule: &Schedule) -> Vec<Vec<u16>> {
    sections.par_iter().map(|s| passes(s, schedule)).collect()
}

/// Writes `number` to the pixels of the bits of word `word`.
#[inline]
fn mark(row: &mut [u16], word: usize, mut bits: u64, number: u16) {
    let row = &mut row[word * 64..];
    while bits != 0 {
        // A run of ones at a time: passes take off long runs along the rows.
        let start = bits.trailing_zeros();
        let run = (bits >> start).trailing_ones();
        row[start as usize..(start + run) as usize].fill(number);
        if start + run == 64 {
            return;
        }
        bits &= u64::MAX << (start + run);
    }
}

/// A circle in a picture, px; pixel (x, y) has its middle at (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Its middle, px.
    pub centre: DVec2,
    /// Its radius, px.
    pub radius: f64,
}

/// What two fronts that run towards each other took off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TwoSided {
    /// For every pixel, row by row, a number from 1 that rises inwards: first the passes of the front from the contour,
    /// then those of the front from the circle, the last of these first, then the circle. 0 outside, [`NEVER`] where
    /// neither front comes.
    pub passes: Vec<u16>,
    /// What the pass of number n is at index n − 1.
    pub kinds: Vec<Kind>,
}

/// Rings from the contour inwards and from an inner `circle` outwards (the paper's Fig. 7), a pass of each in turn
/// until they meet. `outward` is usually [`Schedule::outwards`] of the other; its kernels count pixels that the inner
/// front holds, so that its window is mirrored: an offset moves both fronts the same way.
pub fn two_sided(
    section: &Bitmap,
    inward: &Schedule,
    outward: &Schedule,
    circle: Circle,
) -> TwoSided {
    let (width, height) = (section.width(), section.height());
    let mut taken = disc(section, circle);
    let mut front = Front::of(section);
    front.remove(&taken);
    let mut out = vec![0; width * height];
    let write = |out: &mut Vec<u16>, y: usize, word, bits, number| {
        mark(&mut out[y * width..][..width], word, bits, number);
    };
    // The circle is 1 for now; pass n from outside is 2n, from inside 2n + 1.
    for_words(&taken, |y, word, bits| write(&mut out, y, word, bits, 1));
    let most = (NEVER - 3) / 2;
    let (mut step, mut idle) = (0, 0);
    while !front.is_empty() && idle < inward.period().max(outward.period()) && step < most {
        step += 1;
        let mut any = false;
        let n = usize::from(step);
        // The inner front's pixels are no air: the outer front must not start from them.
        let mut whole = Front::of(&front.map);
        whole.add(&taken);
        let mut gone = Bitmap::new(width, height);
        whole.pass(&inward.pass(n).kernel, |y, word, bits| {
            gone.row_mut(y)[word] = bits;
        });
        let grown = grow(&taken, &outward.pass(n).kernel);
        for y in 0..height {
            for word in 0..section.stride() {
                let here = front.map.row(y)[word];
                let outer = here & gone.row(y)[word];
                let inner = here & !outer & grown.row(y)[word];
                any |= outer | inner != 0;
                write(&mut out, y, word, outer, 2 * step);
                write(&mut out, y, word, inner, 2 * step + 1);
                front.map.row_mut(y)[word] = here & !(outer | inner);
                taken.row_mut(y)[word] |= inner;
            }
        }
        front.shrink();
        idle = if any { 0 } else { idle + 1 };
    }
    front.rest(|y, word, bits| write(&mut out, y, word, bits, NEVER));
    for number in &mut out {
        *number = match *number {
            0 | NEVER => *number,
            1 => 2 * step + 1,
            n if n % 2 == 0 => n / 2,
            n => 2 * step + 1 - n / 2,
        };
    }
    let last = usize::from(step);
    let kinds = (1..=last)
        .map(|n| inward.pass(n).kind)
        .chain((1..=last).rev().map(|n| outward.pass(n).kind))
        .chain([Kind::Earlywood])
        .collect();
    TwoSided { passes: out, kinds }
}

/// The section's pixels in a circle.
fn disc(section: &Bitmap, circle: Circle) -> Bitmap {
    let mut disc = Bitmap::new(section.width(), section.height());
    for y in 0..section.height() {
        for x in 0..section.width() {
            let p = DVec2::new(x as f64, y as f64);
            if section.get(x, y) && p.distance(circle.centre) <= circle.radius {
                disc.set(x, y, true);
            }
        }
    }
    disc
}

/// All pixels whose mirrored window holds at least `threshold` pixels of `map`.
fn grow(map: &Bitmap, kernel: &Kernel) -> Bitmap {
    let mirrored = Kernel {
        offset: (
            kernel.offset.0.saturating_neg(),
            kernel.offset.1.saturating_neg(),
        ),
        ..*kernel
    };
    let (stride, height) = (map.stride(), map.height());
    let words = windows_with(
        map,
        &mirrored,
        u64::from(kernel.threshold),
        0..height,
        0..height,
    );
    let mut out = Bitmap::new(map.width(), height);
    let past = match map.width() % 64 {
        0 => u64::MAX,
        bits => (1 << bits) - 1,
    };
    for (y, words) in words.chunks_exact(stride.max(1)).enumerate() {
        out.row_mut(y).copy_from_slice(words);
        if let Some(last) = out.row_mut(y).last_mut() {
            *last &= past;
        }
    }
    out
}

fn for_words(map: &Bitmap, mut tell: impl FnMut(usize, usize, u64)) {
    for y in 0..map.height() {
        for (word, &bits) in map.row(y).iter().enumerate() {
            if bits != 0 {
                tell(y, word, bits);
            }
        }
    }
}

/// A picture that is eroded in place, and the rows and words in which it is not all black.
struct Front {
    map: Bitmap,
    rows: Range<usize>,
    words: Range<usize>,
}

impl Front {
    fn of(map: &Bitmap) -> Self {
        let mut front = Front {
            rows: 0..map.height(),
            words: 0..map.stride(),
            map: map.clone(),
        };
        front.shrink();
        front
    }

    fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Finds the rows and words that hold pixels, among those that did.
    fn shrink(&mut self) {
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

    fn remove(&mut self, other: &Bitmap) {
        for_words(other, |y, word, bits| self.map.row_mut(y)[word] &= !bits);
        self.shrink();
    }

    fn add(&mut self, other: &Bitmap) {
        for_words(other, |y, word, bits| self.map.row_mut(y)[word] |= bits);
        *self = Front::of(&self.map);
    }

    /// What is left, in words (row, word, bits).
    fn rest(&self, mut tell: impl FnMut(usize, usize, u64)) {
        for y in self.rows.clone() {
            for word in self.words.clone() {
                tell(y, word, self.map.row(y)[word]);
            }
        }
    }

    /// Takes off one pass and tells which pixels went, in words (row, word, bits).
    fn pass(&mut self, kernel: &Kernel, tell: impl FnMut(usize, usize, u64)) {
        if self.is_empty() {
            return;
        }
        let all = u64::from(kernel.width) * u64::from(kernel.height);
        match kernel.whites() {
            Least::Always => {}
            Least::Never => {
                let rows = self.rows.len();
                self.keep(&vec![0; rows * self.map.stride()], tell);
            }
            Least::Of(least) if least < all => {
                let kept = windows_with(
                    &self.map,
                    kernel,
                    least,
                    self.rows.clone(),
                    self.rows.clone(),
                );
                self.keep(&kept, tell);
            }
            Least::Of(_) if *kernel == Kernel::square(3) => self.thin(tell),
            Least::Of(_) => {
                let kept = self.full_windows(kernel);
                self.keep(&kept, tell);
            }
        }
        self.shrink();
    }

    /// Keeps of the rows that hold pixels what `kept`, whole rows of words, holds too.
    fn keep(&mut self, kept: &[u64], mut tell: impl FnMut(usize, usize, u64)) {
        for (y, kept) in self
            .rows
            .clone()
            .zip(kept.chunks_exact(self.map.stride().max(1)))
        {
            for word in self.words.clone() {
                let here = &mut self.map.row_mut(y)[word];
                let gone = *here & !kept[word];
                if gone != 0 {
                    *here &= kept[word];
                    tell(y, word, gone);
                }
            }
        }
    }

    /// One pass of 3 × 3 pixels of which all must be white. A row's own three across are made when the row below is
    /// looked at, so that rows can be overwritten as they are done.
    fn thin(&mut self, mut tell: impl FnMut(usize, usize, u64)) {
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
                let kept = above[i] & here[i] & below[i];
                let gone = *w & !kept;
                if gone != 0 {
                    *w = kept;
                    tell(y, self.words.start + i, gone);
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
        // Row i of `run` now holds the windows that begin there; those that begin elsewhere leave the picture's rows.
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

#[cfg(test)]
mod tests;
