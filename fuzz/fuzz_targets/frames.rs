//! Any bytes as the frames of a run: read or refused, never a panic. What could be read is taken for frames of a small stick, whose
//! scene is that of the program's own tests. Checksums are made right first, as no change of bytes finds them.
#![no_main]

use greenstick::fibre::scene::Scene;
use greenstick::fibre::simulate::SceneMeshes;
use greenstick::fibre::store::{IndexedFrames, checksum};
use greenstick::geometry::Context;
use greenstick::rods_scene;
use greenstick::skin::film::RunWood;
use greenstick::skin::rods::{FractureState, Wood};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::LazyLock;

static STICK: LazyLock<RunWood> = LazyLock::new(|| {
    let scene = Scene::read(include_str!("../../.ci/snap.toml")).expect("a scene");
    RunWood::from_scene(&scene, &SceneMeshes::default(), &Context::quiet()).expect("its wood")
});

/// Gives every whole record the checksum of its content.
fn seal(store: &mut [u8]) {
    let mut at = 16;
    while let Some(length) = store.get(at..).and_then(|rest| rest.first_chunk()) {
        let end = (at + 8).saturating_add(u64::from_le_bytes(*length) as usize);
        if end.saturating_add(8) > store.len() {
            break;
        }
        let sum = checksum(&store[at + 8..end]);
        store[end..end + 8].copy_from_slice(&sum.to_le_bytes());
        at = end + 8;
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut store = bytes.to_vec();
    seal(&mut store);
    let Ok(mut frames) = IndexedFrames::open(Cursor::new(store)) else {
        return;
    };
    let wood = Wood {
        stem: &STICK.stem,
        stem_to_rods: STICK.scene_from_stem,
        bundle: &STICK.bundle,
        along: &STICK.placed.along,
        cells: &STICK.placed.cells,
        outline: &STICK.placed.outline,
        bark: None,
        pull_out: 1.0,
    };
    for number in 0..frames.count() {
        if let Ok(Some(frame)) = frames.read(number) {
            if FractureState::from_frame(&wood, &frame, &BTreeMap::new()).is_ok() {
                let _ = rods_scene(&frame, &STICK.shapes);
            }
        }
    }
});
