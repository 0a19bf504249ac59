//! Break wood: branches, trunks, logs and boards.
//!
//! A scene goes in with a request; pieces that fit, a report and, if wanted, a picture come out:
//!
//! ```
//! use greenstick::fracture::recipe::Recipe;
//! use greenstick::geometry::Context;
//! use greenstick::{BreakRequest, break_scene, built_in_branch};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let request = BreakRequest {
//!     place: "0.4".parse()?, // or "12cm", or the point "0.3,2.1,-0.4"
//!     recipe: Recipe::resolve(&["simple-tension"], None, &["species=white oak", "seed=7"])?,
//!     part: 0.03, // m
//!     texture_width: 64,
//!     ..BreakRequest::default()
//! };
//! let broken = break_scene(built_in_branch(), &request, &Context::quiet())?;
//! println!("{}", broken.report);
//! assert_eq!(broken.scene.nodes[0].name, "lower");
//!
//! let whole = broken.report.input.volume_m3.unwrap();
//! let parts: f64 = broken.report.pieces.iter().filter_map(|p| p.volume_m3).sum();
//! assert!((parts / whole - 1.0).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```
//!
//! [`files::read`] gives the scene of a mesh file, [`files::encode`] and [`files::write_all`] write one.
//! [`picture_of_break`] takes a picture. To break one stem often, with parameters that change, [`prepare`] it once
//! and call [`Prepared::model`] each time.
#![deny(missing_docs)]

pub mod anatomy;
pub mod bending;
mod branch;
mod breaking;
mod cracking;
mod cracks;
mod erosion;
mod error;
pub mod files;
pub mod film;
pub mod fit;
mod fray;
mod hang;
mod kept;
mod looks;
mod model;
mod outwards;
mod pictures;
mod prepare;
mod refine;
mod report;
pub mod rings;
mod rods;
mod saw;
pub mod scanning;
pub mod simulate;

pub use branch::built_in_branch;
pub use breaking::{BreakRequest, Broken, break_scene};
pub use cracking::SawnEnd;
pub use cracks::{CrackedBreak, CrackedEnd};
pub use error::Error;
pub use greenstick_fibre as fibre;
pub use greenstick_formats as formats;
pub use greenstick_fracture as fracture;
pub use greenstick_geometry as geometry;
pub use greenstick_picture as picture;
pub use greenstick_skin as skin;
pub use greenstick_wood as wood;
pub use hang::HangReport;
pub use looks::Looks;
pub use model::{Drawn, Model};
pub use pictures::{picture_of_break, picture_of_scene, picture_of_skin};
pub use prepare::{Extent, Prepared, prepare};
pub use report::{BreakReport, FaceReport, InputReport, PieceReport, PlaceReport, SpeciesReport};
pub use rods::rods_scene;

/// Keeps the example in the README one that compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
