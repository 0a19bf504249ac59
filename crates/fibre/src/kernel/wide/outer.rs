//! Sums of outer products of short vectors.

use super::lanes::{Lanes, Level, WIDTH, for_each_level};

/// Rows of a block.
pub(crate) const ROWS: usize = 9;
/// A row, filled up to whole lanes.
pub(crate) type Line = [f64; 2 * WIDTH];
/// A block of rows.
pub(crate) type Block = [Line; ROWS];

/// Adds u pᵀ + v qᵀ to a block; of u and v the first [`ROWS`] numbers.
pub(crate) fn add_outer(block: &mut Block, [u, v]: &[Line; 2], [p, q]: &[Line; 2]) {
    // Safety: all arrays are as long as their types say.
    unsafe { outer_at(Level::best(), block, u, v, p, q) }
}

#[inline(always)]
unsafe fn outer_of<L: Lanes>(block: &mut Block, u: &Line, v: &Line, p: &Line, q: &Line) {
    unsafe {
        for half in [0, WIDTH] {
            let (p, q) = (L::load(p.as_ptr().add(half)), L::load(q.as_ptr().add(half)));
            for (row, (u, v)) in block.iter_mut().zip(u.iter().zip(v)) {
                let at = row.as_mut_ptr().add(half);
                let more = L::splat(*u).mul(p).add(L::splat(*v).mul(q));
                L::load(at).add(more).store(at);
            }
        }
    }
}

for_each_level! {
    /// [`outer_of`] at a level.
    outer_at = outer_of(block: &mut Block, u: &Line, v: &Line, p: &Line, q: &Line)
}
