//! The face of a fracture: its heights over the section, and the parameters of the relief that is finer than rods.

use super::fractures::SimulatedFracture;
use super::observed::ObservedRun;
use super::report::SimulatedFaceReport;
use super::section_field::{FracturedSection, SectionRod};
use crate::rods::Wood;
use glam::{DVec2, DVec3};
use greenstick_fracture::heights::{FailureMode, HeightField, HeightFieldError};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_wood::stem::{Stem, StemLocation};

/// Fractions of a stem's length are rounded to one over this.
const FRACTION_STEPS: f64 = 1e4;
/// Least number of slivers, and how many there are for each rod: rods are coarser than what tears, slivers are finer.
const SLIVERS: u32 = 130;
const SLIVERS_PER_ROD: f64 = 2.0;
/// Most slivers.
const MAX_SLIVERS: u32 = 2000;
/// Length of splinters over the heights by which neighbouring rods differ. Their own breaks are in the field already.
const SPLINTERS_PER_SCATTER: f64 = 0.8;
/// Least and greatest length of splinters where the wood is most torn, radii.
const SPLINTER_RANGE: (f64, f64) = (0.1, 4.0);
/// Greatest length of splinters over the length of stem that is free for the face.
const FREE_SHARE: f64 = 0.2;
/// Least and greatest factor on the relief of a place over that of the face.
const LOCAL_RANGE: (f64, f64) = (0.15, 3.0);
/// Factors on the lengths of splinters where the wood was crushed: kinked fibres pull out next to not at all.
const CRUSHED: f64 = 0.3;
const CRUSHED_SCATTER: f64 = 0.6;

/// The face of a fracture at a location of a stem.
#[derive(Debug, Clone)]
pub struct SimulatedFace {
    /// Heights over the location, and how the wood failed.
    pub field: HeightField,
    /// The parameters of the relief that is finer than the field.
    pub parameters: BreakParameters,
    /// What it was made from.
    pub report: SimulatedFaceReport,
}

impl SimulatedFracture {
    /// The length along the axis of the run's stem, m, midway between the lowest and the highest break: from there a face
    /// has the most room on the stem.
    pub fn length_along(&self) -> f64 {
        let lengths = || self.broken().map(|b| b.along);
        let low = lengths().fold(f64::INFINITY, f64::min);
        let high = lengths().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (low + high)
    }

    /// Returns where on the run's stem that is: a point of the axis, or a fraction of the length.
    pub fn location(&self, wood: &Wood, by_point: bool) -> StemLocation {
        let (stem, along) = (wood.stem, self.length_along());
        if by_point {
            return StemLocation::Point(stem.grain.axis().frame(along).origin);
        }
        let fraction = (along / stem.length * FRACTION_STEPS).round() / FRACTION_STEPS;
        StemLocation::Fraction(fraction.clamp(0.0, 1.0))
    }

    /// Returns the face at `location`, where the stem is `stem`; `to_grain` leads from the world to the stem's grain
    /// coordinates, m. `seed` is that of the relief.
    ///
    /// # Errors
    /// [`HeightFieldError`] where the section of the stem is not finite.
    pub fn face(
        &self,
        (wood, run): (&Wood, &ObservedRun),
        location: &StemLocation,
        stem: &Stem,
        to_grain: &dyn Fn(DVec3) -> DVec3,
        seed: u64,
    ) -> Result<SimulatedFace, HeightFieldError> {
        let section = FracturedSection::new(wood, &run.state, self, stem, to_grain);
        let (parameters, splintering) = relief(wood, stem, &section.rods, seed);
        let field = section.field(&splintering)?;
        let report = SimulatedFaceReport::new(
            self,
            &section.rods,
            (stem, location),
            parameters.sliver_height,
        );
        Ok(SimulatedFace {
            field,
            parameters,
            report,
        })
    }
}

/// The parameters of the relief, and for each rod the factor on it.
///
/// Splinters are as long as neighbouring rods differ, and no shorter than bundles of a rod's width pull out by shear lag: how far wider
/// ones did, the rods say. Where the wood was crushed splinters are short.
fn relief(wood: &Wood, stem: &Stem, rods: &[SectionRod], seed: u64) -> (BreakParameters, Vec<f64>) {
    let slivers = (SLIVERS_PER_ROD * rods.len() as f64) as u32;
    let slivers = slivers.clamp(SLIVERS, MAX_SLIVERS);
    let area: f64 = rods.iter().map(|r| r.area).sum();
    let pulled_out = wood.pull_out * (area / rods.len() as f64).sqrt();
    let length = |rod: &SectionRod| {
        let scattered = SPLINTERS_PER_SCATTER * rod.scatter;
        match rod.mode {
            FailureMode::Crushed => (CRUSHED_SCATTER * scattered).max(CRUSHED * pulled_out),
            FailureMode::Unbroken => 0.0,
            _ => scattered.max(pulled_out),
        }
    };
    let (mut sum, mut torn_area) = (0.0, 0.0);
    let mut toward = DVec2::ZERO;
    let middle: DVec2 = rods.iter().map(|r| r.at * r.area).sum::<DVec2>() / area;
    for rod in rods {
        if !matches!(rod.mode, FailureMode::Crushed | FailureMode::Unbroken) {
            sum += length(rod) * rod.area;
            torn_area += rod.area;
            toward += (rod.at - middle) * rod.area;
        }
    }
    let mean = if torn_area > 0.0 {
        sum / torn_area
    } else {
        pulled_out
    };
    let free = FREE_SHARE * (stem.usable.1 - stem.usable.0) / stem.radius;
    let splinters = (mean / stem.radius)
        .clamp(SPLINTER_RANGE.0, SPLINTER_RANGE.1)
        .min(free);
    let factor = |rod: &SectionRod| (length(rod) / mean).clamp(LOCAL_RANGE.0, LOCAL_RANGE.1);
    let mut p = BreakParameters {
        seed,
        // Rods have their size.
        size_effect: 0.0,
        sectors: 110,
        sliver_count: slivers,
        slab_count: 9,
        // Slabs are in the field.
        slab_height: 0.3 * splinters,
        sliver_height: splinters,
        bundle_aspect: 5.0,
        fibre_height: (0.08 * splinters).clamp(0.03, 0.16),
        step_height: 0.1 * splinters,
        compression_height: 0.07,
        bark_offset: 0.05,
        bark_height: (0.5 * splinters).clamp(0.08, 0.9),
        ..BreakParameters::default()
    };
    p.ductile.direction = libm::atan2(toward.y, toward.x)
        .to_degrees()
        .rem_euclid(360.0);
    p.ductile.angle = 360.0;
    p.ductile.rings = 1.0;
    p.ductile.thorn_length = 1.1 * splinters;
    p.ductile.thorn_probability = 0.03;
    (p, rods.iter().map(factor).collect())
}
