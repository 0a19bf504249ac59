//! Fracture tests of species.
//!
//! ```
//! use greenstick_fibre::fracture_test::{FractureRequest, FractureTest, fracture};
//! use greenstick_geometry::Context;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let test = FractureTest {
//!     spacing: 0.005, // m; the default is finer
//!     growth: 0.03,
//!     ..FractureTest::default()
//! };
//! let request = FractureRequest { test, ..FractureRequest::new("Norway spruce") };
//! let tested = fracture(&request, &Context::quiet())?;
//! println!("{}", tested.report);
//! assert!((tested.report.by_work.ratio - 1.0).abs() < 0.1);
//! # Ok(())
//! # }
//! ```

use super::error::FractureError;
use super::outcome::FractureOutcome;
use super::report::FractureReport;
use super::specimen::FractureTest;
use super::theory::BeamTheory;
use crate::placement::WoodMaterial;
use greenstick_geometry::Context;
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::species::Species;

/// A fracture test of a species.
#[derive(Debug, Clone, PartialEq)]
pub struct FractureRequest {
    /// Species, by common or scientific name.
    pub species: String,
    /// Moisture content, percent of the oven-dry mass; 30 and more is green.
    pub moisture: f64,
    /// Specimen and model.
    pub test: FractureTest,
}

impl FractureRequest {
    /// Returns the test of a double cantilever beam of air-dry wood of a species.
    pub fn new(species: &str) -> Self {
        FractureRequest {
            species: species.to_owned(),
            moisture: AIR_DRY_PERCENT,
            test: FractureTest::default(),
        }
    }
}

/// A fracture test that was done.
#[derive(Debug, Clone, PartialEq)]
pub struct FractureTested {
    /// Its numbers beside what went in.
    pub report: FractureReport,
    /// Every point.
    pub outcome: FractureOutcome,
    /// The test.
    pub test: FractureTest,
    pub(super) theory: BeamTheory,
}

/// Tests how tough a species is along the grain.
///
/// # Errors
/// [`FractureError`].
pub fn fracture(
    request: &FractureRequest,
    context: &Context,
) -> Result<FractureTested, FractureError> {
    let species = Species::find(&request.species)?;
    let wood = WoodMaterial::from_species(species, request.moisture, Fallback::Estimate)?;
    let test = request.test;
    let outcome = test.run(&wood, context)?;
    let theory = BeamTheory::new(&test, &wood);
    Ok(FractureTested {
        report: FractureReport::new(species, request.moisture, &test, &theory, &outcome),
        outcome,
        test,
        theory,
    })
}
