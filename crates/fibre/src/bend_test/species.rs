//! Bending tests of species as in ASTM D143 on the fibre model, against the tables that the wood's numbers are from.
//!
//! Modulus of elasticity and modulus of rupture go into the wood, by one rule for all species ([`WoodMaterial::from_species`]): that
//! they come out again checks the model and its numbers. Work to maximum load goes into nothing: there the test predicts.
//!
//! ```
//! use greenstick_fibre::bend_test::{BendRequest, bend};
//! use greenstick_fibre::{BendTest, RodCount};
//! use greenstick_geometry::Context;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let test = BendTest {
//!     rods: RodCount::Number(9),
//!     edge: 0.05, // m; the default is finer
//!     ..BendTest::default()
//! };
//! let request = BendRequest { test, ..BendRequest::of("white oak") };
//! let bent = bend(&request, &Context::quiet())?;
//! println!("{}", bent.report);
//! assert_eq!(bent.report.species, "Oak, white");
//! let ratio = bent.report.modulus_of_elasticity_pa.ratio.unwrap();
//! assert!((ratio - 1.0).abs() < 0.05);
//! # Ok(())
//! # }
//! ```

use super::error::BendingError;
use super::grain::SlopedGrain;
use super::outcome::BendOutcome;
use super::report::BendReport;
use super::specimen::BendTest;
use crate::placement::WoodMaterial;
use greenstick_geometry::Context;
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::species::Species;

/// A bending test of a species.
#[derive(Debug, Clone, PartialEq)]
pub struct BendRequest {
    /// Species, by common or scientific name.
    pub species: String,
    /// Moisture content, percent of the oven-dry mass; 30 and more is green.
    pub moisture: f64,
    /// Specimen and model.
    pub test: BendTest,
}

impl BendRequest {
    /// The test of ASTM D143 on air-dry wood of a species.
    pub fn of(species: &str) -> Self {
        BendRequest {
            species: species.to_owned(),
            moisture: AIR_DRY_PERCENT,
            test: BendTest::default(),
        }
    }
}

/// A bending test that was done.
#[derive(Debug, Clone, PartialEq)]
pub struct Bent {
    /// Its numbers beside the table's.
    pub report: BendReport,
    /// Every point and event.
    pub outcome: BendOutcome,
    /// The test.
    pub test: BendTest,
}

/// Bends a species until it breaks.
///
/// # Errors
/// [`BendingError`].
pub fn bend(request: &BendRequest, context: &Context) -> Result<Bent, BendingError> {
    let species = Species::find(&request.species)?;
    bend_species(species, request.moisture, &request.test, context)
}

pub(super) fn bend_species(
    species: &Species,
    moisture: f64,
    test: &BendTest,
    context: &Context,
) -> Result<Bent, BendingError> {
    let wood = WoodMaterial::from_species(species, moisture, Fallback::Estimate)?;
    let outcome = test.run_on((&wood, Some(species)), None, context)?;
    let mut report = BendReport::of(species, moisture, test, &outcome);
    let moduli = [
        report.modulus_of_elasticity_pa.table,
        report.modulus_of_rupture_pa.table,
    ];
    if let [Some(elasticity), Some(rupture)] = moduli {
        report.sloped_grain = SlopedGrain::expected(test, &wood, [elasticity, rupture]);
        report
            .notes
            .extend(report.sloped_grain.map(|g| g.to_string()));
    }
    Ok(Bent {
        report,
        outcome,
        test: *test,
    })
}
