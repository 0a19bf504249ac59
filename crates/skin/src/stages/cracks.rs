//! The cracks of a break, planned for a stem.

use greenstick_fracture::cracks::{CrackPlan, plan};
use greenstick_fracture::parameters::{CrackEnd, CrackParameters};
use greenstick_fracture::recipe::{CrackShrinkage, Recipe, ShrinkageError};

/// The cracks of a break, planned for a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Cracks {
    /// Where they run.
    pub plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// Whether that end is the one at the tip, not that at the base.
    pub far: bool,
    /// The shrinkage that opens them.
    pub shrinkage: CrackShrinkage,
    /// The number of tangential cracks that were moved to a ring boundary.
    pub moved: usize,
}

/// Everything of a recipe that determines the cracks of a break.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackRequest {
    cracks: CrackParameters,
    species: Option<String>,
    moisture: Option<f64>,
    rings: u32,
    seed: u64,
}

impl CrackRequest {
    /// Returns what a recipe says of them.
    pub fn new(recipe: &Recipe) -> Self {
        CrackRequest {
            cracks: recipe.cracks.clone(),
            species: recipe.species.clone(),
            moisture: recipe.moisture,
            rings: recipe.face.rings,
            seed: recipe.face.seed,
        }
    }
}

impl Cracks {
    /// Plans the cracks of a recipe, if it has any.
    ///
    /// # Errors
    /// [`ShrinkageError`] where the shrinkage of the recipe's wood is not known.
    pub fn plan(recipe: &Recipe) -> Result<Option<Cracks>, ShrinkageError> {
        if recipe.cracks.is_empty() {
            return Ok(None);
        }
        let shrinkage = recipe.crack_shrinkage()?;
        let mut parameters = recipe.cracks.clone();
        let moved = parameters.follow_rings(recipe.face.rings);
        Ok(Some(Cracks {
            plan: plan(
                &parameters,
                (shrinkage.tangential, shrinkage.radial),
                recipe.face.seed,
            ),
            sawn: recipe.cracks.settings.end != CrackEnd::Break,
            far: recipe.cracks.settings.end != CrackEnd::Base,
            shrinkage,
            moved,
        }))
    }

    /// Where they run, and whether in the far end.
    pub fn at_end(&self) -> (&CrackPlan, bool) {
        (&self.plan, self.far)
    }
}
