//! Requests: what to break, where and how.

mod file;

pub use file::{RequestFile, RequestFileError};
pub use greenstick_skin::stages::BreakStage;

use greenstick_fracture::height_grid::HeightGrid;
use greenstick_fracture::recipe::{HasRecipe, Recipe};
use greenstick_schema::{Unit, count, flag, length, number, parameters, text};
use greenstick_wood::anatomy::BreakRingParameters;
use greenstick_wood::stem::{LOCATION, StemLocation, StemOptions};

/// Longest distance by which pieces are moved apart, and between breaks, m.
const MAX_DISTANCE: f64 = 1000.0;

parameters! {
    /// A break of a stem.
    pub struct Break {
        "Where", "stem" {
            /// Where to break it: a fraction of the stem's length from its base, 0 to 1, a length from its base, or a point
            /// in the world, which picks the limb that is nearest.
            place as "at": StemLocation = StemLocation::Fraction(0.5), text(LOCATION);
        }
        "What comes out", "finish" {
            /// The most triangles that the pieces together may have beyond those of the stem that is broken. Where they would
            /// have more, the face has fewer rings and sectors, and spiral grain fewer levels.
            triangles: Option<u32> = None, count(1, 1_000_000_000).auto().stage("layout");
            /// Move the pieces apart by this length, along the grain. A piece that hangs on stays where it is.
            separation as "part": f64 = 0.0, length(0.0, MAX_DISTANCE);
            /// Move them farther than that where their splinters would still lie in each other.
            part_clear: bool = true, flag();
            /// Bend thorns and tear some loose: 0 not at all, 1 badly.
            fray: f64 = 0.0, number(Unit::One, 0.0, 1.0);
        }
    }
    include {
        /// How it breaks: species, moisture, parameters of the face and of cracks.
        recipe: Recipe = Recipe::default();
    }
    tables {
        /// Heights of the face that were measured, simulated or painted.
        heights: HeightGrid = HeightGrid::default();
    }
}

impl HasRecipe for Break {
    fn recipe_mut(&mut self) -> &mut Recipe {
        &mut self.recipe
    }
}

/// Everything that determines how a scene is broken.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakRequest {
    /// What is known of the stem.
    pub stem: StemOptions,
    /// Its annual rings.
    pub rings: BreakRingParameters,
    /// The breaks, in any order. Fractions and lengths are those of the unbroken stem; all breaks must be on one stem.
    pub breaks: Vec<Break>,
    /// Where the only break is repeated: at every multiple of this length from the stem's base, m. Its own place then only
    /// says which stem.
    pub every: Option<f64>,
    /// Width of the baked textures, pixels (even); 0 for none.
    pub texture_width: u32,
}

impl Default for BreakRequest {
    fn default() -> Self {
        RequestFile::default().request()
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
