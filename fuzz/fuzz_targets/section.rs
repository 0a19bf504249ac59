//! Any text as a section file, and as one that gives its rings to another: read or refused, never a panic.
#![no_main]

use greenstick::geometry::Context;
use greenstick::wood::anatomy::OtherRings;
use greenstick::wood::rings::{RingSeries, SectionFile, SectionRingMethod};

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = OtherRings::parse(text);
    if let Ok(file) = SectionFile::parse(text) {
        let rings = SectionRingMethod::Field(RingSeries::Number(3));
        if let Ok(made) = file.rings(&rings, None, &Context::quiet()) {
            let _ = made.compare(&Context::quiet());
        }
    }
});
