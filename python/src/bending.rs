//! Bending tests of species.

use crate::convert::{Reduced, encoded_files, report, write_files};
use crate::failure::Failure;
use crate::values::each;
use crate::work;
use greenstick::bending::{
    BendRequest, BendSettings, BendingError, END_AT_MAXIMUM, SpecimensRequest, bend, bend_all,
    bend_specimens, bend_table_files, bend_test_files, specimens_files,
};
use greenstick::formats::Encoded;
use greenstick::geometry::Context;
use greenstick::provenance;
use greenstick::schema::Parameters;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value as Json;
use std::path::PathBuf;

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

/// Charts of tests, as files.
const CHARTS: [&str; 2] = ["load-deflection.png", "scatter.png"];

/// A bending test: its numbers, and tables and charts as files in memory.
#[pyclass(module = "greenstick", frozen)]
pub struct BendTest {
    /// The report as the program prints it with `--json`: modulus of elasticity and of rupture (Pa) and work to maximum load
    /// (J/m³) beside the tables' values. Names end with the unit.
    #[pyo3(get)]
    report: Py<PyAny>,
    /// Names of files and their bytes, those that the program writes.
    #[pyo3(get)]
    files: Py<PyDict>,
}

#[pymethods]
impl BendTest {
    /// A table as a dictionary of arrays of shape (n,), whose names end with the unit: "load-deflection" (a row for each
    /// equilibrium) and "events" of one test, "specimens" of many, "species" of all. Copies.
    fn arrays<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let arrays = py.import("greenstick._arrays")?;
        arrays.call_method1("columns", (self.files.bind(py), name))
    }

    /// Writes all files into a folder, all or none.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        write_files(self.files.bind(py), &folder)
    }

    /// The chart, where the test has one.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let files = self.files.bind(py);
        let charts: PyResult<Vec<_>> = CHARTS.iter().map(|name| files.get_item(name)).collect();
        Ok(charts?.into_iter().flatten().next())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.report.bind(py).cast::<PyDict>()?;
        let species = report.get_item("species")?;
        Ok(format!(
            "<greenstick.BendTest {}>",
            species.map_or("all species".to_owned(), |name| name.to_string())
        ))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<'py, (Py<PyAny>, Py<PyDict>)> {
        let (py, test) = (slf.py(), slf.get());
        let parts = (test.report.clone_ref(py), test.files.clone_ref(py));
        Ok((slf.get_type().getattr("_again")?, parts))
    }

    /// The test of a pickle.
    #[staticmethod]
    fn _again(report: Py<PyAny>, files: Py<PyDict>) -> Self {
        BendTest { report, files }
    }
}

/// Bends clear wood of a species over two supports as ASTM D143 does, until it breaks, and puts what comes of it beside the
/// tables' values.
///
/// Keys are those of the program's `bend-test`: `moisture=30`, `span="36 cm"`, `height="2.5 cm"`. With `specimens=50` many are
/// bent, which scatter as clear wood does. Without a species, all of them are bent, each up to its largest load.
#[pyfunction]
#[pyo3(signature = (species=None, settings=None, *, progress=None, **keys))]
pub fn bend_test(
    py: Python<'_>,
    species: Option<String>,
    settings: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
    keys: Option<&Bound<'_, PyDict>>,
) -> PyResult<BendTest> {
    let mut asked = BendSettings::default();
    each([settings, keys], |key, value| Ok(asked.set(key, value)?))?;
    asked.check().map_err(Failure::from)?;
    let (numbers, files) = work::run(py, progress, |context| tested(species, &asked, context))?;
    Ok(BendTest {
        report: report(py, &numbers)?.unbind(),
        files: encoded_files(py, &files)?.unbind(),
    })
}

/// The report and the files of a test.
fn tested(
    species: Option<String>,
    asked: &BendSettings,
    context: &Context,
) -> Result<(Json, Vec<Encoded>), Failure> {
    let made = provenance("bend-test", species.as_deref(), asked);
    let (mut test, moisture) = (asked.test(), asked.moisture);
    let json = |report: serde_json::Result<Json>| report.map_err(Failure::report);
    Ok(match (species, asked.specimens) {
        (Some(species), None) => {
            let request = BendRequest {
                species,
                moisture,
                test,
            };
            let bent = bend(&request, context)?;
            let files = bend_test_files(&bent, &made)?;
            (json(serde_json::to_value(&bent.report))?, files)
        }
        (Some(species), Some(specimens)) => {
            let request = SpecimensRequest {
                species,
                moisture,
                specimens,
                flaws: asked.flaws,
                test,
            };
            let bent = bend_specimens(&request, context)?;
            let files = specimens_files(&bent, None, &made)?;
            (json(serde_json::to_value(&bent))?, files)
        }
        (None, Some(_)) => {
            return Err(Failure::value(
                "specimens are of one species, and none is named; expected a species",
            ));
        }
        (None, None) => {
            if asked.specimen.end.is_none() {
                test.end = END_AT_MAXIMUM;
            }
            let table = bend_all(moisture, &test, context)?;
            let files = bend_table_files(&table, &made)?;
            (json(serde_json::to_value(&table))?, files)
        }
    })
}
