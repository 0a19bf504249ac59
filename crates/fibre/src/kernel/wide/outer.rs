//! Blocks of a matrix to which rows are added with weights.

use super::lanes::{Lanes, Level, WIDTH, for_each_level};

/// Rows of a block.
pub(crate) const ROWS: usize = 9;
/// A row, filled up to whole lanes.
pub(crate) type Line = [f64; 2 * WIDTH];
/// A block of rows.
pub(crate) type Block = [Line; ROWS];

/// Adds to rows 3 s + a of a block the row a of three, times the weight s of three.
#[inline(always)]
pub(crate) fn add_rows(block: &mut Block, weight: &[f64; 3], rows: &[Line; 3]) {
    // Safety: all arrays are as long as their types say.
    unsafe { rows_at(Level::best(), block, weight, rows) }
}

#[inline(always)]
unsafe fn rows_of<L: Lanes>(block: &mut Block, weight: &[f64; 3], rows: &[Line; 3]) {
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
    rows_at = rows_of(block: &mut Block, weight: &[f64; 3], rows: &[Line; 3])
}
