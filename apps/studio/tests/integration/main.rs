//! The studio without a window.

mod anatomy;
mod common;
mod cracks;
mod early;
mod fans;
mod hand;
mod labels;
mod limbs;
mod lost_card;
mod page;
mod paint;
mod photograph;
mod picture;
mod simulation;
mod snapshots;
mod window;
