//! Sawing an end off straight and cracking what is left: for ends that are no sawn faces themselves (Yang 2019 §4 cracks
//! cut faces; a scan ends in a torn or slanted one, a limb in a tip).

use crate::cracks::{CrackedEnd, OF_THE_WAY};
use crate::{Error, Prepared};
use greenstick_fracture::cracks::{CrackError, CrackPlan, Direction, EndFace, Setting, grooves};
use greenstick_fracture::layout;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_fracture::surface::Surface;
use std::sync::Arc;

/// Distance of the saw from the end of what can be cut, in radii, and how much wood must stay beyond the break's place.
const FROM_END: f64 = 0.25;
const LEAST_LEFT: f64 = 1.0;

impl Prepared {
    /// Saws the far end off straight, as near to it as the stem can be cut, and cracks the sawn face. What is sawn off
    /// is thrown away.
    ///
    /// # Errors
    /// [`Error::Crack`] where too little of the stem is left beyond the break's place, [`Error::Cut`] where the mesh is
    /// open or not a manifold there.
    pub(crate) fn saw_and_crack(
        &self,
        p: &BreakParameters,
        plan: &CrackPlan,
        material: u32,
    ) -> Result<CrackedEnd, Error> {
        let stem = &self.found.stem;
        let (low, high) = stem.usable;
        let level = high - FROM_END * stem.radius;
        if level - stem.location < LEAST_LEFT * stem.radius {
            return Err(CrackError::TooShort {
                left: high - stem.location,
                needed: (FROM_END + LEAST_LEFT) * stem.radius,
            }
            .into());
        }
        let bundles = layout::smooth(&stem.rings, &self.end_layout(p));
        let flat = Surface {
            heights: vec![[level; 3]; bundles.layout.facets.len()],
            layout: Arc::clone(&bundles.layout),
        };
        let setting = Setting {
            radius: stem.radius,
            usable: (
                low.max(stem.location + OF_THE_WAY * (level - stem.location)),
                high,
            ),
            level: f64::INFINITY,
        };
        let plan = self.fitted(plan);
        let face = grooves(&plan, &stem.rings, &flat, Direction::Down, &setting)?;
        let level_cut = grooves(
            &CrackPlan::default(),
            &stem.rings,
            &flat,
            Direction::Down,
            &setting,
        )?;
        let proportions = p.proportions();
        let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
        let (whole, _) = self.cut_along(&level_cut, &bundles, &zone, material, (false, true))?;
        let (cracked, _) = self.cut_along(&face, &bundles, &zone, material, (false, true))?;
        let void = whole.volume() - cracked.volume();
        Ok(CrackedEnd {
            stem: cracked,
            end: EndFace::level(level),
            face,
            void,
        })
    }
}
