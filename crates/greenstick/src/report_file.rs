//! Reports of tests as JSON files.

use crate::Error;
use greenstick_formats::Encoded;
use greenstick_geometry::Provenance;
use serde::Serialize;

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
