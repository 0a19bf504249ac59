//! What pictures show: of a break both faces and a stub of stem behind each, of wood in pieces all but splinters.

mod broken;
mod chips;
mod close_up;
mod wood;

pub use broken::{BreakView, Sight, long_side, moved_end};
pub use close_up::{FilmView, close_up_of_frame};
pub use wood::close_up;
