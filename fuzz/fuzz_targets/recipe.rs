//! Any text as a recipe: read or refused, never a panic, and what was read is written and read again as it was.
#![no_main]

use greenstick::RequestFile;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(file) = RequestFile::resolve(&[], Some(text), &[]) {
        let _ = file.request();
        let again = RequestFile::resolve(&[], Some(&file.to_toml()), &[]);
        assert_eq!(again.ok(), Some(file));
    }
});
