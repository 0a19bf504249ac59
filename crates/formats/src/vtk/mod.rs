//! Writers of VTK XML files for ParaView: image data (`.vti`), points and lines (`.vtp`), hexahedra (`.vtu`), multi-block data sets (`.vtm`) and
//! time series (`.pvd`).
//!
//! Arrays are appended as raw data, compressed with zlib in blocks (*VTK File Formats*, "XML file formats"), with 64-bit
//! headers.

mod appended;
mod collection;
mod fields;
mod image;
mod lines;
mod piece;
mod points;
mod unstructured;

pub use appended::compress;
pub use collection::{Block, TimedFile, collection, write_multiblock};
pub use fields::Field;
pub use image::{Image, ImageArray, ImageNumber, write_image};
pub use lines::{Polylines, write_lines};
pub(crate) use points::write_points;
pub use unstructured::{Hexahedra, write_hexahedra};
