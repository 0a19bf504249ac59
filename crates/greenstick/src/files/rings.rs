//! Annual rings of other sections, from files.

use super::error::FileError;
use crate::anatomy::ANATOMY_FILE;
use greenstick_wood::anatomy::AnatomyReport;
use greenstick_wood::rings::SectionFile;
use std::path::Path;

/// Reads the rings of another section: a section file with annotated rings (JSON, as `rings` writes them), or the folder or
/// the report of an inside. Returns their mean radii as shares of the section's, from the pith outwards.
///
/// # Errors
/// [`FileError`] where there is no such file, or no rings in it.
pub fn read_ring_shares(path: &Path) -> Result<Vec<f64>, FileError> {
    let file = if path.is_dir() {
        path.join(ANATOMY_FILE)
    } else {
        path.to_owned()
    };
    let bytes = std::fs::read(&file).map_err(FileError::unreadable(&file))?;
    let text = String::from_utf8_lossy(&bytes);
    let problem = |problem: String| FileError::Rings {
        path: file.clone(),
        problem,
    };
    match serde_json::from_str::<AnatomyReport>(&text) {
        Ok(report) => (report.ring_shares())
            .ok_or_else(|| problem("the inside has no section with rings".to_owned())),
        Err(_) => SectionFile::parse(&text)
            .and_then(|section| section.ring_shares())
            .map_err(|e| problem(e.to_string())),
    }
}
