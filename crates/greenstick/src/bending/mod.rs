//! Bending tests of species as in ASTM D143, and their files: tables, chart and report.
//!
//! The tests are those of [`greenstick_fibre::bend_test`].

mod measured;

pub use crate::charts::{bend_chart, scatter_chart};
pub use greenstick_fibre::bend_test::{
    BendReport, BendRequest, BendRow, BendSettings, BendTable, BendingError, Bent,
    CLEAR_WOOD_WEIBULL_MODULUS, Compared, Correlation, END_AT_MAXIMUM, ExpectedScatter, Failing,
    MeasuredSpecimens, MeasuredSummary, Phase, SpecimenResult, SpecimenRow, SpecimensReport,
    SpecimensRequest, SpecimensSummary, Statistics, Summary, bend, bend_all, bend_specimens,
};
pub use greenstick_formats::{MeasurementError, UnitColumn};
pub use measured::{MeasuredColumns, MeasuredError, parse_measured};

use crate::Error;
use crate::report_file::{json_file, with_metadata};
use greenstick_formats::Encoded;
use greenstick_geometry::Provenance;

/// The name of a test's report.
pub const BEND_REPORT_FILE: &str = "bend-test.json";
/// The name of the table of all species.
pub const BEND_TABLE_FILE: &str = "species.csv";

/// Returns a test, and where it comes from, as `bend-test.json`, `load-deflection.csv`, `load-deflection.png`, `events.csv` and
/// `csv-metadata.json`.
///
/// # Errors
/// [`Error::Report`] where the report cannot be converted to JSON.
pub fn bend_test_files(bent: &Bent, provenance: &Provenance) -> Result<Vec<Encoded>, Error> {
    let report = json_file(BEND_REPORT_FILE, &bent.report, provenance)?;
    let chart = bend_chart(bent).png_with(&provenance.metadata());
    let tables = vec![
        Encoded::new("load-deflection.csv", bent.load_table()),
        Encoded::new("events.csv", bent.event_table()),
    ];
    let first = vec![report, Encoded::new("load-deflection.png", chart)];
    Ok([first, with_metadata(tables, provenance)].concat())
}

/// Returns the tests of all species, and where they come from, as `species.csv`, `species.json`, with the summary, and
/// `csv-metadata.json`.
///
/// # Errors
/// [`Error::Report`] where the table cannot be converted to JSON.
pub fn bend_table_files(table: &BendTable, provenance: &Provenance) -> Result<Vec<Encoded>, Error> {
    let report = json_file("species.json", table, provenance)?;
    let tables = vec![Encoded::new(BEND_TABLE_FILE, table.csv())];
    Ok([vec![report], with_metadata(tables, provenance)].concat())
}

/// The name of the table of specimens.
pub const SPECIMENS_FILE: &str = "specimens.csv";

/// Returns the tests of many specimens, and where they come from, as `specimens.csv`, `specimens.json`, with the summary,
/// `scatter.png`, beside measured specimens where there are such, and `csv-metadata.json`.
///
/// # Errors
/// [`Error::Report`] where the report cannot be converted to JSON.
pub fn specimens_files(
    report: &SpecimensReport,
    measured: Option<&MeasuredSpecimens>,
    provenance: &Provenance,
) -> Result<Vec<Encoded>, Error> {
    let chart = scatter_chart(report, measured).png_with(&provenance.metadata());
    let first = vec![
        json_file("specimens.json", report, provenance)?,
        Encoded::new("scatter.png", chart),
    ];
    let tables = vec![Encoded::new(SPECIMENS_FILE, report.csv())];
    Ok([first, with_metadata(tables, provenance)].concat())
}
