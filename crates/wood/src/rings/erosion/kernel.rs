//! The kernel of an erosion and its window, counted 64 pixels at a time (Forests 2023 §3.3).
//!
//! A window's set pixels are counted by bit-sliced adders: bit p of 64 counters is one word, and adding a pixel to each
//! is a ripple of AND and XOR over the words of rising p.

use greenstick_geometry::Bitmap;
use std::ops::Range;

/// The kernel of an erosion: a white pixel is taken off where at least `threshold` (the paper's M_K) pixels of its window are
/// black. What lies beyond the bitmap is black.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kernel {
    /// Pixels along x, K_x.
    pub width: u32,
    /// Pixels along y, K_y.
    pub height: u32,
    /// Where the window's middle lies relative to the pixel, (x, y). Of an even number of pixels it is the lower of the two
    /// in the middle.
    pub offset: (i32, i32),
    /// Black pixels from which on the pixel goes. 0 takes every pixel, more than `width` × `height` none.
    pub threshold: u32,
}

impl Kernel {
    /// A square of `size` pixels about the pixel, where one black pixel is enough.
    pub fn square(size: u32) -> Self {
        Kernel {
            width: size,
            height: size,
            offset: (0, 0),
            threshold: 1,
        }
    }

    /// The kernel that does in a bitmap `factor` times as large what this one does.
    pub(super) fn scaled(self, factor: u32) -> Self {
        let reach = |k: u32| k.saturating_sub(1).saturating_mul(factor).saturating_add(1);
        let scaled = |o: i32| o.saturating_mul(i32::try_from(factor).unwrap_or(i32::MAX));
        let (width, height) = (reach(self.width), reach(self.height));
        // One black pixel stays one; more are a part of the kernel's.
        let pixels = u64::from(self.width) * u64::from(self.height);
        let more = u64::from(self.threshold.saturating_sub(1));
        let share = more * u64::from(width) * u64::from(height) / pixels.max(1);
        Kernel {
            width,
            height,
            offset: (scaled(self.offset.0), scaled(self.offset.1)),
            threshold: self.threshold.min(1) + u32::try_from(share).unwrap_or(u32::MAX - 1),
        }
    }

    /// White pixels the window must hold for its pixel to stay.
    pub(super) fn required_whites(&self) -> Least {
        let all = u64::from(self.width) * u64::from(self.height);
        match u64::from(self.threshold) {
            0 => Least::Never,
            black if black > all => Least::Always,
            black => Least::Count(all - black + 1),
        }
    }

    /// The first column of the window relative to its pixel.
    pub(super) fn left(&self) -> i64 {
        i64::from(self.offset.0) - (i64::from(self.width) - 1) / 2
    }

    /// The first row of the window relative to its pixel.
    pub(super) fn top(&self) -> i64 {
        i64::from(self.offset.1) - (i64::from(self.height) - 1) / 2
    }
}

/// From which count on a pixel stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Least {
    /// Whatever the count is.
    Always,
    /// At no count.
    Never,
    /// From this count on (1 or more).
    Count(u64),
}

/// Shifts a row: bit x of `out` is bit x + `by` of `row`; bits beyond the row are 0.
pub(super) fn shift(row: &[u64], by: i64, out: &mut [u64]) {
    let words = by.div_euclid(64);
    let bits = by.rem_euclid(64) as u32;
    let at = |i: i64| {
        usize::try_from(i)
            .ok()
            .and_then(|i| row.get(i))
            .copied()
            .unwrap_or(0)
    };
    for (i, out) in out.iter_mut().enumerate() {
        let j = i as i64 + words;
        *out = if bits == 0 {
            at(j)
        } else {
            at(j) >> bits | at(j + 1) << (64 - bits)
        };
    }
}

/// Counters of 64 pixels a word: plane p of word i at `p * stride + i`.
struct Counters {
    stride: usize,
    planes: Vec<u64>,
}

impl Counters {
    fn new(stride: usize, most: u64) -> Self {
        let bits = (64 - most.leading_zeros()).max(1) as usize;
        Counters {
            stride,
            planes: vec![0; stride * bits],
        }
    }

    /// Adds 1 where a bit of `row` is set.
    fn count(&mut self, row: &[u64]) {
        for (i, &bit) in row.iter().enumerate() {
            let mut carry = bit;
            for plane in self.planes.chunks_exact_mut(self.stride) {
                if carry == 0 {
                    break;
                }
                (plane[i], carry) = (plane[i] ^ carry, plane[i] & carry);
            }
        }
    }

    /// Adds or subtracts the counts of another set of counters with no more planes.
    fn combine(&mut self, other: &[u64], add: bool) {
        for i in 0..self.stride {
            let mut carry = 0;
            for (p, plane) in self.planes.chunks_exact_mut(self.stride).enumerate() {
                let (a, b) = (
                    plane[i],
                    other.get(p * self.stride + i).copied().unwrap_or(0),
                );
                plane[i] = a ^ b ^ carry;
                let from = if add { a } else { !a };
                carry = from & b | carry & (from | b);
            }
        }
    }

    /// Sets the bits where the count is at least `least`, which must be below 2 to the number of planes: the carry out of
    /// adding what is missing to that power.
    fn at_least(&self, least: u64, out: &mut [u64]) {
        let missing = least.wrapping_neg();
        for (i, out) in out.iter_mut().enumerate() {
            let mut carry = 0;
            for (p, plane) in self.planes.chunks_exact(self.stride).enumerate() {
                carry = if missing >> p & 1 == 1 {
                    plane[i] | carry
                } else {
                    plane[i] & carry
                };
            }
            *out = carry;
        }
    }
}

/// The pixels in `rows` whose window holds at least `least` set pixels, as words of whole rows; nothing is set beyond
/// the bitmap. Only the rows `set` can have set pixels.
pub(super) fn windows_with(
    map: &Bitmap,
    kernel: &Kernel,
    least: u64,
    set: Range<usize>,
    rows: Range<usize>,
) -> Vec<u64> {
    let stride = map.stride();
    let mut out = vec![0; stride * rows.len()];
    let reach = |first: i64, size: u32, limit: usize| {
        let limit = limit as i64;
        let low = first.max(-limit);
        (low, (first + i64::from(size)).min(limit).max(low))
    };
    let (left, right) = reach(kernel.left(), kernel.width, map.width());
    let (top, bottom) = reach(kernel.top(), kernel.height, map.height());
    let across = (right - left) as u64;
    let most = across * (bottom - top) as u64;
    if least > most {
        return out;
    }
    let clip = |y: i64| y.clamp(set.start as i64, set.end as i64) as usize;
    // Counts along every row once, then a running sum of them down the rows.
    let mut shifted = vec![0; stride];
    let along: Vec<Vec<u64>> = set
        .clone()
        .map(|y| {
            let mut counters = Counters::new(stride, across);
            for by in left..right {
                shift(map.row(y), by, &mut shifted);
                counters.count(&shifted);
            }
            counters.planes
        })
        .collect();
    let mut sum = Counters::new(stride, most);
    let (mut first, mut end) = (clip(rows.start as i64 + top), clip(rows.start as i64 + top));
    for (y, out) in rows.zip(out.chunks_exact_mut(stride)) {
        let wanted = (clip(y as i64 + top), clip(y as i64 + bottom));
        while end < wanted.1 {
            sum.combine(&along[end - set.start], true);
            end += 1;
        }
        while first < wanted.0 {
            sum.combine(&along[first - set.start], false);
            first += 1;
        }
        sum.at_least(least, out);
    }
    out
}
