//! Reports of tests as JSON files, and what their tables have no place for.

use crate::Error;
use greenstick_formats::{Encoded, with_csv_metadata};
use greenstick_geometry::Provenance;
use serde::Serialize;

/// The columns of the tests' tables that hold texts.
const TEXT_COLUMNS: [&str; 6] = [
    "kind",
    "cause",
    "species",
    "scientific_name",
    "notes",
    "not_tested_because",
];

/// Returns tables, CSV files, and after them the file with their units and where they come from.
pub(crate) fn with_metadata(tables: Vec<Encoded>, provenance: &Provenance) -> Vec<Encoded> {
    with_csv_metadata(tables, &TEXT_COLUMNS, &provenance.metadata())
}

/// A report that says where it comes from.
#[derive(Serialize)]
struct WithProvenance<'a, T> {
    #[serde(flatten)]
    report: &'a T,
    provenance: &'a Provenance,
}

/// Returns a report, and where it comes from, as a JSON file.
///
/// # Errors
/// [`Error::Report`] where the report cannot be converted to JSON.
pub(crate) fn json_file(
    name: &str,
    report: &impl Serialize,
    provenance: &Provenance,
) -> Result<Encoded, Error> {
    let value = WithProvenance { report, provenance };
    let text = serde_json::to_string_pretty(&value).map_err(|e| Error::Report(e.to_string()))?;
    Ok(Encoded::new(name, text + "\n"))
}
