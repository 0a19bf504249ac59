//! Any bytes as the Ply format: read or refused, never a panic.
#![no_main]

use greenstick_formats::{Format, read};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let resolve = |_: &str| Ok(bytes.to_vec());
    let _ = read(Format::Ply, bytes, "fuzz", None, &resolve);
});
