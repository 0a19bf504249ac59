//! Tables: writers of comma-separated values, of Parquet and, for tables with positions, of points in PLY and VTK; readers of
//! comma-separated values and of measurements in them.

mod csv;
mod csvw;
mod measurements;
#[cfg(feature = "parquet")]
mod parquet;
mod points;
mod positions;
mod read_csv;

pub use csvw::{CSVW_FILE, DescribedTable, with_csv_metadata, write_csv_metadata};
pub use measurements::{
    DENSITY_UNITS, MeasurementError, STRESS_UNITS, UnitColumn, read_measurements,
};
#[cfg(feature = "parquet")]
pub use parquet::ParquetStream;
pub(crate) use positions::positions;
pub use read_csv::{TextRow, TextTable, read_csv};

use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use crate::vtk;
use greenstick_geometry::{Table, Values};

/// A file format of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TableFormat {
    /// Comma-separated values with a header line.
    Csv,
    /// Apache Parquet.
    #[cfg(feature = "parquet")]
    Parquet,
    /// Stanford polygon format: points with properties.
    Ply,
    /// VTK poly data (`.vtp`): points with data.
    Vtp,
}

impl TableFormat {
    /// All formats.
    pub const ALL: &[TableFormat] = &[
        TableFormat::Csv,
        #[cfg(feature = "parquet")]
        TableFormat::Parquet,
        TableFormat::Ply,
        TableFormat::Vtp,
    ];

    /// The extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            #[cfg(feature = "parquet")]
            TableFormat::Parquet => "parquet",
            TableFormat::Ply => "ply",
            TableFormat::Vtp => "vtp",
        }
    }
}

/// Writes a table. The point formats take positions from the columns `x`, `y` and `z`. A number that is missing, NaN, makes
/// an empty cell in CSV, which alone of these formats has such.
///
/// ```
/// use greenstick_formats::{TableFormat, write_table};
/// use greenstick_geometry::{Column, Table, Values};
///
/// let rings = Column::new("ring", "", "number of the ring", Values::U32(vec![1, 2]));
/// let widths = Column::new("width", "m", "width of the ring", Values::F64(vec![0.002, 0.0015]));
/// let table = Table { columns: vec![rings, widths], ..Table::default() };
/// let file = write_table(TableFormat::Csv, &table, "rings.csv")?;
/// assert_eq!(file.bytes, b"ring,width_m\n1,0.002\n2,0.0015\n");
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError::Unwritable`] if the table is invalid, a point format finds no positions, or a number is not finite.
pub fn write_table(format: TableFormat, table: &Table, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    if let Some(fault) = table.fault() {
        return Err(file.faulty_table(fault));
    }
    let texts = table
        .columns
        .iter()
        .find(|c| matches!(c.values, Values::Text(_)));
    let has_positions = matches!(format, TableFormat::Ply | TableFormat::Vtp);
    if let (Some(column), true) = (texts, has_positions) {
        let found = format!("the column of texts {}", column.name);
        return Err(file.unwritable(found, "columns of numbers in a file of points"));
    }
    for column in &table.columns {
        let Values::F64(values) = &column.values else {
            continue;
        };
        let is_missing = |v: &f64| v.is_nan() && format == TableFormat::Csv;
        if let Some(row) = (values.iter()).position(|v| !v.is_finite() && !is_missing(v)) {
            let found = format!("{} in row {row} of column {}", values[row], column.name);
            return Err(file.unwritable(found, "finite numbers"));
        }
    }
    let bytes = match format {
        TableFormat::Csv => csv::write(table),
        #[cfg(feature = "parquet")]
        TableFormat::Parquet => parquet::write(table, file)?,
        TableFormat::Ply => points::write_ply(table, file)?,
        TableFormat::Vtp => vtk::write_points(table, file)?,
    };
    Ok(Encoded {
        name: name.to_owned(),
        bytes,
    })
}
