//! Rings from the contour inwards and from an inner circle outwards (Forests 2023, Fig. 7).

use super::super::RingPart;
use super::front::{Front, for_words};
use super::kernel::{Kernel, windows_with};
use super::passes::{NOT_ERODED, mark};
use super::schedule::KernelSchedule;
use glam::DVec2;
use greenstick_geometry::{Bitmap, Cancelled, Context};

/// A circle in a bitmap, in pixels; pixel (x, y) has its middle at (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelCircle {
    /// Its middle, px.
    pub centre: DVec2,
    /// Its radius, px.
    pub radius: f64,
}

/// The passes of an erosion and what they take off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ErodedPasses {
    /// For every pixel, row by row, a number from 1 that rises inwards; 0 outside, [`NOT_ERODED`] where no front comes.
    pub passes: Vec<u16>,
    /// What pass n takes off, at index n − 1.
    pub parts: Vec<RingPart>,
}

/// Rings from the contour inwards and from an inner `circle` outwards, a pass of each in turn until they meet. The numbers
/// of passes are first those of the front from the contour, then those of the front from the circle, the last of these
/// first, then the circle. `outward` is usually [`KernelSchedule::for_outward_front`] of the other; its kernels count pixels
/// that the inner front holds, so that its window is mirrored: an offset shifts both fronts the same way.
///
/// # Errors
/// [`Cancelled`].
pub fn erode_from_both_sides(
    section: &Bitmap,
    inward: &KernelSchedule,
    outward: &KernelSchedule,
    circle: PixelCircle,
    context: &Context,
) -> Result<ErodedPasses, Cancelled> {
    let mut fronts = TwoFronts::new(section, circle);
    let (mut step, mut idle) = (0, 0);
    let patience = inward.period().max(outward.period());
    while !fronts.inward.is_empty() && idle < patience && step < MAX_STEPS {
        context.check()?;
        step += 1;
        let n = usize::from(step);
        let any = fronts.step(
            &inward.pass(n).kernel,
            &outward.pass(n).kernel,
            Numbers {
                inward: 2 * step,
                outward: 2 * step + 1,
            },
        );
        idle = if any { 0 } else { idle + 1 };
    }
    let last = usize::from(step);
    let parts = (1..=last)
        .map(|n| inward.pass(n).part)
        .chain((1..=last).rev().map(|n| outward.pass(n).part))
        .chain([RingPart::Earlywood])
        .collect();
    Ok(ErodedPasses {
        passes: fronts.finish(step),
        parts,
    })
}

/// Most steps of both fronts that passes can number.
const MAX_STEPS: u16 = (NOT_ERODED - 3) / 2;
/// Number of the circle's pixels while the fronts run.
const CIRCLE: u16 = 1;

/// The numbers that a step writes, while the fronts run: pass n of the front from the contour is 2n, of that from the
/// circle 2n + 1.
struct Numbers {
    inward: u16,
    outward: u16,
}

/// Two fronts that run towards each other.
struct TwoFronts {
    /// What neither front has taken yet, eroded from the contour.
    inward: Front,
    /// What the circle and the front from it hold.
    taken: Bitmap,
    /// The number of every pixel.
    numbers: Vec<u16>,
}

impl TwoFronts {
    fn new(section: &Bitmap, circle: PixelCircle) -> Self {
        let taken = disc(section, circle);
        let mut inward = Front::new(section);
        inward.remove(&taken);
        let (width, height) = (section.width(), section.height());
        let mut numbers = vec![0; width * height];
        for_words(&taken, |y, word, bits| {
            mark(&mut numbers[y * width..][..width], word, bits, CIRCLE);
        });
        TwoFronts {
            inward,
            taken,
            numbers,
        }
    }

    /// Moves both fronts by a pass; whether either took a pixel.
    fn step(&mut self, inward: &Kernel, outward: &Kernel, numbers: Numbers) -> bool {
        let (width, height) = (self.taken.width(), self.taken.height());
        // The pixels of the inner front are not air: the outer front must not start from them.
        let mut whole = Front::new(&self.inward.map);
        whole.add(&self.taken);
        let mut gone = Bitmap::new(width, height);
        whole.pass(inward, |y, word, bits| gone.row_mut(y)[word] = bits);
        let grown = grow(&self.taken, outward);
        let mut any = false;
        for y in 0..height {
            let row = &mut self.numbers[y * width..][..width];
            for word in 0..self.taken.stride() {
                let here = self.inward.map.row(y)[word];
                let outer = here & gone.row(y)[word];
                let inner = here & !outer & grown.row(y)[word];
                any |= outer | inner != 0;
                mark(row, word, outer, numbers.inward);
                mark(row, word, inner, numbers.outward);
                self.inward.map.row_mut(y)[word] = here & !(outer | inner);
                self.taken.row_mut(y)[word] |= inner;
            }
        }
        self.inward.shrink();
        any
    }

    /// The numbers of passes in their final order, after `steps` of both fronts.
    fn finish(mut self, steps: u16) -> Vec<u16> {
        let (width, numbers) = (self.taken.width(), &mut self.numbers);
        self.inward.for_rest(|y, word, bits| {
            mark(&mut numbers[y * width..][..width], word, bits, NOT_ERODED);
        });
        for number in numbers.iter_mut() {
            *number = match *number {
                0 | NOT_ERODED => *number,
                CIRCLE => 2 * steps + 1,
                n if n % 2 == 0 => n / 2,
                n => 2 * steps + 1 - n / 2,
            };
        }
        self.numbers
    }
}

/// The section's pixels in a circle.
fn disc(section: &Bitmap, circle: PixelCircle) -> Bitmap {
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
