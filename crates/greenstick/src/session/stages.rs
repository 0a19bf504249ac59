//! What the stages of a break are made of.

use super::notes::BreakNote;
use crate::Error;
use crate::report::SpeciesReport;
use greenstick_fracture::cracks::{CrackPlan, plan};
use greenstick_fracture::heights::Heights;
use greenstick_fracture::parameters::{BreakParameters, CrackEnd, SurfaceStyle};
use greenstick_fracture::recipe::{CrackShrinkage, Recipe};
use greenstick_geometry::Mesh;
use greenstick_skin::broken::{BrokenFace, FaceLayout, InnerWood};
use greenstick_skin::cracks::{CrackedFace, OpenedEnd};
use greenstick_skin::prepared::PreparedStem;
use std::sync::Arc;

/// The stem of a break.
#[derive(Debug, Clone)]
pub struct StemStage {
    /// The stem as it was found, with the grain that the break asks for.
    pub sound: Arc<PreparedStem>,
    /// The same with cracks in its end, where the break asks for them there.
    pub opened: Option<Arc<OpenedEnd>>,
    /// Material of the wood inside.
    pub inner_material: u32,
    /// Number of the stem that is broken, which no other of the session has.
    pub(super) id: u64,
}

impl StemStage {
    /// The stem that is broken.
    pub fn stem(&self) -> &PreparedStem {
        match &self.opened {
            Some(opened) => &opened.stem,
            None => &self.sound,
        }
    }
}

/// The heights of a break.
#[derive(Debug, Clone)]
pub struct HeightStage {
    /// The surface, and what was done to fit it in.
    pub heights: Heights,
    /// What the species did.
    pub relief: SpeciesRelief,
}

/// What a species does to the relief of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesRelief {
    /// Factor on the torn relief.
    pub factor: f64,
    /// Where the factor comes from, where a species is named and has the values.
    pub report: Option<SpeciesReport>,
    /// Why it is 1 although a species is named.
    pub note: Option<BreakNote>,
}

/// A stem cut along the surface of a break.
#[derive(Debug, Clone)]
pub struct CutStage {
    /// The broken face of both pieces, without cracks.
    pub face: BrokenFace,
    /// The faces of the lower and the upper piece with cracks, where the break asks for them there.
    pub cracked: Option<Box<[CrackedFace; 2]>>,
}

/// The cracks of a break, drawn for a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Cracks {
    /// The cracks.
    pub plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// The shrinkage that they open by.
    pub shrinkage: CrackShrinkage,
    /// How many tangential cracks were moved to a ring boundary.
    pub moved: usize,
}

impl Cracks {
    /// The cracks that a recipe asks for, if any.
    pub(super) fn plan(recipe: &Recipe) -> Result<Option<Cracks>, Error> {
        if recipe.cracks.is_empty() {
            return Ok(None);
        }
        let shrinkage = recipe.crack_shrinkage()?;
        let mut asked = recipe.cracks.clone();
        let moved = asked.follow_rings(recipe.face.rings);
        Ok(Some(Cracks {
            plan: plan(
                &asked,
                (shrinkage.tangential, shrinkage.radial),
                recipe.face.seed,
            ),
            sawn: recipe.cracks.settings.end == CrackEnd::Sawn,
            shrinkage,
            moved,
        }))
    }
}

/// All stages of one break up to the cut.
#[derive(Debug, Clone)]
pub struct BreakStages {
    /// The stem.
    pub stem: StemStage,
    /// The layout of its section.
    pub layout: Arc<FaceLayout>,
    /// The heights of its face.
    pub heights: Arc<HeightStage>,
    /// The cracks.
    pub cracks: Option<Cracks>,
    /// The stem cut along them.
    pub cut: Arc<CutStage>,
    /// Number of the cut, which no other of the session has.
    pub(super) cut_id: u64,
}

impl BreakStages {
    /// One piece of the break as a mesh of its own, without cracks and as it broke.
    pub fn piece(&self, p: &BreakParameters, upper: bool) -> Mesh {
        let inner = self.inner_wood(p);
        (self.cut.face).piece(&self.stem.stem().source(), &inner, upper)
    }

    /// What the broken face shows.
    pub fn inner_wood<'a>(&'a self, p: &BreakParameters) -> InnerWood<'a> {
        inner_wood(&self.stem, &self.layout, p)
    }
}

pub(super) fn inner_wood<'a>(
    stage: &'a StemStage,
    layout: &'a FaceLayout,
    p: &BreakParameters,
) -> InnerWood<'a> {
    let stem = stage.stem();
    InnerWood {
        stem: &stem.found.stem,
        bundles: &layout.bundles,
        proportions: p.proportions(),
        material: stage.inner_material,
        square: stem.square,
        smooth: p.surface == SurfaceStyle::Smooth,
    }
}
