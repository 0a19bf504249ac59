//! Any bytes as LAZ: read or refused, never a panic.
#![no_main]

use greenstick_formats::{CloudFormat, InputFormat, read_content};
use std::sync::Once;

/// The decompressor panics on damaged data, and the reader turns that into an error; the fuzzer's own hook would count it
/// as a finding. A panic that leaves the reader still ends the run.
static NO_HOOK: Once = Once::new();

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    NO_HOOK.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let resolve = |_: &str| Ok(bytes.to_vec());
    let format = InputFormat::Cloud(CloudFormat::Laz);
    let _ = read_content(format, bytes, "fuzz", None, &resolve);
});
