//! Greenstick's studio: a window in which a stem is seen, turned and broken.
//!
//! `model` is what it knows, `view` what the viewport draws, `ui` the window, and `platform` what it needs of the machine. All but
//! `platform::native` and `window` works without threads and files.
#![deny(missing_docs)]

pub mod model;
pub mod platform;
pub mod ui;
pub mod view;
#[cfg(not(target_arch = "wasm32"))]
pub mod window;

#[cfg(not(target_arch = "wasm32"))]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
