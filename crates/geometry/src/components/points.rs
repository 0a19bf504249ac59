//! Numbering of points: what [`crate::Mesh::points`] defines, for meshes of millions of vertices.

use glam::DVec3;

/// Slot of the table that holds no vertex.
const FREE: u32 = u32::MAX;

/// The numbers of [`crate::Mesh::points`] by open addressing with a table of vertex indices, which fits the cache
/// several times better than a map keyed by positions.
pub(crate) fn number_points(positions: &[DVec3]) -> (Vec<u32>, usize) {
    let size = (positions.len() * 2).next_power_of_two().max(2);
    let shift = 64 - size.trailing_zeros();
    let mut table = vec![FREE; size];
    let mut numbers = vec![0u32; positions.len()];
    let mut count = 0;
    // Zero is added so that 0 and −0 have the same bits.
    let bits = |i: usize| (positions[i] + DVec3::ZERO).to_array().map(f64::to_bits);
    for i in 0..positions.len() {
        let key = bits(i);
        let mut slot = (hash(key) >> shift) as usize;
        loop {
            match table[slot] {
                FREE => {
                    table[slot] = i as u32;
                    numbers[i] = count;
                    count += 1;
                    break;
                }
                other if bits(other as usize) == key => {
                    numbers[i] = numbers[other as usize];
                    break;
                }
                _ => slot = (slot + 1) & (size - 1),
            }
        }
    }
    (numbers, count as usize)
}

/// Mixes three coordinates into 64 bits, the upper ones best (multiplication by odd constants with folded halves).
fn hash(key: [u64; 3]) -> u64 {
    key.iter().fold(0x243F_6A88_85A3_08D3, |h: u64, &k| {
        let mixed = (h ^ k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93)
    })
}
