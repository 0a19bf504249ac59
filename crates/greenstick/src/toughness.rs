//! Standard fracture tests of species along the grain, and their files: table, chart and report.
//!
//! The tests are those of [`greenstick_fibre::fracture_test`].

pub use crate::charts::fracture_chart;
pub use greenstick_fibre::fracture_test::{
    Beside, CrackSystem, FractureError, FractureParameters, FractureReport, FractureRequest,
    FractureTest, FractureTestKind, FractureTested, RodArrangement, fracture,
};

use crate::Error;
use crate::report_file::json_file;
use greenstick_formats::Encoded;
use greenstick_geometry::Provenance;

/// The name of a test's report.
pub const FRACTURE_REPORT_FILE: &str = "fracture-test.json";

/// Returns a test, and in its report where it comes from, as `fracture-test.json`, `load-deflection.csv` and
/// `load-deflection.png`.
///
/// # Errors
/// [`Error::Report`] where the report cannot be converted to JSON.
pub fn fracture_test_files(
    tested: &FractureTested,
    provenance: &Provenance,
) -> Result<Vec<Encoded>, Error> {
    Ok(vec![
        json_file(FRACTURE_REPORT_FILE, &tested.report, provenance)?,
        Encoded::new("load-deflection.csv", tested.load_table()),
        Encoded::new("load-deflection.png", fracture_chart(tested).png()),
    ])
}
