//! Measurements from tables of others: columns of numbers above 0 whose units the reader names.

use super::read_csv::read_csv;
use crate::error::FormatError;
use std::str::FromStr;

/// Units of density with their size in kg/m³.
pub const DENSITY_UNITS: &[(&str, f64)] = &[
    ("kg/m3", 1.0),
    ("kg/m³", 1.0),
    ("g/cm3", 1e3),
    ("g/cm³", 1e3),
];
/// Units of stress with their size in Pa.
pub const STRESS_UNITS: &[(&str, f64)] = &[
    ("Pa", 1.0),
    ("kPa", 1e3),
    ("MPa", 1e6),
    ("GPa", 1e9),
    ("N/mm2", 1e6),
    ("N/mm²", 1e6),
];

/// Cells that say that a value is missing.
const MISSING: [&str; 4] = ["", "NA", "NaN", "-"];

/// A column of a table, with its unit: `Resistance:MPa`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitColumn {
    /// The name in the header line.
    pub name: String,
    /// The unit of its values.
    pub unit: String,
}

impl UnitColumn {
    /// Creates a column.
    pub fn new(name: &str, unit: &str) -> Self {
        UnitColumn {
            name: name.to_owned(),
            unit: unit.to_owned(),
        }
    }
}

impl FromStr for UnitColumn {
    type Err = MeasurementError;

    fn from_str(text: &str) -> Result<Self, MeasurementError> {
        // Names may hold colons, units do not.
        match text.rsplit_once(':') {
            Some((name, unit)) if !name.is_empty() && !unit.is_empty() => {
                Ok(UnitColumn::new(name, unit))
            }
            _ => Err(MeasurementError::NoUnit(text.to_owned())),
        }
    }
}

/// Why a table has no such measurements.
#[derive(Debug, thiserror::Error)]
pub enum MeasurementError {
    /// A column without a unit.
    #[error(
        "\"{0}\" is no column with its unit; expected the name in the header line, a colon and the unit, such as \
         Density:g/cm3 or Resistance:MPa"
    )]
    NoUnit(String),
    /// A unit that is not known.
    #[error("the unit \"{unit}\" of the column \"{column}\" is not known; expected one of {known}")]
    Unit {
        /// The unit found.
        unit: String,
        /// The column.
        column: String,
        /// What would be right.
        known: String,
    },
    /// The file is no table.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The table does not have a column.
    #[error("{file}: there is no column \"{column}\"; expected one of {columns}")]
    NoColumn {
        /// Name of the file.
        file: String,
        /// The column.
        column: String,
        /// The columns that there are.
        columns: String,
    },
    /// A cell that is no measured value.
    #[error(
        "{file}: line {line}: {column} is \"{found}\"; expected a number above 0, or an empty cell or NA where it is missing"
    )]
    Number {
        /// Name of the file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell.
        found: String,
    },
}

/// Reads the columns that are wanted from comma-separated values with a header line, each with the units that it may have
/// and their size. Returns them for each row in the unit of size 1; `None` where the cell says that the value is missing.
///
/// ```
/// use greenstick_formats::{DENSITY_UNITS, UnitColumn, read_measurements};
///
/// let density: UnitColumn = "Density:g/cm3".parse()?;
/// let text = b"tree,Density\n7,0.51\n8,NA\n";
/// let rows = read_measurements(text, "birch.csv", [(&density, DENSITY_UNITS)])?;
/// assert_eq!(rows, [[Some(510.0)], [None]]);
/// # Ok::<(), greenstick_formats::MeasurementError>(())
/// ```
///
/// # Errors
/// [`MeasurementError`] if a unit is not known, a column is not there, or a cell holds something other than a number above 0.
pub fn read_measurements<const N: usize>(
    bytes: &[u8],
    file: &str,
    wanted: [(&UnitColumn, &[(&str, f64)]); N],
) -> Result<Vec<[Option<f64>; N]>, MeasurementError> {
    let table = read_csv(bytes, file)?;
    let mut columns = [(0, 1.0); N];
    for ((column, units), place) in wanted.into_iter().zip(&mut columns) {
        let unit = units.iter().find(|u| u.0 == column.unit);
        let unit = unit.ok_or_else(|| MeasurementError::Unit {
            unit: column.unit.clone(),
            column: column.name.clone(),
            known: units.iter().map(|u| u.0).collect::<Vec<_>>().join(", "),
        })?;
        let number = table.columns.iter().position(|c| *c == column.name);
        let number = number.ok_or_else(|| MeasurementError::NoColumn {
            file: file.to_owned(),
            column: column.name.clone(),
            columns: table.columns.join(", "),
        })?;
        *place = (number, unit.1);
    }
    let mut rows = Vec::with_capacity(table.rows.len());
    for row in &table.rows {
        let mut values = [None; N];
        for (value, (column, size)) in values.iter_mut().zip(columns) {
            let cell = &row.cells[column];
            if MISSING.contains(&cell.as_str()) {
                continue;
            }
            let number = cell.parse::<f64>().ok().map(|number| number * size);
            *value = number.filter(|n| n.is_finite() && *n > 0.0);
            if value.is_none() {
                return Err(MeasurementError::Number {
                    file: file.to_owned(),
                    line: row.line,
                    column: table.columns[column].clone(),
                    found: cell.clone(),
                });
            }
        }
        rows.push(values);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_named() {
        let read = |density: &str, rupture: &str, text: &str| {
            let columns = [density.parse::<UnitColumn>()?, rupture.parse()?];
            let wanted = [(&columns[0], DENSITY_UNITS), (&columns[1], STRESS_UNITS)];
            read_measurements(text.as_bytes(), "t.csv", wanted)
        };
        let good = "d,r\n500,80\n510,90\n520,-\n";
        let rows = read("d:kg/m3", "r:MPa", good).unwrap();
        assert_eq!((rows[1], rows[2][1]), ([Some(510.0), Some(90e6)], None));
        for (density, rupture, text, part) in [
            ("d", "r:MPa", good, "\"d\" is no column with its unit"),
            ("d:g", "r:MPa", good, "expected one of kg/m3"),
            ("d:kg/m3", "r:psi", good, "N/mm2"),
            (
                "e:kg/m3",
                "r:MPa",
                good,
                "no column \"e\"; expected one of d, r",
            ),
            ("d:kg/m3", "r:MPa", "d,r\n1,x\n", "line 2: r is \"x\""),
            ("d:kg/m3", "r:MPa", "d,r\n-1,2\n", "line 2: d is \"-1\""),
            ("d:kg/m3", "r:MPa", "d,r\ninf,2\n", "line 2: d is \"inf\""),
            ("d:kg/m3", "r:MPa", "d,r\n1,2,3\n", "line 2"),
        ] {
            let error = read(density, rupture, text).unwrap_err().to_string();
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}
