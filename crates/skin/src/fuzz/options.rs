//! Options of fuzz.

use crate::texture::SectionSquare;
use greenstick_wood::stem::Stem;

/// What fuzz is made of and where it ends.
#[derive(Debug, Clone, Copy)]
pub struct FuzzOptions<'a> {
    /// How dense it is, 0 to 1.
    pub amount: f64,
    /// The most triangles it may have.
    pub most_triangles: usize,
    /// Whether the piece was moved off the other: only then is there room for slivers that peel off and for crushed ends that lean.
    pub apart: bool,
    /// Whether the piece lies beyond the break, so that its strands point to the base.
    pub upper: bool,
    /// Material of the wood inside.
    pub material: u32,
    /// The stem.
    pub stem: &'a Stem,
    /// The square of the section that the texture of the wood inside covers.
    pub square: SectionSquare,
    /// Units of the piece's coordinates in a metre.
    pub units_per_metre: f64,
    /// Seed of the break.
    pub seed: u64,
}
