//! Annual rings of other sections, from files.

use super::error::FileError;
use crate::anatomy::ANATOMY_FILE;
use greenstick_geometry::Context;
use greenstick_wood::anatomy::AnatomyReport;
use greenstick_wood::rings::{SectionFile, SectionFileError};
use std::path::Path;

/// What one section takes of another's rings.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherRings {
    /// Mean radii as shares of the section's, from the pith outwards.
    pub shares: Vec<f64>,
    /// Ring coordinate at which eccentricity begins, fitted to rings that were annotated.
    pub eccentricity_onset: Option<f64>,
}

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
    let text = String::from_utf8_lossy(&bytes);
    let problem = |problem: String| FileError::Rings {
        path: file.clone(),
        problem,
    };
    if let Ok(report) = serde_json::from_str::<AnatomyReport>(&text) {
        let shares = report.ring_shares();
        return Ok(OtherRings {
            shares: shares.ok_or_else(|| problem("the inside has no section with rings".into()))?,
            eccentricity_onset: None,
        });
    }
    let of_section = || -> Result<OtherRings, SectionFileError> {
        let section = SectionFile::parse(&text)?;
        Ok(OtherRings {
            shares: section.ring_shares()?,
            eccentricity_onset: Some(section.fit_eccentricity_onset(None, &Context::quiet())?),
        })
    };
    of_section().map_err(|e| problem(e.to_string()))
}
