//! The wood inside a break, as pictures show it.

use crate::stages::StemStage;
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::stem::Stem;

/// The wood inside a break.
#[derive(Debug, Clone)]
pub struct BrokenWood {
    /// Its material.
    pub material: u32,
    /// The stem that was broken, placed at the break.
    pub stem: Stem,
    /// The appearance of its wood and bark.
    pub appearance: StemAppearance,
    /// Side of the square that holds the section, m.
    pub width: f64,
}

impl BrokenWood {
    /// Returns the wood of a stem that looks like `appearance`, with the sawn ends that the stem has.
    pub fn new(stage: &StemStage, appearance: StemAppearance) -> Self {
        let prepared = stage.stem();
        BrokenWood {
            material: stage.inner_material,
            stem: prepared.found.stem.clone(),
            appearance: StemAppearance {
                ends: prepared.end_sections().to_vec(),
                ..appearance
            },
            width: prepared.square.side,
        }
    }
}
