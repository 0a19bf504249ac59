//! The studio without a window.

mod common;
mod early;
mod page;
mod photograph;
mod picture;
mod simulation;
mod window;
