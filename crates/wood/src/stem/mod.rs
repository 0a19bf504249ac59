//! The stem: a curved axis with sections, and the address (ring coordinate, angle, length) of every point in it.
//!
//! [`find_stem`] finds one in a mesh at a [`StemLocation`].

mod attach;
mod axis;
mod body;
mod build;
pub(crate) mod centreline;
mod choose;
mod error;
mod find;
mod free;
mod grain;
mod identity;
mod layered;
mod left_out;
mod level_steps;
mod location;
mod model;
mod options;
mod parts;
mod plain;
mod plank;
mod principal;
mod section;
mod seed;
mod shells;
mod slice;
mod surface;
mod taper;
mod trace;
mod tube;
mod valid;

pub use axis::{Axis, Frame};
pub use error::StemError;
pub use find::{CarriedShell, FoundStem, find_stem, find_stem_along};
pub use grain::{GrainSpace, SlopeOfGrain, TaperPoint};
pub use identity::StemIdentity;
pub use layered::LayeredGrain;
pub use left_out::{LeftOut, Limb, find_left_out};
pub use level_steps::LevelSteps;
pub use location::{LOCATION, StemLocation, StemLocationError};
pub use model::{CrossSection, Stem, StemKind};
pub use options::{PITH, PithPosition, PithPositionError, StemOptions};
