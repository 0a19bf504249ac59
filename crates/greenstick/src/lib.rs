//! Break wood: branches, trunks, logs and boards.
//!
//! [`prepare`] finds the stem in a scene at the place of the break; [`Prepared::model`] breaks it with given parameters,
//! as often as they change.
#![deny(missing_docs)]

mod error;
mod kept;
mod model;
mod prepare;
mod refine;

pub use error::Error;
pub use greenstick_formats as formats;
pub use greenstick_fracture as fracture;
pub use greenstick_geometry as geometry;
pub use greenstick_picture as picture;
pub use greenstick_skin as skin;
pub use greenstick_wood as wood;
pub use model::{Broken, Model};
pub use prepare::{Prepared, prepare};
