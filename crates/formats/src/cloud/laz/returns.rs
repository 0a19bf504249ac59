//! The contexts in which coordinates are coded: the number of a return of a pulse, and the number of returns.
//!
//! Returns are counted from 1, but some files count from 0, have only one of the two numbers, or have them swapped, so
//! every pair of numbers has its context.

/// The number of a return, and the number of returns of its pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Returns {
    pub number: u8,
    pub count: u8,
}

/// Contexts of point formats 0 to 5 by the count of returns and the number of the return, both less than 8.
const CONTEXTS_OF_8: [[u8; 8]; 8] = [
    [15, 14, 13, 12, 11, 10, 9, 8],
    [14, 0, 1, 3, 6, 10, 10, 9],
    [13, 1, 2, 4, 7, 11, 11, 10],
    [12, 3, 4, 5, 8, 12, 12, 11],
    [11, 6, 7, 8, 9, 13, 13, 12],
    [10, 10, 11, 12, 13, 14, 14, 13],
    [9, 10, 11, 12, 13, 14, 15, 14],
    [8, 9, 10, 11, 12, 13, 14, 15],
];

/// Contexts of point formats 6 to 10 by the count of returns and the number of the return, both less than 16.
const CONTEXTS_OF_16: [[u8; 16]; 16] = [
    [0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5],
    [1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
    [2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3],
    [3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5],
];

impl Returns {
    /// The context of differences of x and y in point formats 0 to 5, less than 16.
    pub fn context_of_8(self) -> usize {
        usize::from(CONTEXTS_OF_8[usize::from(self.count & 7)][usize::from(self.number & 7)])
    }

    /// The context of differences of x and y in point formats 6 to 10, less than 6.
    pub fn context_of_16(self) -> usize {
        usize::from(CONTEXTS_OF_16[usize::from(self.count & 15)][usize::from(self.number & 15)])
    }

    /// The level of penetration, which is the context of heights, less than 8.
    pub fn level(self) -> usize {
        usize::from(self.count.abs_diff(self.number).min(7))
    }

    /// Whether the pulse has a single return.
    pub fn is_single(self) -> bool {
        self.count == 1
    }
}

/// The context of y or z: the number of bits of the correction before, in steps of 2 and up to a maximum, and whether
/// the pulse has a single return.
pub(super) fn coordinate_context(bits: u32, max_bits: u32, returns: Returns) -> usize {
    (bits & !1).min(max_bits) as usize + usize::from(returns.is_single())
}
