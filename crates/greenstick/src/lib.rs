//! Break wood: branches, trunks, logs and boards.
//!
//! [`prepare`] finds the stem in a scene at the place of the break; [`Prepared::model`] breaks it with given parameters,
//! as often as they change.
#![deny(missing_docs)]

mod breaking;
mod error;
pub mod files;
mod looks;
mod model;
mod pictures;
mod prepare;
mod refine;
mod report;

pub use breaking::{BreakRequest, Broken, break_scene, built_in_branch};
pub use error::Error;
pub use greenstick_formats as formats;
pub use greenstick_fracture as fracture;
pub use greenstick_geometry as geometry;
pub use greenstick_picture as picture;
pub use greenstick_skin as skin;
pub use greenstick_wood as wood;
pub use looks::Looks;
pub use model::Model;
pub use pictures::{picture_of_break, picture_of_scene};
pub use prepare::{Extent, Prepared, prepare};
pub use report::{BreakReport, FaceReport, InputReport, PieceReport, PlaceReport, SpeciesReport};
