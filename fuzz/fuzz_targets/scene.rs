//! Any text as the scene of a simulation: read or refused, never a panic, and what was read is written and read again as it was.
#![no_main]

use greenstick::fibre::scene::Scene;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(scene) = Scene::read(text) {
        let again = Scene::read(&scene.to_toml());
        assert_eq!(again.ok(), Some(scene));
    }
});
