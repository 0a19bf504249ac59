//! The stages of one break up to the cut: stem → layout → heights → cut, each a value that is made of the one before, and
//! what decides how they are made.

mod break_stage;
mod cracks;
mod order;
mod slot;
mod species_relief;
mod spiral_grain;
mod values;
mod whole_stem;

pub use crate::prepared::Neighbours;
pub use break_stage::BreakStage;
pub use cracks::{CrackRequest, Cracks};
pub use order::{BreakPlace, BreakPlaces, PlacesError, check_number};
pub use slot::{Ids, Scratch, Slot, SlotValue};
pub use species_relief::SpeciesRelief;
pub use spiral_grain::{SpiralGrain, has_spiral_grain};
pub use values::{BreakStages, CutStage, HeightStage, StemStage, inner_wood};
pub use whole_stem::WholeStem;
