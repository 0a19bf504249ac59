//! Annual rings of other sections.

use super::report::AnatomyReport;
use crate::rings::{SectionFile, SectionFileError};
use greenstick_geometry::Context;

/// What one section takes of another's rings.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherRings {
    /// Mean radii as shares of the section's, from the pith outwards.
    pub shares: Vec<f64>,
    /// Ring coordinate at which eccentricity begins, fitted to rings that were annotated.
    pub eccentricity_onset: Option<f64>,
}

/// Why there are no rings of another section.
#[derive(Debug, thiserror::Error)]
pub enum OtherRingsError {
    /// The report of an inside without rings.
    #[error("the inside has no section with rings")]
    NoSection,
    /// No section file, or one without rings.
    #[error(transparent)]
    Section(#[from] SectionFileError),
}

impl OtherRings {
    /// Reads them from text: a section file with annotated rings, or the report of an inside.
    ///
    /// # Errors
    /// [`OtherRingsError`] where it is neither, or has no rings.
    pub fn parse(text: &str) -> Result<Self, OtherRingsError> {
        if let Ok(report) = serde_json::from_str::<AnatomyReport>(text) {
            return Ok(OtherRings {
                shares: report.ring_shares().ok_or(OtherRingsError::NoSection)?,
                eccentricity_onset: None,
            });
        }
        let section = SectionFile::parse(text)?;
        Ok(OtherRings {
            shares: section.ring_shares()?,
            eccentricity_onset: Some(section.fit_eccentricity_onset(None, &Context::quiet())?),
        })
    }
}
