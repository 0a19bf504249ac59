//! The viewport: camera, what lies under the pointer, and drawing on the card.

pub mod camera;
pub mod frame;
mod globals;
pub mod pick;
pub mod renderer;
mod resources;
mod section;
pub mod sharpness;
