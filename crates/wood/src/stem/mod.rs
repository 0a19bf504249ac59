//! The stem: a curved axis with sections, and the address (ring coordinate, angle, length) of every point in it.
//!
//! [`find`] finds one in a mesh at a [`Place`].

mod attach;
mod axis;
mod build;
mod centreline;
mod error;
mod find;
mod grain;
mod place;
mod polygon;
mod rings;
mod seed;
mod shells;
mod surface;
mod trace;

pub use axis::{Axis, Frame};
pub use build::{Section, Stem, StemKind};
pub use error::StemError;
pub use find::{Found, PithChoice, StemOptions, find};
pub use grain::{Chart, GrainSpace};
pub use place::{Place, PlaceError};
pub use rings::RingField;
