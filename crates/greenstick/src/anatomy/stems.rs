//! Many stems in one table.

use crate::Error;
use greenstick_formats::{DescribedTable, Encoded, TableFormat, write_csv_metadata, write_table};
use greenstick_geometry::Provenance;
use greenstick_wood::anatomy::{StemOutcome, stems_table};

/// Name of the table of all stems.
const STEMS_FILE: &str = "stems.csv";

/// Returns `stems.csv`, with a row for each input, and the file of its metadata.
///
/// # Errors
/// [`Error`] where a number is infinite.
pub fn stems_files(stems: &[StemOutcome], provenance: &Provenance) -> Result<Vec<Encoded>, Error> {
    let table = stems_table(stems);
    let described = [DescribedTable::new(&table, STEMS_FILE)];
    Ok(vec![
        write_table(TableFormat::Csv, &table, STEMS_FILE)?,
        write_csv_metadata(&described, &provenance.metadata()),
    ])
}
