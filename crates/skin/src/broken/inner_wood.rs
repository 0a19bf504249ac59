//! The wood that a broken face shows.

use crate::texture::SectionSquare;
use greenstick_fracture::layout::FibreBundles;
use greenstick_wood::stem::Stem;
use greenstick_wood::tissue::Proportions;

/// The wood that a broken face shows.
#[derive(Clone, Copy)]
pub struct InnerWood<'a> {
    /// The stem that was cut.
    pub stem: &'a Stem,
    /// Its fibre bundles.
    pub bundles: &'a FibreBundles,
    /// Proportions of the tissues.
    pub proportions: Proportions,
    /// Material of the broken face.
    pub material: u32,
    /// The square of the section that the texture covers.
    pub square: SectionSquare,
    /// Whether the surface is smooth across cells.
    pub smooth: bool,
}
