//! Any bytes as LAZ: read or refused, never a panic.
#![no_main]

use greenstick_formats::{CloudFormat, InputFormat, read_content};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let resolve = |_: &str| Ok(bytes.to_vec());
    let format = InputFormat::Cloud(CloudFormat::Laz);
    let _ = read_content(format, bytes, "fuzz", None, &resolve);
});
