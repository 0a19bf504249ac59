//! Writing tables: comma-separated text, Parquet, and, for tables with places in them, points in PLY and VTK.

mod csv;
mod parquet;
mod points;

use crate::error::{FormatError, InFile};
use crate::{Encoded, vtk};
use greenstick_geometry::{Table, Values};

/// A file format of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TableFormat {
    /// Comma-separated values with one line of headings.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// Stanford polygons: points with properties.
    Ply,
    /// VTK's points with data, in XML (`.vtp`).
    Vtp,
}

impl TableFormat {
    /// Every format.
    pub const ALL: [TableFormat; 4] = [
        TableFormat::Csv,
        TableFormat::Parquet,
        TableFormat::Ply,
        TableFormat::Vtp,
    ];

    /// The file name's ending, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            TableFormat::Parquet => "parquet",
            TableFormat::Ply => "ply",
            TableFormat::Vtp => "vtp",
        }
    }
}

/// Writes a table. The point formats take the place of a row from its columns `x`, `y` and `z`.
///
/// # Errors
/// [`FormatError::Unwritable`] where columns differ in length or names, a point format finds no place, or a number is not
/// finite.
pub fn write_table(format: TableFormat, table: &Table, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    if let Some(fault) = table.fault() {
        let right = "columns of one length with different names of letters, digits and _";
        return Err(file.unwritable(fault, right));
    }
    for column in &table.columns {
        let Values::F64(values) = &column.values else {
            continue;
        };
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            let found = format!("{} in row {row} of column {}", values[row], column.name);
            return Err(file.unwritable(found, "finite numbers"));
        }
    }
    let bytes = match format {
        TableFormat::Csv => csv::write(table),
        TableFormat::Parquet => parquet::write(table, file)?,
        TableFormat::Ply => points::write_ply(table, file)?,
        TableFormat::Vtp => vtk::write_points(table, file)?,
    };
    Ok(Encoded {
        name: name.to_owned(),
        bytes,
    })
}

/// The places of rows.
pub(crate) fn places<'a>(table: &'a Table, file: InFile) -> Result<[&'a [f64]; 3], FormatError> {
    let mut found: [&[f64]; 3] = [&[]; 3];
    for (list, name) in found.iter_mut().zip(["x", "y", "z"]) {
        match table.column(name).map(|c| &c.values) {
            Some(Values::F64(values)) => *list = values,
            _ => {
                let lacks = format!("a table without numbers in a column {name}");
                return Err(file.unwritable(lacks, "columns x, y and z for a file of points"));
            }
        }
    }
    Ok(found)
}
