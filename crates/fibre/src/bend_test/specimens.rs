//! Bending tests of many specimens of a species, each of wood of its own.
//!
//! ```
//! use greenstick_fibre::bend_test::{SpecimensRequest, bend_specimens};
//! use greenstick_fibre::{BendTest, RodCount};
//! use greenstick_geometry::Context;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let test = BendTest {
//!     rods: RodCount::Number(4),
//!     edge: 0.08, // m; the default is finer
//!     end: 0.95,
//!     ..BendTest::default()
//! };
//! let request = SpecimensRequest { test, ..SpecimensRequest::new("yellow birch", 5) };
//! let report = bend_specimens(&request, &Context::quiet())?;
//! println!("{report}");
//! assert_eq!(report.rows.len(), 5);
//! # Ok(())
//! # }
//! ```

use super::error::BendingError;
use super::flaws::{Flaws, size_factor};
use super::measured::MeasuredSummary;
use super::outcome::BendOutcome;
use super::specimen::{BendSection, BendTest};
use super::specimens_report::{
    ExpectedScatter, SpecimenResult, SpecimenRow, SpecimensReport, SpecimensSummary,
};
use super::variation::WoodDistribution;
use crate::placement::{RodCount, WoodMaterial};
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::noise::hash;
use greenstick_wood::species::Species;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The Weibull modulus of the modulus of rupture of clear, straight-grained wood: that of Douglas-fir beams (Wood Handbook,
/// chapter 9, "Size Effect").
pub const CLEAR_WOOD_WEIBULL_MODULUS: f64 = 18.0;
/// The most specimens of a request: about an hour's work.
pub(super) const MAX_SPECIMENS: u32 = 10_000;
/// Stream of random numbers for the seeds of specimens.
const SPECIMEN_STREAM: u64 = 0x5bec_13e2;

/// Bending tests of specimens of a species.
#[derive(Debug, Clone, PartialEq)]
pub struct SpecimensRequest {
    /// Species, by common or scientific name.
    pub species: String,
    /// Moisture content, percent of the oven-dry mass; 30 and more is green.
    pub moisture: f64,
    /// Number of specimens.
    pub specimens: u32,
    /// Weibull modulus of the modulus of rupture by flaws; infinite for none.
    pub flaws: f64,
    /// Specimen and model. Its seed is that of all specimens; its own scatter must be none.
    pub test: BendTest,
}

impl SpecimensRequest {
    /// The test of ASTM D143 on air-dry specimens of a species, with the flaws of clear wood.
    pub fn new(species: &str, specimens: u32) -> Self {
        SpecimensRequest {
            species: species.to_owned(),
            moisture: AIR_DRY_PERCENT,
            specimens,
            flaws: CLEAR_WOOD_WEIBULL_MODULUS,
            test: BendTest::default(),
        }
    }

    fn check(&self) -> Result<(), BendingError> {
        if !(1..=MAX_SPECIMENS).contains(&self.specimens) {
            return Err(BendingError::Specimens {
                found: self.specimens,
                most: MAX_SPECIMENS,
            });
        }
        if self.flaws.is_nan() || self.flaws < 1.0 {
            return Err(BendingError::Weibull(self.flaws));
        }
        if self.test.weibull.is_finite() {
            return Err(BendingError::TwoScatters);
        }
        Ok(self.test.check()?)
    }
}

/// The specimens of a request, before they are bent.
struct Sample<'a> {
    request: &'a SpecimensRequest,
    species: &'a Species,
    mean: WoodMaterial,
    distribution: WoodDistribution,
}

impl Sample<'_> {
    /// Bends a specimen by its number from 1.
    fn bend(&self, number: u32, context: &Context) -> Result<SpecimenRow, Cancelled> {
        let SpecimensRequest { test, flaws, .. } = self.request;
        let wood = self.mean.scaled(&self.distribution.draw(test.seed, number));
        let seed = hash(test.seed ^ SPECIMEN_STREAM, i64::from(number), 0, 0);
        let flaws = flaws.is_finite().then_some(Flaws {
            modulus: *flaws,
            seed,
        });
        let test = BendTest { seed, ..*test };
        let density_kg_per_m3 = wood.density;
        let outcome = test.run_on((&wood, Some(self.species)), flaws.as_ref(), context);
        let (result, why) = match outcome.map_err(BendingError::from) {
            Ok(outcome) => (Some(result(&outcome)), None),
            Err(BendingError::Cancelled(stop)) => return Err(stop),
            Err(why) => (None, Some(why.to_string())),
        };
        Ok(SpecimenRow {
            specimen: number,
            density_kg_per_m3,
            result,
            not_tested_because: why,
        })
    }
}

fn result(outcome: &BendOutcome) -> SpecimenResult {
    SpecimenResult {
        modulus_of_elasticity_pa: outcome.modulus_of_elasticity,
        modulus_of_rupture_pa: outcome.modulus_of_rupture,
        work_to_maximum_load_j_per_m3: outcome.work_to_maximum_load,
        stress_at_first_break_pa: outcome.stress_at_first_break,
        maximum_load_n: outcome.maximum.load,
        deflection_at_maximum_load_m: outcome.maximum.deflection,
    }
}

/// Bends specimens of a species, each of wood of its own, until they break. The same request gives the same numbers, and the
/// first specimens are the same however many there are.
///
/// # Errors
/// [`BendingError`] where the request is wrong, or the caller stops the work. A specimen that cannot be tested gets a row that
/// says why.
pub fn bend_specimens(
    request: &SpecimensRequest,
    context: &Context,
) -> Result<SpecimensReport, BendingError> {
    request.check()?;
    let species = Species::find(&request.species)?;
    let variation = species.clear_wood_variation()?;
    let sample = Sample {
        request,
        species,
        mean: WoodMaterial::from_species(species, request.moisture, Fallback::Estimate)?,
        distribution: WoodDistribution::new(variation, request.flaws)?,
    };
    let done = AtomicUsize::new(0);
    context.report(0.0)?;
    let rows: Result<Vec<SpecimenRow>, Cancelled> = (1..=request.specimens)
        .into_par_iter()
        .map(|number| {
            let row = sample.bend(number, &context.silenced())?;
            let now = done.fetch_add(1, Ordering::Relaxed) + 1;
            context.report(now as f64 / f64::from(request.specimens))?;
            Ok(row)
        })
        .collect();
    let rows = rows?;
    let test = &request.test;
    let (section, width_m) = match test.section {
        BendSection::Rectangle { width, .. } => ("rectangle", width),
        BendSection::Round { diameter } => ("round", diameter),
    };
    Ok(SpecimensReport {
        schema: "greenstick-bend-specimens",
        version: 1,
        species: species.name.clone(),
        scientific_name: species.scientific_name.clone(),
        source: species.source.clone(),
        moisture_percent: request.moisture,
        section,
        width_m,
        height_m: test.section.height(),
        length_m: test.length,
        span_m: test.span,
        rods: match test.rods {
            RodCount::Number(rods) => Some(rods),
            RodCount::Spacing(_) => None,
        },
        edge_m: test.edge,
        seed: test.seed,
        flaws_weibull_modulus: request.flaws.is_finite().then_some(request.flaws),
        expected: ExpectedScatter::new(variation, size_factor(test, request.flaws)),
        summary: SpecimensSummary::new(&rows),
        measured: None::<MeasuredSummary>,
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Specimens that are quick to bend.
    fn coarse(specimens: u32) -> SpecimensRequest {
        SpecimensRequest {
            test: BendTest {
                rods: RodCount::Number(4),
                edge: 0.08,
                end: 0.95,
                ..BendTest::default()
            },
            ..SpecimensRequest::new("yellow birch", specimens)
        }
    }

    #[test]
    fn the_first_specimens_are_the_same_however_many_there_are() {
        let bend = |request| bend_specimens(&request, &Context::quiet()).unwrap();
        let (few, more) = (bend(coarse(2)), bend(coarse(3)));
        assert_eq!(few.rows[..], more.rows[..2]);
        let mut other = coarse(2);
        other.test.seed = 2;
        assert_ne!(bend(other).rows[0], few.rows[0]);
    }

    #[test]
    fn wrong_requests_are_refused_with_what_would_be_right() {
        let refused = |request: SpecimensRequest| {
            let error = bend_specimens(&request, &Context::quiet()).unwrap_err();
            assert_eq!(error.kind(), greenstick_geometry::ErrorKind::Request);
            error.to_string()
        };
        let request = coarse(1);
        for specimens in [0, MAX_SPECIMENS + 1, 1_000_000_000] {
            let text = refused(SpecimensRequest {
                specimens,
                ..request.clone()
            });
            assert!(text.contains("1 to 10000"), "{text}");
        }
        for flaws in [f64::NAN, 0.5, 5.0] {
            let text = refused(SpecimensRequest {
                flaws,
                ..request.clone()
            });
            assert!(text.contains("Weibull modulus"), "{text}");
        }
        let mut scattered = request.clone();
        scattered.test.weibull = 8.0;
        assert!(refused(scattered).contains("already"));
        let text = refused(SpecimensRequest {
            species: "tree of heaven".to_owned(),
            ..request.clone()
        });
        assert!(text.contains("branches"), "{text}");
        let text = refused(SpecimensRequest {
            species: "birch, yelow".to_owned(),
            ..request
        });
        assert!(text.contains("birch, yelow"), "{text}");
    }
}
