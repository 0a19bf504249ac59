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

    /// Describes a table in the file `file` by its heading, the first line of `csv`: units are those that columns' names end
    /// in, and all columns are numbers but `texts`.
    pub fn from_heading(csv: &str, texts: &[&str], file: &str) -> Self {
        let names = csv.lines().next().unwrap_or_default().split(',');
        let column = |name: &str| {
            let is_text = texts.contains(&name);
            let datatype = if is_text { "string" } else { "double" };
            let mut description = json!({ "name": name, "titles": name, "datatype": datatype });
            if let Some(unit) = unit_of(name).filter(|_| !is_text) {
                description["schema:unitText"] = json!(unit);
            }
            description
        };
        DescribedTable {
            file: file.to_owned(),
            columns: names.map(column).collect(),
        }
    }
}

/// Endings of the names of columns, the longer ones of two that fit first, with their units.
const UNIT_ENDINGS: [(&str, &str); 14] = [
    ("_J_per_m3", "J/m3"),
    ("_J_per_m2", "J/m2"),
    ("_kg_per_m3", "kg/m3"),
    ("_m_per_N", "m/N"),
    ("_percent", "%"),
    ("_deg", "°"),
    ("_Nms", "N m s"),
    ("_Nm", "N m"),
    ("_Ns", "N s"),
    ("_N", "N"),
    ("_Pa", "Pa"),
    ("_J", "J"),
    ("_m", "m"),
    ("_s", "s"),
];

/// The unit that the name of a column ends in.
fn unit_of(name: &str) -> Option<&'static str> {
    let ending = UNIT_ENDINGS.iter().find(|(end, _)| name.ends_with(end));
    ending.map(|(_, unit)| *unit)
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

/// Adds to CSV files of one folder the metadata that say what their headings do, and `metadata`. The columns of these names
/// hold texts.
pub fn with_csv_metadata(
    mut tables: Vec<Encoded>,
    text_columns: &[&str],
    metadata: &Metadata,
) -> Vec<Encoded> {
    let describe = |table: &Encoded| {
        let text = String::from_utf8_lossy(&table.bytes);
        DescribedTable::from_heading(&text, text_columns, &table.name)
    };
    let described: Vec<DescribedTable> = tables.iter().map(describe).collect();
    tables.push(write_csv_metadata(&described, metadata));
    tables
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_gives_names_units_and_texts() {
        let heading = "time_s,holder,force_x_N,moment_x_Nm,angular_x_Nms,compliance_m_per_N,rods_broken\n0,press,1,2\n";
        let table = DescribedTable::from_heading(heading, &["holder"], "forces.csv");
        let read = |key: &str| -> Vec<Value> {
            let columns = table.columns.as_array().unwrap();
            columns.iter().map(|c| c[key].clone()).collect()
        };
        assert_eq!(read("name").len(), 7);
        assert_eq!(
            json!(read("schema:unitText")),
            json!(["s", null, "N", "N m", "N m s", "m/N", null])
        );
        assert_eq!(json!(read("datatype")[1..3]), json!(["string", "double"]));
    }
}
