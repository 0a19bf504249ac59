//! What the studio knows and does, apart from any window: no threads, no files, no clock.

pub mod breaks;
pub mod command;
pub mod desk;
pub mod early;
pub mod engine;
pub mod held;
pub mod history;
pub mod input;
pub mod link;
pub mod look;
pub mod meshes;
pub mod photograph;
pub mod placed_cracks;
pub mod project;
pub mod project_file;
pub mod randomise;
pub mod rings;
pub mod section;
pub mod section_book;
#[cfg(not(target_arch = "wasm32"))]
pub mod simulated;
pub mod simulation;
pub mod tilt;
pub mod units;
pub mod wire;
