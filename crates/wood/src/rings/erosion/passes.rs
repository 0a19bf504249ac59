//! Annual rings by erosion of a section's bitmap (Forests 2023 §3.3): every pass takes off the white pixels whose
//! window holds enough black ones, all reading the bitmap as it was before the pass.
//!
//! Square kernels measure Chebyshev distance: rings are up to 41 % wider on the diagonals than along x and y.

use super::front::Front;
use super::kernel::Kernel;
use super::schedule::KernelSchedule;
use greenstick_geometry::{Bitmap, Cancelled, Context};

/// The number of a pixel that no pass takes off: the schedule's kernels cannot, or it takes more passes than fit.
pub const NOT_ERODED: u16 = u16::MAX;

/// One pass: the pixels of `map` that stay.
pub fn erode(map: &Bitmap, kernel: &Kernel) -> Bitmap {
    let mut front = Front::new(map);
    front.pass(kernel, |_, _, _| {});
    front.map
}

/// For every pixel, row by row, the number of the pass that took it off, counted from 1; 0 outside the section and
/// [`NOT_ERODED`] where none does.
///
/// ```
/// use greenstick_geometry::{Bitmap, Context};
/// use greenstick_wood::rings::{KernelSchedule, erosion_passes};
///
/// let mut section = Bitmap::new(7, 7);
/// for (x, y) in (1..6).flat_map(|y| (1..6).map(move |x| (x, y))) {
///     section.set(x, y, true);
/// }
/// let passes = erosion_passes(&section, &KernelSchedule::one_pixel_per_pass(), &Context::quiet())?;
/// assert_eq!(passes[3 * 7..4 * 7], [0, 1, 2, 3, 2, 1, 0]);
/// # Ok::<(), greenstick_geometry::Cancelled>(())
/// ```
///
/// # Errors
/// [`Cancelled`].
pub fn erosion_passes(
    section: &Bitmap,
    schedule: &KernelSchedule,
    context: &Context,
) -> Result<Vec<u16>, Cancelled> {
    let mut front = Front::new(section);
    let width = section.width();
    let mut out = vec![0; width * section.height()];
    let mut idle = 0;
    let mut number: u16 = 0;
    while !front.is_empty() && idle < schedule.period() && number + 1 < NOT_ERODED {
        context.check()?;
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
    front.for_rest(|y, word, bits| mark(&mut out[y * width..][..width], word, bits, NOT_ERODED));
    Ok(out)
}

/// Writes `number` to the pixels of the bits of word `word`.
#[inline]
pub(super) fn mark(row: &mut [u16], word: usize, mut bits: u64, number: u16) {
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

#[cfg(test)]
#[path = "passes_tests.rs"]
mod tests;
