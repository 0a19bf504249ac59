//! Reading and writing of files: mesh files with their companions in, several files out together or not at all.
//!
//! This is the only module of the libraries that accesses the file system; all stages work on scenes.

mod error;
mod images;
mod read;
#[cfg(feature = "simulate")]
pub mod run;
mod staged;
mod whole;
mod write;

pub use error::FileError;
pub use images::{carry_images, embed_images};
pub use read::{Source, load, load_content, read};
#[cfg(feature = "simulate")]
pub use whole::read_measured;
pub use whole::{OtherRings, read_photograph, read_rings, read_text};
pub use write::{
    Batch, Output, check_distinct, check_folder, check_writable, encode, output_format, write_all,
    write_folder, write_streamed,
};

use std::path::Path;

/// Returns the folder that a file is in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}
