//! A studio without a window, driven as a person would.

use eframe::egui;
use egui_kittest::Harness;
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
    Harness::builder()
        .with_size(egui::vec2(1360.0, 860.0))
        // A double click takes four frames.
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(|ui, studio: &mut Studio| studio.frame(ui), state)
}

/// Longest wait for an answer: test machines may be busy.
const PATIENCE: Duration = Duration::from_secs(300);

/// Goes on until the studio has nothing more to do.
pub fn settle(harness: &mut Harness<'static, Studio>) {
    let start = Instant::now();
    harness.step();
    while harness.state().is_busy() {
        assert!(start.elapsed() < PATIENCE, "no answer");
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
    }
    harness.run_steps(2);
}
