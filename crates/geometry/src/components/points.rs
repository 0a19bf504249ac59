//! Numbering of points as [`crate::Mesh::points`] defines it, for meshes with millions of vertices.

use glam::DVec3;
use std::convert::Infallible;

/// An empty slot of the table.
const EMPTY: u32 = u32::MAX;

/// Computes the numbers of [`crate::Mesh::points`].
pub(crate) fn number_points(positions: &[DVec3]) -> (Vec<u32>, usize) {
    // Zero is added so that 0 and −0 have the same bits.
    let key = |i: usize| (positions[i] + DVec3::ZERO).to_array().map(f64::to_bits);
    let numbered: Result<_, Infallible> = number_keys(positions.len(), key, |_| Ok(()));
    match numbered {
        Ok(numbered) => numbered,
    }
}

/// Numbers `count` items so that items with equal keys share a number, counted from 0 in order of first appearance. Also
/// returns how many numbers there are. `check` is called with each item and may stop the work.
///
/// Open addressing in a table of item numbers fits the cache several times better than a map keyed by the keys.
pub(crate) fn number_keys<E>(
    count: usize,
    key: impl Fn(usize) -> [u64; 3],
    check: impl Fn(usize) -> Result<(), E>,
) -> Result<(Vec<u32>, usize), E> {
    let size = (count * 2).next_power_of_two().max(2);
    let shift = 64 - size.trailing_zeros();
    let mut table = vec![EMPTY; size];
    let mut numbers = vec![0u32; count];
    let mut next = 0;
    for i in 0..count {
        check(i)?;
        let own = key(i);
        let mut slot = (hash(own) >> shift) as usize;
        loop {
            match table[slot] {
                EMPTY => {
                    table[slot] = i as u32;
                    numbers[i] = next;
                    next += 1;
                    break;
                }
                other if key(other as usize) == own => {
                    numbers[i] = numbers[other as usize];
                    break;
                }
                _ => slot = (slot + 1) & (size - 1),
            }
        }
    }
    Ok((numbers, next as usize))
}

/// The points of a triangle's corners; `None` for a triangle with an index out of range.
pub(crate) fn corner_points(triangle: [u32; 3], points: &[u32]) -> Option<[u32; 3]> {
    let point = |i: u32| points.get(i as usize).copied();
    Some([
        point(triangle[0])?,
        point(triangle[1])?,
        point(triangle[2])?,
    ])
}

/// Mixes three coordinates into 64 bits, the upper ones best (multiplication by odd constants with folded halves).
fn hash(key: [u64; 3]) -> u64 {
    key.iter().fold(0x243F_6A88_85A3_08D3, |h: u64, &k| {
        let mixed = (h ^ k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93)
    })
}
