//! Annual rings of other sections, from files.

use super::error::FileError;
use crate::anatomy::ANATOMY_FILE;
pub use greenstick_wood::anatomy::OtherRings;
use std::path::Path;

/// Reads the rings of another section: a section file with annotated rings (JSON, as `rings` writes them), or the folder or
/// the report of an inside.
///
/// # Errors
/// [`FileError`] where there is no such file, or no rings in it.
pub fn read_rings(path: &Path) -> Result<OtherRings, FileError> {
    let file = if path.is_dir() {
        path.join(ANATOMY_FILE)
    } else {
        path.to_owned()
    };
    let bytes = std::fs::read(&file).map_err(FileError::unreadable(&file))?;
    OtherRings::parse(&String::from_utf8_lossy(&bytes)).map_err(|problem| FileError::Rings {
        path: file,
        problem: problem.to_string(),
    })
}
