//! Cracks in the two faces of a break.

use crate::broken::{BrokenFace, Cutter, InnerWood};
use crate::error::BreakError;
use crate::prepared::PreparedStem;
use glam::DVec2;
use greenstick_fracture::cracks::{
    CrackPlan, CrackSite, Direction, GroovedSurface, PlannedCrack, grooves,
};
use greenstick_fracture::cut::{CutWorkspace, FacetGrid, Skin};
use greenstick_fracture::layout::FibreBundles;
use greenstick_fracture::parameters::CrackKind;
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::{Context, Mesh};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A face with cracks.
#[derive(Debug, Clone)]
pub struct CrackedFace {
    /// The stem cut along it.
    pub face: BrokenFace,
    /// The surface that was cut along, what was made and what was limited.
    pub grooves: GroovedSurface,
    /// Fibre bundles of the face, those of the walls of the cracks among them.
    pub bundles: Arc<FibreBundles>,
}

/// Cuts a stem along `surface` with the cracks of `plan` in both faces: the lower piece's face, then the upper piece's.
///
/// # Errors
/// [`BreakError::Crack`] where cracks cannot be drawn into the face, [`BreakError::Cut`] as for the break itself, and
/// [`BreakError::Cancelled`].
pub fn crack_faces(
    stem: &PreparedStem,
    surface: &FractureSurface,
    plan: &CrackPlan,
    inner: &InnerWood,
    context: &Context,
) -> Result<[CrackedFace; 2], BreakError> {
    let found = &stem.found.stem;
    let site = CrackSite {
        radius: found.radius,
        usable: found.usable,
        level: f64::INFINITY,
    };
    let plan = fit_to_section(stem, plan);
    let face = |direction| {
        let made = grooves(&plan, &found.rings, surface, direction, &site, context)?;
        cut_along((stem, inner), made, true, context)
    };
    Ok([face(Direction::Down)?, face(Direction::Up)?])
}

impl CrackedFace {
    /// The piece that has this face as a mesh of its own. `inner` is that of the face without cracks.
    pub fn piece(&self, stem: &PreparedStem, inner: &InnerWood, upper: bool) -> Mesh {
        let inner = InnerWood {
            bundles: &self.bundles,
            ..*inner
        };
        self.face.piece(&stem.source(), &inner, upper)
    }
}

/// Returns a plan with the rings and angles of the section: a board without its pith has only an arc of each ring, and none
/// of the inner ones.
pub(super) fn fit_to_section(stem: &PreparedStem, plan: &CrackPlan) -> CrackPlan {
    let Some((from, to)) = stem.extent.arc else {
        return plan.clone();
    };
    let (turn, inner) = ((to - from) / TAU, stem.extent.reach.0);
    let fit = |crack: &PlannedCrack| {
        let mut crack = crack.clone();
        let first = crack.course.first().map_or(0.0, |c| c.1);
        let start = from + (first / TAU).rem_euclid(1.0) * (to - from);
        for (rho, phi) in &mut crack.course {
            *rho = inner + *rho * (1.0 - inner);
            *phi = start + (*phi - first) * turn;
        }
        crack.range *= match crack.kind {
            CrackKind::Radial => turn,
            CrackKind::Tangential => 1.0 - inner,
        };
        crack
    };
    CrackPlan {
        cracks: plan.cracks.iter().map(fit).collect(),
        ..plan.clone()
    }
}

/// Cuts the stem along a surface with grooves. `absorb_chips` as in [`Cutter`].
pub(super) fn cut_along(
    (stem, inner): (&PreparedStem, &InnerWood),
    grooves: GroovedSurface,
    absorb_chips: bool,
    context: &Context,
) -> Result<CrackedFace, BreakError> {
    let (low, high) = grooves.surface.range();
    let skin = Skin::new(&stem.solid(), (low, high));
    let facet_grid = FacetGrid::new(&skin, &grooves.surface.layout);
    let mut bundles = inner.bundles.clone();
    let new = &grooves.surface.layout.nodes[grooves.first_node..];
    let rings = &stem.found.stem.rings;
    bundles
        .addresses
        .extend(new.iter().map(|&p: &DVec2| rings.address(p)));
    bundles.layout = Arc::clone(&grooves.surface.layout);
    let cutter = Cutter {
        stem,
        skin: &skin,
        facet_grid: &facet_grid,
        absorb_chips,
        context,
    };
    let inner = InnerWood {
        bundles: &bundles,
        ..*inner
    };
    let face = cutter.break_along(&grooves.surface, &inner, &mut CutWorkspace::default())?;
    Ok(CrackedFace {
        face,
        grooves,
        bundles: Arc::new(bundles),
    })
}
