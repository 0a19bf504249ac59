//! The stem: a curved axis with sections, and the address (ring coordinate, angle, length) of every point in it.
//!
//! [`find`] finds one in a mesh at a [`Place`].

mod attach;
mod axis;
mod build;
mod centreline;
mod find;
mod grain;
mod place;
mod polygon;
mod rings;
mod seed;
mod shells;
mod surface;
mod trace;
#[cfg(test)]
mod zz;

pub use axis::{Axis, Frame};
pub use build::{Section, Stem, StemKind};
pub use find::{Found, PithChoice, StemError, StemOptions, find};
pub use grain::{Chart, GrainSpace};
pub use place::{Place, PlaceError};
pub use rings::RingField;
