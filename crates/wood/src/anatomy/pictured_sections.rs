//! The sections of a stem that pictures show.

use super::model::Anatomy;
use super::sections::TransverseSection;
use greenstick_geometry::{Cancelled, Context};

/// A section that is pictured.
#[derive(Debug, Clone, PartialEq)]
pub struct PicturedSection {
    /// Its name, `section_` and its length along the centreline in millimetres.
    pub name: String,
    /// The section.
    pub section: TransverseSection,
}

impl Anatomy<'_> {
    /// Returns the section at the stem's location, and `count` − 1 others at equal distances where sections are whole. Those
    /// that miss the stem or have the name of one before are left out.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn pictured_sections(
        &self,
        count: u32,
        context: &Context,
    ) -> Result<Vec<PicturedSection>, Cancelled> {
        let stem = self.sections();
        let (low, high) = stem.whole;
        let others = count.saturating_sub(1);
        let equidistant = |k: u32| low + (high - low) * (f64::from(k) + 0.5) / f64::from(others);
        let lengths = std::iter::once(stem.stem().location).chain((0..others).map(equidistant));
        let lengths: Vec<f64> = lengths.collect();
        let mut pictured: Vec<PicturedSection> = Vec::new();
        for section in stem.sections_at(&lengths, context)? {
            let name = format!("section_{:06.1}mm", section.length * 1e3);
            if pictured.iter().all(|before| before.name != name) {
                pictured.push(PicturedSection { name, section });
            }
        }
        Ok(pictured)
    }
}
