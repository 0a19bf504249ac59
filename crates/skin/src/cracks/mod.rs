//! Cracks of drying wood in the faces of a break or in an end of a stem, as grooves in closed meshes (Yang 2019 §4).

mod end;
mod face;

pub use end::{CrackedEnd, EndOfStem, OpenedEnd, crack_end, open_end, saw_and_crack_end};
pub use face::{CrackedFace, crack_faces};
