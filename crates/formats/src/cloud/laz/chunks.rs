//! The table of the chunks of a file.

use super::bytes::{u32_at, u64_at};
use super::coder::Decoder;
use super::error::Damage;
use super::integer::IntegerDecoder;

/// Bytes of the table before its entries.
const HEADER_SIZE: usize = 8;

/// Reads the number of points of each chunk from the table of a file with chunks of variable size. `start` is where the
/// points start, with the position of the table.
pub(super) fn read_counts(data: &[u8], start: usize) -> Result<Vec<u32>, Damage> {
    let at = table_position(data, start).ok_or(Damage::Truncated)?;
    let header = data.get(at..at + HEADER_SIZE).ok_or(Damage::Truncated)?;
    let chunks = u32_at(header, 4) as usize;
    if chunks == 0 {
        return Ok(Vec::new());
    }
    // No chunk takes less than a byte.
    if chunks > data.len() {
        return Err(Damage::Contradictory);
    }
    let mut decoder = Decoder::new(data, at + HEADER_SIZE)?;
    let mut numbers = IntegerDecoder::new(32, 2);
    let (mut count, mut length) = (0, 0);
    let mut counts = Vec::new();
    for _ in 0..chunks {
        count = numbers.decode(&mut decoder, count, 0)?;
        length = numbers.decode(&mut decoder, length, 1)?;
        counts.push(count as u32);
    }
    Ok(counts)
}

/// The position of the table, which compressors that cannot seek write at the end of the file.
fn table_position(data: &[u8], start: usize) -> Option<usize> {
    let position = |at: usize| {
        let bytes = data.get(at..)?.get(..8)?;
        usize::try_from(u64_at(bytes, 0))
            .ok()
            .filter(|&p| p > start && p < data.len())
    };
    position(start).or_else(|| position(data.len().checked_sub(8)?))
}
