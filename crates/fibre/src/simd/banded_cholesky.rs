//! Cholesky factors (L D Lᵀ) of symmetric banded matrices, eight side by side in the lanes of a register.
//!
//! A row of a band is the diagonal and the entries below it. A row of the factor is the inverse of the pivot and the column
//! of L, whose diagonal is 1.

use super::dispatch::for_each_level;
use super::lanes::{Lanes, WIDTH};
use super::level::SimdLevel;

/// One number of each of the eight matrices.
pub(crate) type Lane = [f64; WIDTH];
/// Entries in a row of the widest band.
pub(crate) const MAX_ROW: usize = 12;

/// Factors bands with `width` entries below the diagonal, 8 or 11, into `factor`, whose rows are one longer. A pivot that is
/// not positive removes its degree of freedom. The contents of `band` are lost.
pub(crate) fn factor_bands(
    band: &mut [[Lane; MAX_ROW]],
    width: usize,
    factor: &mut [[f32; WIDTH]],
) {
    assert!(width == 8 || width == 11);
    assert!(factor.len() == band.len() * (width + 1));
    // Safety: the type gives the length of rows, and the factor has as many as they need.
    unsafe { factor_at(SimdLevel::best(), band, width, factor) }
}

/// Solves for `x` in place; `x` has `width` more rows than the matrix.
pub(crate) fn solve_bands(factor: &[[f32; WIDTH]], width: usize, x: &mut [Lane]) {
    assert!(width == 8 || width == 11);
    assert!(x.len() >= width && factor.len() == (x.len() - width) * (width + 1));
    // Safety: the factor has a row for every row of x but the last `width`.
    unsafe { solve_at(SimdLevel::best(), factor, width, x) }
}

#[inline(always)]
unsafe fn factor_of<L: Lanes>(
    band: &mut [[Lane; MAX_ROW]],
    width: usize,
    factor: &mut [[f32; WIDTH]],
) {
    unsafe {
        if width == 8 {
            factor_width::<L, 8>(band, factor);
        } else {
            factor_width::<L, 11>(band, factor);
        }
    }
}

#[inline(always)]
unsafe fn factor_width<L: Lanes, const W: usize>(
    band: &mut [[Lane; MAX_ROW]],
    factor: &mut [[f32; WIDTH]],
) {
    unsafe {
        let (one, zero) = (L::splat(1.0), L::splat(0.0));
        let n = band.len();
        let (band, factor) = (band.as_mut_ptr(), factor.as_mut_ptr());
        for i in 0..n {
            let row = (*band.add(i)).as_ptr();
            let mut own = [zero; MAX_ROW];
            for k in 0..=W {
                own[k] = L::load((*row.add(k)).as_ptr());
            }
            let inverse = one.div(own[0]).where_positive(own[0], zero);
            let to = factor.add(i * (W + 1));
            inverse.store_single((*to).as_mut_ptr());
            for k in 0..W {
                let by = own[1 + k].mul(inverse);
                by.store_single((*to.add(1 + k)).as_mut_ptr());
                if i + 1 + k < n {
                    let below = (*band.add(i + 1 + k)).as_mut_ptr();
                    for m in k..W {
                        let at = (*below.add(m - k)).as_mut_ptr();
                        L::load(at).sub(by.mul(own[1 + m])).store(at);
                    }
                }
            }
        }
    }
}

#[inline(always)]
unsafe fn solve_of<L: Lanes>(factor: &[[f32; WIDTH]], width: usize, x: &mut [Lane]) {
    unsafe {
        if width == 8 {
            solve_width::<L, 8>(factor, x);
        } else {
            solve_width::<L, 11>(factor, x);
        }
    }
}

#[inline(always)]
unsafe fn solve_width<L: Lanes, const W: usize>(factor: &[[f32; WIDTH]], x: &mut [Lane]) {
    unsafe {
        let zero = L::splat(0.0);
        let rows = x.len() - W;
        let (factor, x) = (factor.as_ptr(), x.as_mut_ptr());
        // The rows of the current window stay in registers.
        let mut next = [zero; MAX_ROW];
        for k in 0..W {
            next[k] = L::load((*x.add(k)).as_ptr());
        }
        for i in 0..rows {
            let column = factor.add(i * (W + 1));
            let v = next[0];
            v.store((*x.add(i)).as_mut_ptr());
            next[W] = L::load((*x.add(i + W)).as_ptr());
            for k in 1..=W {
                let c = L::load_single((*column.add(k)).as_ptr());
                next[k - 1] = next[k].sub(c.mul(v));
            }
        }
        let mut last = [zero; MAX_ROW];
        for i in (0..rows).rev() {
            let column = factor.add(i * (W + 1));
            let c = |k: usize| L::load_single((*column.add(k)).as_ptr());
            let mut sums = [zero; 2];
            for k in 2..=W {
                sums[k % 2] = sums[k % 2].add(c(k).mul(last[k - 1]));
            }
            let at = (*x.add(i)).as_mut_ptr();
            // The term that depends on the row before comes last.
            let rest = L::load(at).mul(c(0)).sub(sums[0].add(sums[1]));
            let v = rest.sub(c(1).mul(last[0]));
            v.store(at);
            for k in (1..W).rev() {
                last[k] = last[k - 1];
            }
            last[0] = v;
        }
    }
}

for_each_level! {
    /// [`factor_of`] at a level.
    factor_at = factor_of(band: &mut [[Lane; MAX_ROW]], width: usize, factor: &mut [[f32; WIDTH]])
}
for_each_level! {
    /// [`solve_of`] at a level.
    solve_at = solve_of(factor: &[[f32; WIDTH]], width: usize, x: &mut [Lane])
}
