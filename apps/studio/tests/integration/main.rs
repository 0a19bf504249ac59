//! The studio without a window.

mod common;
mod early;
mod page;
mod picture;
mod window;
