//! The first of two passes: a coarse run that finds where the wood breaks, so that the second has short edges there and nowhere else.

use super::error::SimulateError;
use super::run::{SimulateRequest, simulate};
use crate::scene::Scene;
use crate::store::MemoryRun;
use greenstick_geometry::Context;
use std::f64::consts::PI;

/// Diameters of the stem to each side of the break in which edges are short.
const FINE_DIAMETERS: f64 = 3.0;
/// Edges of the coarse run over those of the scene, and rods of the scene over those of the coarse run.
const COARSER_EDGES: f64 = 1.5;
const FEWER_RODS: u32 = 2;
/// Least number of rods of the coarse run.
const MIN_RODS: u32 = 12;

impl Scene {
    /// Returns the scene with longer edges and fewer rods, where it has so many.
    fn coarse(&self) -> Scene {
        let mut coarse = self.clone();
        let rods = &mut coarse.rods;
        rods.number = (rods.number / FEWER_RODS).max(MIN_RODS.min(rods.number));
        rods.spacing = rods.spacing.map(|s| s * f64::from(FEWER_RODS).sqrt());
        rods.edge = rods.edge.map(|edge| COARSER_EDGES * edge);
        rods.fine = None;
        coarse.slow = 1.0;
        coarse
    }
}

/// Finds where wood breaks in a coarse run: the part of the stem (fractions of its length) within three diameters of the median of the
/// places at which its rods broke. `None` where none did.
///
/// # Errors
/// [`SimulateError`] as for the run itself.
pub fn find_break(
    request: &SimulateRequest,
    context: &Context,
) -> Result<Option<[f64; 2]>, SimulateError> {
    let request = SimulateRequest {
        scene: request.scene.coarse(),
        meshes: request.meshes.clone(),
        resume: false,
    };
    let report = simulate(&request, &mut MemoryRun::new(), context)?;
    let place = report.outcome.as_ref().and_then(|outcome| outcome.place_m);
    Ok(place.map(|place| {
        let reach = FINE_DIAMETERS * 2.0 * (report.section_m2 / PI).sqrt();
        [-reach, reach].map(|off| ((place + off) / report.length_m).clamp(0.0, 1.0))
    }))
}
