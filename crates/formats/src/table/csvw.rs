//! What CSV itself has no place for, in a file beside it: units, meanings and where tables come from (W3C Recommendation
//! 2015, *Metadata Vocabulary for Tabular Data*, which readers look for under this name).

use crate::companions::Encoded;
use greenstick_geometry::{Column, Metadata, Table, Values};
use serde_json::{Map, Value, json};

/// The name under which readers look for the metadata of all tables of a folder.
pub const CSVW_FILE: &str = "csv-metadata.json";

/// A CSV file and its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct DescribedTable {
    /// Name of the file.
    pub file: String,
    columns: Value,
}

impl DescribedTable {
    /// Describes a table in the file `file`.
    pub fn new(table: &Table, file: &str) -> Self {
        DescribedTable {
            file: file.to_owned(),
            columns: table.columns.iter().map(describe).collect(),
        }
    }
}

fn describe(column: &Column) -> Value {
    let datatype = match column.values {
        Values::U8(_) | Values::U32(_) => "integer",
        Values::F64(_) => "double",
        Values::Text(_) => "string",
    };
    let mut description = json!({
        "name": column.heading(),
        "titles": column.heading(),
        "datatype": datatype,
        "dc:description": column.meaning,
    });
    if !column.unit.is_empty() {
        description["schema:unitText"] = json!(column.unit);
    }
    description
}

/// Writes the metadata of CSV files in one folder, [`CSVW_FILE`].
///
/// ```
/// use greenstick_formats::{DescribedTable, write_csv_metadata};
/// use greenstick_geometry::{Column, Metadata, Table, Values};
///
/// let width = Column::new("width", "m", "width of the ring", Values::F64(vec![0.002]));
/// let table = Table { columns: vec![width], ..Table::default() };
/// let file = write_csv_metadata(&[DescribedTable::new(&table, "rings.csv")], &Metadata::default());
/// assert!(String::from_utf8_lossy(&file.bytes).contains(r#""url": "rings.csv""#));
/// ```
pub fn write_csv_metadata(tables: &[DescribedTable], metadata: &Metadata) -> Encoded {
    let list: Vec<Value> = tables
        .iter()
        .map(|t| json!({ "url": t.file, "tableSchema": { "columns": t.columns } }))
        .collect();
    let entries = metadata.entries.iter();
    let notes: Map<String, Value> = entries.map(|e| (e.name.clone(), json!(e.text))).collect();
    let group = json!({
        "@context": "http://www.w3.org/ns/csvw",
        "tables": list,
        "notes": [notes],
    });
    Encoded {
        name: CSVW_FILE.to_owned(),
        bytes: format!("{group:#}\n").into_bytes(),
    }
}
