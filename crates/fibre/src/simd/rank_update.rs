//! Weighted sums of rows in blocks of a matrix.

use super::dispatch::for_each_level;
use super::lanes::{Lanes, WIDTH};
use super::level::SimdLevel;

/// Rows of a block.
pub(crate) const ROWS: usize = 9;
/// A row, padded to whole lanes.
pub(crate) type BlockRow = [f64; 2 * WIDTH];
/// A block of rows.
pub(crate) type Block = [BlockRow; ROWS];

/// Adds row `a` of `rows`, times weight `s`, to row 3 s + a of a block, for all nine pairs of them.
#[inline(always)]
pub(crate) fn add_rows(block: &mut Block, weight: &[f64; 3], rows: &[BlockRow; 3]) {
    // Safety: the types give the lengths of all arrays.
    unsafe { rows_at(SimdLevel::best(), block, weight, rows) }
}

#[inline(always)]
unsafe fn rows_of<L: Lanes>(block: &mut Block, weight: &[f64; 3], rows: &[BlockRow; 3]) {
    unsafe {
        let weight = [
            L::splat(weight[0]),
            L::splat(weight[1]),
            L::splat(weight[2]),
        ];
        for half in [0, WIDTH] {
            let rows = [
                L::load(rows[0].as_ptr().add(half)),
                L::load(rows[1].as_ptr().add(half)),
                L::load(rows[2].as_ptr().add(half)),
            ];
            for s in 0..3 {
                for a in 0..3 {
                    let at = block[3 * s + a].as_mut_ptr().add(half);
                    L::load(at).add(weight[s].mul(rows[a])).store(at);
                }
            }
        }
    }
}

for_each_level! {
    /// [`rows_of`] at a level.
    rows_at = rows_of(block: &mut Block, weight: &[f64; 3], rows: &[BlockRow; 3])
}
