//! Standard fracture tests of species along the grain, and their files: table, chart and report.
//!
//! The tests are those of [`greenstick_fibre::fracture_test`].

pub use crate::charts::fracture_chart;
pub use greenstick_fibre::fracture_test::{
    Beside, CrackSystem, FractureError, FractureParameters, FractureReport, FractureRequest,
    FractureTest, FractureTestKind, FractureTested, RodArrangement, fracture,
};

use crate::Error;
use crate::report_file::{json_file, with_metadata};
use greenstick_formats::Encoded;
use greenstick_geometry::Provenance;

/// The name of a test's report.
pub const FRACTURE_REPORT_FILE: &str = "fracture-test.json";

/// Returns a test, and where it comes from, as `fracture-test.json`, `load-deflection.csv`, `load-deflection.png` and
/// `csv-metadata.json`.
///
/// # Errors
/// [`Error::Report`] where the report cannot be converted to JSON.
pub fn fracture_test_files(
    tested: &FractureTested,
    provenance: &Provenance,
) -> Result<Vec<Encoded>, Error> {
    let chart = fracture_chart(tested).png_with(&provenance.metadata());
    let first = vec![
        json_file(FRACTURE_REPORT_FILE, &tested.report, provenance)?,
        Encoded::new("load-deflection.png", chart),
    ];
    let tables = vec![Encoded::new("load-deflection.csv", tested.load_table())];
    Ok([first, with_metadata(tables, provenance)].concat())
}
