//! The checksum of stored bytes.

/// Returns a 64-bit checksum (FNV-1a over words of 8 bytes, the last one padded with zeros, then the length).
pub fn checksum(bytes: &[u8]) -> u64 {
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let mix = |h: u64, word: u64| {
        let h = (h ^ word).wrapping_mul(PRIME);
        // FNV alone does not mix high bits into low ones.
        h ^ (h >> 29)
    };
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        hash = mix(hash, u64::from_le_bytes(word));
    }
    mix(hash, bytes.len() as u64)
}
