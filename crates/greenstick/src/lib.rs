//! Break wood: branches, trunks, logs and boards.
//!
//! A scene goes in with a request; pieces that fit, a report and, if wanted, a picture come out:
//!
//! ```
//! use greenstick::fracture::recipe::Recipe;
//! use greenstick::geometry::Context;
//! use greenstick::{Break, BreakRequest, break_scene, built_in_branch};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let request = BreakRequest {
//!     texture_width: 64,
//!     ..BreakRequest::single(Break {
//!         place: "0.4".parse()?, // or "12cm", or the point "0.3,2.1,-0.4"
//!         recipe: Recipe::resolve(&["simple-tension"], None, &["species=white oak", "seed=7"])?,
//!         ..Break::default()
//!     })
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
//! [`picture_of_break`] takes a picture. A [`BreakSession`] breaks one scene often, with requests that change, and makes
//! anew only what a change touches.
//!
//! # Features
//!
//! All are on by default. Without them the crate opens no files, and it compiles for `wasm32-unknown-unknown`, where it
//! works on one thread.
//!
//! - `files`: the module `files`, which reads and writes files.
//! - `simulate`: the modules `simulate`, `film`, `fit`, `simulated_faces`, `bending` and `toughness`, and the crate `fibre`. With `files`, runs are read from folders and written to them.
//! - `laz`: reads compressed point clouds.
//! - `parquet`: writes tables as Parquet.
//! - `usd`: writes scenes and films as USD.
#![deny(missing_docs)]

pub mod anatomy;
#[cfg(feature = "simulate")]
pub mod bending;
#[cfg(feature = "simulate")]
mod charts;
mod error;
#[cfg(feature = "files")]
pub mod files;
#[cfg(feature = "simulate")]
pub mod film;
#[cfg(feature = "simulate")]
pub mod fit;
mod pictures;
mod provenance;
#[cfg(feature = "simulate")]
mod report_file;
mod request;
pub mod scanning;
pub mod session;
#[cfg(feature = "simulate")]
pub mod simulate;
#[cfg(feature = "simulate")]
pub mod simulated_faces;
#[cfg(feature = "simulate")]
pub mod toughness;

pub use error::Error;
#[cfg(feature = "simulate")]
pub use greenstick_fibre as fibre;
pub use greenstick_formats as formats;
pub use greenstick_fracture as fracture;
pub use greenstick_geometry as geometry;
pub use greenstick_geometry::ErrorKind;
pub use greenstick_picture as picture;
pub use greenstick_schema as schema;
pub use greenstick_skin as skin;
pub use greenstick_skin::report::{
    BreakReport, FaceReport, InputReport, PieceReport, PlaceReport, SpeciesReport,
};
#[cfg(feature = "simulate")]
pub use greenstick_skin::rods_scene::rods_scene;
pub use greenstick_wood as wood;
pub use greenstick_wood::anatomy::SectionRingSettings;
pub use greenstick_wood::branch::built_in_branch;
pub use pictures::{picture_of_break, picture_of_moved_break, picture_of_scene, picture_of_skin};
pub use provenance::provenance;
pub use request::{Break, BreakRequest, BreakStage, RequestFile, RequestFileError};
pub use session::{BreakSession, Broken, break_scene};

/// Keeps the example in the README one that compiles.
#[cfg(all(doctest, feature = "files"))]
#[doc = include_str!("../../../README.md")]
struct Readme;
