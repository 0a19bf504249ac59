//! The studio without a window.

mod anatomy;
mod common;
mod cracks;
mod early;
mod lost_card;
mod page;
mod photograph;
mod picture;
mod simulation;
mod snapshots;
mod window;
