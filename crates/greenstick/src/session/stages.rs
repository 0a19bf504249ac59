//! The values of the stages of a break.

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
use greenstick_wood::stem::StemKind;
use std::sync::Arc;

/// The stem of a break.
#[derive(Debug, Clone)]
pub struct StemStage {
    /// The stem as it was found, with the grain that the break requests.
    pub sound: Arc<PreparedStem>,
    /// The same stem with cracks in its end, if the break requests them there.
    pub opened: Option<Arc<OpenedEnd>>,
    /// The index of the material of the wood inside.
    pub inner_material: u32,
    /// Unique number of this stem in the session.
    pub(super) id: u64,
}

impl StemStage {
    /// Returns the stem that is broken.
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
    /// The surface, and how it was limited to the stem.
    pub heights: Heights,
    /// The effect of the species.
    pub relief: SpeciesRelief,
}

/// The effect of a species on the relief of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesRelief {
    /// Factor on the torn relief.
    pub factor: f64,
    /// Where the factor comes from, if a species is named and has the values.
    pub report: Option<SpeciesReport>,
    /// Why the factor is 1 although a species is named.
    pub note: Option<BreakNote>,
}

/// A stem cut along the surface of a break.
#[derive(Debug, Clone)]
pub struct CutStage {
    /// The broken face of both pieces, without cracks.
    pub face: BrokenFace,
    /// The faces of the lower and the upper piece with cracks, if the break requests them there.
    pub cracked: Option<Box<[CrackedFace; 2]>>,
}

/// The cracks of a break, planned for a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Cracks {
    /// Where they run.
    pub plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// The shrinkage that opens them.
    pub shrinkage: CrackShrinkage,
    /// The number of tangential cracks that were moved to a ring boundary.
    pub moved: usize,
}

impl Cracks {
    /// Plans the cracks of a recipe, if it has any.
    pub(super) fn plan(recipe: &Recipe) -> Result<Option<Cracks>, Error> {
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
    /// The cracks, if any.
    pub cracks: Option<Cracks>,
    /// The stem cut along the heights.
    pub cut: Arc<CutStage>,
    /// Unique number of the cut in the session.
    pub(super) cut_id: u64,
}

impl BreakStages {
    /// Returns one piece of the break as a separate mesh, where it broke and without cracks.
    pub fn piece(&self, p: &BreakParameters, upper: bool) -> Mesh {
        let inner = self.inner_wood(p);
        (self.cut.face).piece(&self.stem.stem().source(), &inner, upper)
    }

    /// Returns what the broken face shows.
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

/// Whether a break requests spiral grain and the stem can have it: a fibrous face of a round stem.
pub(super) fn has_spiral_grain(stem: &PreparedStem, p: &BreakParameters) -> bool {
    let round = stem.found.stem.kind != StemKind::Board;
    p.spiral_angle != 0.0 && p.surface == SurfaceStyle::Fibrous && round
}
