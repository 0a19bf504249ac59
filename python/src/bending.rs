//! Bending tests of species.

use crate::convert::report;
use crate::failure::Failure;
use crate::values::each;
use crate::work;
use greenstick::bending::{
    BendRequest, BendSettings, BendingError, SpecimensRequest, bend, bend_specimens,
};
use greenstick::schema::Parameters;
use pyo3::prelude::*;
use pyo3::types::PyDict;

impl From<BendingError> for Failure {
    fn from(error: BendingError) -> Self {
        let class = match &error {
            BendingError::Species(_) => "SpeciesError",
            BendingError::Moisture(_) => "MoistureError",
            _ => "BendingError",
        };
        Failure::new(class, error.kind(), error)
    }
}

/// Bends clear wood of a species over two supports as ASTM D143 does, until it breaks, and returns the report of the program's
/// `bend-test --json`: modulus of elasticity and of rupture (Pa) and work to maximum load (J/m³) beside the tables' values.
///
/// Keys are those of the test: `moisture=30`, `span="36 cm"`, `height="2.5 cm"`. With `specimens=50` many are bent, which scatter
/// as clear wood does.
#[pyfunction]
#[pyo3(signature = (species, settings=None, *, progress=None, **keys))]
pub fn bend_test<'py>(
    py: Python<'py>,
    species: String,
    settings: Option<&Bound<'py, PyDict>>,
    progress: Option<&Bound<'py, PyAny>>,
    keys: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut asked = BendSettings::default();
    each([settings, keys], |key, value| Ok(asked.set(key, value)?))?;
    asked.check().map_err(Failure::from)?;
    let test = asked.test();
    let moisture = asked.moisture;
    match asked.specimens {
        None => {
            let request = BendRequest {
                species,
                moisture,
                test,
            };
            let bent = work::run(py, progress, |context| Ok(bend(&request, context)?))?;
            report(py, &bent.report)
        }
        Some(specimens) => {
            let request = SpecimensRequest {
                species,
                moisture,
                specimens,
                flaws: asked.flaws,
                test,
            };
            let bent = work::run(py, progress, |context| {
                Ok(bend_specimens(&request, context)?)
            })?;
            report(py, &bent)
        }
    }
}
