//! Compression of the tables of a binary layer, for OpenUSD's `integerCoding.cpp` and `fastCompression.cpp`.

use std::collections::BTreeMap;

/// Encodes integers as differences: the most common difference, then two bits for each number with the size of its
/// difference, then the differences.
pub(super) fn encode_integers(numbers: &[i32]) -> Vec<u8> {
    if numbers.is_empty() {
        return Vec::new();
    }
    let mut before = 0;
    let differences: Vec<i32> = numbers
        .iter()
        .map(|&n| n.wrapping_sub(std::mem::replace(&mut before, n)))
        .collect();
    let mut counts: BTreeMap<i32, usize> = BTreeMap::new();
    for &d in &differences {
        *counts.entry(d).or_default() += 1;
    }
    let most_common = counts.iter().max_by_key(|(_, n)| **n);
    let common = most_common.map_or(0, |(&d, _)| d);
    let mut codes = vec![0_u8; numbers.len().div_ceil(4)];
    let mut rest = Vec::with_capacity(numbers.len());
    for (k, &d) in differences.iter().enumerate() {
        let code = if d == common {
            0
        } else if let Ok(d) = i8::try_from(d) {
            rest.extend(d.to_le_bytes());
            1
        } else if let Ok(d) = i16::try_from(d) {
            rest.extend(d.to_le_bytes());
            2
        } else {
            rest.extend(d.to_le_bytes());
            3
        };
        codes[k / 4] |= code << (2 * (k % 4));
    }
    [common.to_le_bytes().as_slice(), &codes, &rest].concat()
}

/// Wraps bytes as one LZ4 block of literals, after the 0 that stands for a single block. The tables are small compared
/// with the values, which are not compressed.
pub(super) fn lz4_literals(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len() + bytes.len() / 255 + 8);
    out.push(0);
    if bytes.len() < 15 {
        out.push((bytes.len() as u8) << 4);
    } else {
        out.push(0xF0);
        let mut left = bytes.len() - 15;
        while left >= 255 {
            out.push(255);
            left -= 255;
        }
        out.push(left as u8);
    }
    out.extend_from_slice(bytes);
    out
}
