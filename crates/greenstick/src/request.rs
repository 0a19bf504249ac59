//! What is to be broken, where and how.

use greenstick_fracture::heights::HeightSource;
use greenstick_fracture::recipe::Recipe;
use greenstick_wood::stem::{StemLocation, StemOptions};

/// A break of a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Break {
    /// Where.
    pub place: StemLocation,
    /// How: species, moisture, parameters of the face and of cracks.
    pub recipe: Recipe,
    /// Where the heights of the face come from.
    pub heights: HeightSource,
    /// How far what lies beyond the break is moved away, m.
    pub separation: f64,
    /// How much thorns are bent and splinters come loose, 0 (not at all) to 1.
    pub fray: f64,
}

impl Default for Break {
    fn default() -> Self {
        Break {
            place: StemLocation::Fraction(0.5),
            recipe: Recipe::default(),
            heights: HeightSource::default(),
            separation: 0.0,
            fray: 0.0,
        }
    }
}

/// Everything that decides how a scene is broken.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakRequest {
    /// What is known of the stem.
    pub stem: StemOptions,
    /// The breaks, in any order. Fractions and lengths are those of the unbroken stem; all breaks must be on one stem.
    pub breaks: Vec<Break>,
    /// Width of the baked textures, pixels (even; half as high).
    pub texture_width: u32,
}

impl Default for BreakRequest {
    fn default() -> Self {
        BreakRequest {
            stem: StemOptions::default(),
            breaks: vec![Break::default()],
            texture_width: 2048,
        }
    }
}

impl BreakRequest {
    /// A request for a single break, all else as by default.
    pub fn single(only: Break) -> Self {
        BreakRequest {
            breaks: vec![only],
            ..BreakRequest::default()
        }
    }
}

/// The stages of a break, in the order in which each is made from the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BreakStage {
    /// The scene that is broken.
    Input,
    /// The stem in it, brought to grain space.
    Stem,
    /// The fibre bundles of the section.
    Layout,
    /// The heights of the fracture surface.
    Heights,
    /// The stem cut along it: what is drawn.
    Cut,
    /// Pieces as meshes of their own, and the scene with its materials and textures: what files hold.
    Finish,
}

impl BreakStage {
    /// All stages in their order.
    pub const ALL: [BreakStage; 6] = [
        BreakStage::Input,
        BreakStage::Stem,
        BreakStage::Layout,
        BreakStage::Heights,
        BreakStage::Cut,
        BreakStage::Finish,
    ];

    /// The stage's name, as progress and tables show it.
    pub const fn name(self) -> &'static str {
        match self {
            BreakStage::Input => "input",
            BreakStage::Stem => "stem",
            BreakStage::Layout => "layout",
            BreakStage::Heights => "heights",
            BreakStage::Cut => "cut",
            BreakStage::Finish => "finish",
        }
    }
}
