//! What the studio knows and does, apart from any window: no threads, no files, no clock.

pub mod command;
pub mod engine;
pub mod history;
pub mod input;
pub mod look;
pub mod meshes;
pub mod project;
pub mod randomise;
