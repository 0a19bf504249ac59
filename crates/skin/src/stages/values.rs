//! The values of the stages of a break.

use super::cracks::Cracks;
use super::species_relief::SpeciesRelief;
use super::whole_stem::WholeStem;
use crate::broken::{BrokenFace, Cutter, FaceLayout, InnerWood};
use crate::cracks::{CrackedFace, OpenedEnd, crack_faces};
use crate::error::BreakError;
use crate::prepared::PreparedStem;
use glam::DVec3;
use greenstick_fracture::cut::CutWorkspace;
use greenstick_fracture::heights::Heights;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use greenstick_fracture::recipe::Recipe;
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::rings::StemRings;
use greenstick_wood::species::UnknownSpecies;
use std::sync::Arc;

/// The least length of whole stem between two breaks, radii.
const MIN_GAP_BETWEEN_BREAKS: f64 = 0.1;

/// The stem of a break.
#[derive(Debug, Clone)]
pub struct StemStage {
    /// The stem as it was found, with the grain that the break requests.
    pub sound: Arc<PreparedStem>,
    /// Its annual rings.
    pub rings: StemRings,
    /// The same stem with cracks in its end, if the break requests them there.
    pub opened: Option<Arc<OpenedEnd>>,
    /// The index of the material of the wood inside.
    pub inner_material: u32,
    /// The stem before any break of the request.
    pub whole: WholeStem,
    /// The parameters of the face of this break: those of the request with a seed of its own, at the size of the stem.
    pub face: BreakParameters,
}

impl StemStage {
    /// Returns the stem that is broken.
    pub fn stem(&self) -> &PreparedStem {
        match &self.opened {
            Some(opened) => &opened.stem,
            None => &self.sound,
        }
    }

    /// Returns how the stem looks with the tissues, species and colours of a recipe.
    ///
    /// # Errors
    /// [`UnknownSpecies`] where the recipe's species has no table.
    pub fn appearance(&self, recipe: &Recipe) -> Result<StemAppearance, UnknownSpecies> {
        let prepared = self.stem();
        let wood = prepared.wood_appearance(recipe)?;
        Ok(StemAppearance::new(
            &prepared.found.stem,
            wood,
            self.rings.clone(),
        ))
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

/// A stem cut along the surface of a break.
#[derive(Debug, Clone)]
pub struct CutStage {
    /// The broken face of both pieces, without cracks.
    pub face: BrokenFace,
    /// The faces of the lower and the upper piece with cracks, if the break requests them there.
    pub cracked: Option<Box<[CrackedFace; 2]>>,
}

impl CutStage {
    /// Cuts a stem with this layout along a surface, whose face has `cracks`, if any. The face shows what `p` asks for.
    ///
    /// # Errors
    /// [`BreakError`] where the stem cannot be cut there, or the caller cancelled.
    pub fn new(
        (stage, layout, p): (&StemStage, &FaceLayout, &BreakParameters),
        surface: &FractureSurface,
        cracks: Option<&Cracks>,
        (workspace, context): (&mut CutWorkspace, &Context),
    ) -> Result<Self, BreakError> {
        let stem = stage.stem();
        let inner = inner_wood(stage, layout, p);
        let cutter = Cutter {
            stem,
            skin: &stem.skin,
            facet_grid: &layout.facet_grid,
            absorb_chips: true,
            context,
        };
        let face = if stem.layers.has_spiral_grain() {
            cutter.break_spiral_grain(surface, &inner, workspace)?
        } else {
            cutter.break_along(surface, &inner, workspace)?
        };
        let cracked = match cracks {
            Some(cracks) => {
                let faces = crack_faces(stem, surface, &cracks.plan, &inner, context)?;
                Some(Box::new(faces))
            }
            None => None,
        };
        Ok(CutStage { face, cracked })
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
}

impl BreakStages {
    /// Returns the lowest point of the face on the axis, m, and the length of stem that a break nearer to the base keeps from it,
    /// m.
    pub fn lowest_point(&self) -> (DVec3, f64) {
        let stem = &self.stem.stem().found.stem;
        let low = stem.location + self.heights.heights.range.0;
        let margin = MIN_GAP_BETWEEN_BREAKS * stem.radius;
        (stem.grain.axis().frame(low).origin, margin)
    }

    /// Returns one piece of the break as a separate mesh, where it broke and without cracks.
    pub fn piece(&self, p: &BreakParameters, upper: bool) -> Mesh {
        let inner = self.inner_wood(p);
        (self.cut.face).piece(&self.stem.stem().source(), &inner, upper)
    }

    /// The same with as few triangles of the skin as there can be: those that were split, as the stem is bent or its grain
    /// spirals, are whole again where the break does not meet them.
    pub(crate) fn piece_put_together(&self, p: &BreakParameters, upper: bool) -> Mesh {
        let inner = self.inner_wood(p);
        (self.cut.face).piece(&self.stem.stem().source_put_together(), &inner, upper)
    }

    /// Returns what the broken face shows.
    pub fn inner_wood<'a>(&'a self, p: &BreakParameters) -> InnerWood<'a> {
        inner_wood(&self.stem, &self.layout, p)
    }
}

/// Returns what the face of a break of this stem and layout shows.
pub fn inner_wood<'a>(
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
