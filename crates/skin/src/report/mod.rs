//! What is said of a break: a report in numbers, and notes on what was assumed, limited, repaired or not possible.

mod notes;
mod records;

pub use notes::BreakNote;
pub use records::{
    BreakReport, FaceReport, FurtherBreak, InputReport, PieceReport, PlaceReport, SpeciesReport,
};
