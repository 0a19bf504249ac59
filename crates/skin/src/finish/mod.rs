//! The finish of a break: its separate pieces, the scene that they and everything that was not cut make, and the report.

mod broken_wood;
mod budget;
mod finished_break;
mod notes;
mod parting;
mod piece;
mod pieces;
mod report;
mod scene;
mod way;

pub use broken_wood::BrokenWood;
pub use budget::{added_triangles, within_budget};
pub use finished_break::FinishedBreak;
#[cfg(feature = "rods")]
pub(crate) use parting::Parted;
pub use parting::Separation;
pub use piece::{Piece, PieceRole, Pieces};
pub use pieces::{FinishOptions, finish};
pub use report::{BreakInput, break_notes, break_report};
pub use scene::{AssembledBreaks, NodeRole, assemble, left_at_base};
#[cfg(feature = "rods")]
pub(crate) use way::{Half, Way};
