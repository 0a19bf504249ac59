//! The stem: a curved axis with sections, and the address (ring coordinate, angle, length) of every point in it.
//!
//! [`find`] finds one in a mesh at a [`Place`].

mod attach;
mod axis;
mod build;
mod centreline;
mod course;
mod error;
mod find;
mod free;
mod grain;
mod layered;
mod place;
pub(crate) mod polygon;
mod rings;
mod seed;
mod shells;
mod surface;
mod trace;

pub use axis::{Axis, Frame};
pub use build::{Section, Stem, StemKind};
pub use error::StemError;
pub use find::{Found, PithChoice, StemOptions, find};
pub use grain::GrainSpace;
pub use layered::LayeredGrain;
pub use place::{Place, PlaceError};
pub use rings::RingField;
