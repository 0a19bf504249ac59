//! Bending tests of species as in ASTM D143 on the fibre model, against the tables that the wood's numbers are from.
//!
//! Modulus of elasticity and modulus of rupture go into the wood, by one rule for all species ([`WoodMaterial::from_species`]): that
//! they come out again checks the model and its numbers. Work to maximum load goes into nothing: there the test predicts.
//!
//! ```
//! use greenstick::bending::{BendRequest, bend};
//! use greenstick::fibre::{BendTest, RodCount};
//! use greenstick::geometry::Context;
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

mod all;
mod files;
mod report;

pub use all::{BendRow, BendTable, END_OF_TABLE, Summary, bend_all};
pub use report::{BendReport, Compared, Failing, Phase};

use greenstick_fibre::{
    BendError, BendOutcome, BendParameters, BendTest, PlacementError, WoodMaterial,
};
use greenstick_fracture::recipe::MOISTURE_WORDS;
use greenstick_geometry::{Cancelled, Context, ErrorKind};
use greenstick_schema::{Unit, number, parameters};
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback, MoistureError, WETTEST_PERCENT};
use greenstick_wood::species::{Property, Species, StrengthError, UnknownSpecies};

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

parameters! {
    /// The parameters of a bending test: the moisture of its wood, the specimen and its model.
    pub struct BendSettings {
        "Wood", "bend" {
            /// Moisture content, percent of the oven-dry mass: 12 is air-dry, 30 and more is green.
            moisture: f64 = AIR_DRY_PERCENT,
                number(Unit::Percent, 0.0, WETTEST_PERCENT).above().words(MOISTURE_WORDS);
        }
    }
    include {
        /// The specimen and its model.
        specimen: BendParameters = BendParameters::default();
    }
}

/// Why a bending test gives nothing.
#[derive(Debug, thiserror::Error)]
pub enum BendingError {
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// A table value is missing.
    #[error(transparent)]
    Moisture(#[from] MoistureError),
    /// Strength along the grain cannot be told.
    #[error(transparent)]
    Strength(#[from] StrengthError),
    /// Specimen or solver.
    #[error(transparent)]
    Test(BendError),
    /// The report could not be put into JSON.
    #[error("the report cannot be put into JSON: {0}")]
    Report(String),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl BendingError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            BendingError::Cancelled(_) => ErrorKind::Cancelled,
            BendingError::Species(_) | BendingError::Moisture(_) | BendingError::Strength(_) => {
                ErrorKind::Request
            }
            BendingError::Test(
                BendError::Value { .. }
                | BendError::TooFine { .. }
                | BendError::Placement(PlacementError::Value { .. } | PlacementError::NoRods { .. }),
            ) => ErrorKind::Request,
            BendingError::Test(_) | BendingError::Report(_) => ErrorKind::Work,
        }
    }
}

impl From<BendError> for BendingError {
    fn from(error: BendError) -> Self {
        match error {
            BendError::Cancelled(stop) => BendingError::Cancelled(stop),
            other => BendingError::Test(other),
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

fn bend_species(
    species: &Species,
    moisture: f64,
    test: &BendTest,
    context: &Context,
) -> Result<Bent, BendingError> {
    // What bending depends on must be known at this moisture; for what only bonds depend on, wood across the grain, the
    // 12 % value is better than none, and the report says so.
    for property in [
        Property::ModulusOfElasticity,
        Property::ModulusOfRupture,
        Property::CompressionParallel,
    ] {
        species.property_at(property, moisture, Fallback::Refuse)?;
    }
    let wood = WoodMaterial::from_species(species, moisture, Fallback::TwelvePercent)?;
    let outcome = test.run(&wood, context)?;
    Ok(Bent {
        report: BendReport::of(species, moisture, test, &outcome),
        outcome,
        test: *test,
    })
}
