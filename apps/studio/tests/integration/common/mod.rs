//! A studio without a window, driven as a person would.

use eframe::egui;
use egui_kittest::{Harness, HarnessBuilder, TestRenderer};
use greenstick::files::encode;
use greenstick::formats::LengthUnit;
use greenstick::geometry::Context;
use greenstick::{RequestFile, built_in_branch};
use greenstick_studio::model::engine::export;
use greenstick_studio::platform::native::Native;
use greenstick_studio::ui::studio::Studio;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// A folder of its own for each test, removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    /// An empty folder.
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("greenstick-studio-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A file of the repository's test data.
pub fn test_data(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    root.join(name).display().to_string()
}

/// A studio that keeps its settings in `folder`.
pub fn studio(folder: &Folder, path: Option<&str>) -> Harness<'static, Studio> {
    let platform = Native::new(Some(folder.0.join("config")), Arc::new(|| {}));
    let state = Studio::new(&egui::Context::default(), Box::new(platform), path);
    builder(egui::vec2(1360.0, 860.0))
        .build_ui_state(|ui, studio: &mut Studio| studio.frame(ui), state)
}

fn builder(size: egui::Vec2) -> HarnessBuilder<Studio> {
    Harness::builder()
        .with_size(size)
        // A double click takes four frames.
        .with_step_dt(1.0 / 60.0)
}

/// The same in a window of a size, drawn by a renderer.
pub fn studio_on(
    folder: &Folder,
    path: Option<&str>,
    size: egui::Vec2,
    renderer: impl TestRenderer + 'static,
) -> Harness<'static, Studio> {
    let platform = Native::new(Some(folder.0.join("config")), Arc::new(|| {}));
    let state = Studio::new(&egui::Context::default(), Box::new(platform), path);
    let builder = builder(size).renderer(renderer);
    builder.build_ui_state(|ui, studio: &mut Studio| studio.frame(ui), state)
}

/// The same studio in another window, drawn by another renderer.
pub fn moved_to(
    harness: Harness<'static, Studio>,
    size: egui::Vec2,
    renderer: impl TestRenderer + 'static,
) -> Harness<'static, Studio> {
    let builder = builder(size).renderer(renderer);
    let state = harness.into_state();
    builder.build_ui_state(|ui, studio: &mut Studio| studio.frame(ui), state)
}

/// Longest wait for an answer: test machines may be busy.
const PATIENCE: Duration = Duration::from_secs(300);

/// Goes on until the studio has nothing more to do.
pub fn settle(harness: &mut Harness<'static, Studio>) {
    let start = Instant::now();
    harness.step();
    loop {
        while harness.state().is_busy() {
            assert!(start.elapsed() < PATIENCE, "no answer");
            std::thread::sleep(Duration::from_millis(5));
            harness.step();
        }
        // The last news of work that ended may ask for more.
        harness.run_steps(2);
        if !harness.state().is_busy() {
            return;
        }
    }
}

/// Drags with the left button from one place to another, in a few steps.
pub fn drag(harness: &mut Harness<'static, Studio>, from: egui::Pos2, to: egui::Pos2) {
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=6 {
        harness.hover_at(from + (to - from) * (i as f32 / 6.0));
        harness.step();
    }
    harness.drop_at(to);
    settle(harness);
}

/// Width of the textures that are baked to be compared, pixels: those of a window are of the full width in `.ci/studio.py`.
const TEXTURE_WIDTH: u32 = 64;

fn coarse(file: &RequestFile) -> RequestFile {
    RequestFile {
        texture_width: TEXTURE_WIDTH,
        ..file.clone()
    }
}

/// The recipe that the studio saves, and the pieces that the command line makes of it but for the width of textures, as GLB.
pub fn saved_and_broken(
    harness: &mut Harness<'static, Studio>,
    folder: &Folder,
) -> (RequestFile, Vec<u8>) {
    let path = folder.0.join("saved.greenstick.toml");
    harness.state_mut().save_as(path.to_str().unwrap());
    let text = std::fs::read_to_string(&path).unwrap();
    let file = RequestFile::resolve(&[], Some(&text), &[]).unwrap();
    let coarse = coarse(&file);
    let mut broken =
        greenstick::break_scene(built_in_branch(), &coarse.request(), &Context::quiet()).unwrap();
    broken.scene.metadata = coarse.provenance(None, None).metadata();
    let outputs = encode(&broken.scene, Path::new("out.glb"), LengthUnit::Metre).unwrap();
    (file, outputs.into_iter().next().unwrap().bytes)
}

/// The pieces that the studio exports of what it has open but for the width of textures, as GLB.
pub fn exported(harness: &Harness<'static, Studio>) -> Vec<u8> {
    let project = &harness.state().project;
    let file = coarse(&project.file);
    let broken = export(&project.input, &file, |_| {}, &Context::quiet()).unwrap();
    let outputs = encode(&broken.scene, Path::new("out.glb"), LengthUnit::Metre).unwrap();
    outputs.into_iter().next().unwrap().bytes
}
