//! A hash of texts that is the same on every machine.

/// FNV-1a with 128 bits (Fowler, Noll and Vo) of a text, in 32 hexadecimal digits. Not for security.
///
/// ```
/// assert_eq!(greenstick_schema::content_hash(""), "6c62272e07bb014262b821756295c58d");
/// assert_eq!(greenstick_schema::content_hash("a"), "d228cb696f1a8caf78912b704e4a8964");
/// ```
pub fn content_hash(text: &str) -> String {
    const OFFSET_BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let hash = text.bytes().fold(OFFSET_BASIS, |hash, byte| {
        (hash ^ u128::from(byte)).wrapping_mul(PRIME)
    });
    format!("{hash:032x}")
}
