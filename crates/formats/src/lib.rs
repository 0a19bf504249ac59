//! Readers and writers of mesh files (bytes in, a [`Scene`](greenstick_geometry::Scene) out, and back), readers of point
//! clouds, tables and photographs, and writers of tables, VTK files and films.
//!
//! No function here opens a file: companion files (a `.bin`, a `.mtl`) are requested through [`Resolve`] and returned as
//! [`Encoded`]. The same scene always gives the same bytes.
//!
//! # Features
//!
//! `laz` (compressed point clouds), `parquet` (tables as Parquet), `photograph` (photographs as JPEG and PNG, textures as WebP, too) and `usd` (scenes
//! and films as USD) are on by default.
#![deny(missing_docs)]

mod attribute;
mod check;
mod cloud;
mod companions;
mod detect;
mod error;
pub mod film;
pub mod finite_elements;
mod format;
mod gltf;
mod mesh;
mod obj;
mod off;
#[cfg(feature = "photograph")]
pub mod photograph;
#[cfg(feature = "photograph")]
pub mod pixels;
mod ply;
mod polygon;
mod position;
mod sink;
mod stl;
mod subset;
mod table;
mod text;
pub mod tucson;
mod unit;
mod uri;
#[cfg(feature = "usd")]
pub mod usd;
pub mod vtk;

pub use cloud::{CloudFile, Content, read_content};
pub use companions::{
    Encoded, Reach, RefusedReference, Resolve, embed_images, reference_within, relative_reference,
};
pub use error::FormatError;
pub use format::{CloudFormat, Format, InputFormat, OutputFormat};
pub use mesh::{read, write, write_as};
#[cfg(feature = "parquet")]
pub use table::ParquetStream;
pub use table::{
    CSVW_FILE, DENSITY_UNITS, DescribedTable, MeasurementError, STRESS_UNITS, TableFormat, TextRow,
    TextTable, UnitColumn, read_csv, read_measurements, with_csv_metadata, write_csv_metadata,
    write_table,
};
pub use unit::{LengthUnit, UnknownUnit};
pub use uri::percent_decoded;
