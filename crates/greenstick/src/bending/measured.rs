//! Measured specimens from tables of others.

use greenstick_fibre::bend_test::MeasuredSpecimens;
use greenstick_formats::{FormatError, read_csv};
use std::str::FromStr;

/// Units of density with their size in kg/m³.
const DENSITY_UNITS: [(&str, f64); 4] = [
    ("kg/m3", 1.0),
    ("kg/m³", 1.0),
    ("g/cm3", 1e3),
    ("g/cm³", 1e3),
];
/// Units of stress with their size in Pa.
const STRESS_UNITS: [(&str, f64); 6] = [
    ("Pa", 1.0),
    ("kPa", 1e3),
    ("MPa", 1e6),
    ("GPa", 1e9),
    ("N/mm2", 1e6),
    ("N/mm²", 1e6),
];
/// Cells that say that a value is missing.
const MISSING: [&str; 4] = ["", "NA", "NaN", "-"];
/// Fewer pairs have no correlation.
const MIN_SPECIMENS: usize = 3;

/// A column of a table, with its unit: `Resistance:MPa`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitColumn {
    /// The name in the header line.
    pub name: String,
    /// The unit of its values.
    pub unit: String,
}

impl FromStr for UnitColumn {
    type Err = MeasuredError;

    fn from_str(text: &str) -> Result<Self, MeasuredError> {
        // Names may hold colons, units do not.
        match text.rsplit_once(':') {
            Some((name, unit)) if !name.is_empty() && !unit.is_empty() => Ok(UnitColumn {
                name: name.to_owned(),
                unit: unit.to_owned(),
            }),
            _ => Err(MeasuredError::NoUnit(text.to_owned())),
        }
    }
}

/// The columns of a table of measured specimens. The default is that of the table of simulated ones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeasuredColumns {
    /// Density.
    pub density: UnitColumn,
    /// Modulus of rupture.
    pub modulus_of_rupture: UnitColumn,
}

impl Default for MeasuredColumns {
    fn default() -> Self {
        let column = |name: &str, unit: &str| UnitColumn {
            name: name.to_owned(),
            unit: unit.to_owned(),
        };
        MeasuredColumns {
            density: column("density_kg_per_m3", "kg/m3"),
            modulus_of_rupture: column("modulus_of_rupture_Pa", "Pa"),
        }
    }
}

/// Why there are no measured specimens.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
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
    /// Too few specimens to speak of scatter.
    #[error(
        "{file}: {found} rows have density and modulus of rupture; expected at least {MIN_SPECIMENS}"
    )]
    TooFew {
        /// Name of the file.
        file: String,
        /// Number of rows with both.
        found: usize,
    },
}

/// Reads measured specimens from comma-separated values. Rows without one of both values are counted and left out.
///
/// ```
/// use greenstick::bending::{MeasuredColumns, parse_measured};
///
/// let columns = MeasuredColumns {
///     density: "Density:g/cm3".parse()?,
///     modulus_of_rupture: "Resistance:MPa".parse()?,
/// };
/// let text = "Density,Resistance\n0.51,81.3\n0.55,96.9\n0.58,NA\n0.61,120.2\n";
/// let birch = parse_measured(text.as_bytes(), "birch.csv", &columns)?;
/// assert_eq!((birch.density[0], birch.incomplete), (510.0, 1));
/// # Ok::<(), greenstick::bending::MeasuredError>(())
/// ```
///
/// # Errors
/// [`MeasuredError`].
pub fn parse_measured(
    bytes: &[u8],
    file: &str,
    columns: &MeasuredColumns,
) -> Result<MeasuredSpecimens, MeasuredError> {
    let table = read_csv(bytes, file)?;
    let find = |column: &UnitColumn, units: &[(&str, f64)]| {
        let unit = units.iter().find(|u| u.0 == column.unit);
        let number = table.columns.iter().position(|c| *c == column.name);
        match (unit, number) {
            (None, _) => Err(MeasuredError::Unit {
                unit: column.unit.clone(),
                column: column.name.clone(),
                known: units.iter().map(|u| u.0).collect::<Vec<_>>().join(", "),
            }),
            (_, None) => Err(MeasuredError::NoColumn {
                file: file.to_owned(),
                column: column.name.clone(),
                columns: table.columns.join(", "),
            }),
            (Some(unit), Some(number)) => Ok((number, unit.1)),
        }
    };
    let columns = [
        find(&columns.density, &DENSITY_UNITS)?,
        find(&columns.modulus_of_rupture, &STRESS_UNITS)?,
    ];
    let mut specimens = MeasuredSpecimens {
        source: file.to_owned(),
        density: Vec::new(),
        modulus_of_rupture: Vec::new(),
        incomplete: 0,
    };
    for row in &table.rows {
        let value = |(column, size): (usize, f64)| {
            let cell = &row.cells[column];
            if MISSING.contains(&cell.as_str()) {
                return Ok(None);
            }
            let number = cell.parse::<f64>().ok().map(|number| number * size);
            let valid = number.filter(|n| n.is_finite() && *n > 0.0);
            valid.map(Some).ok_or_else(|| MeasuredError::Number {
                file: file.to_owned(),
                line: row.line,
                column: table.columns[column].clone(),
                found: cell.clone(),
            })
        };
        match [value(columns[0])?, value(columns[1])?] {
            [Some(density), Some(rupture)] => {
                specimens.density.push(density);
                specimens.modulus_of_rupture.push(rupture);
            }
            _ => specimens.incomplete += 1,
        }
    }
    if specimens.density.len() < MIN_SPECIMENS {
        return Err(MeasuredError::TooFew {
            file: file.to_owned(),
            found: specimens.density.len(),
        });
    }
    Ok(specimens)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_named() {
        let parse = |density: &str, rupture: &str, text: &str| {
            let columns = MeasuredColumns {
                density: density.parse()?,
                modulus_of_rupture: rupture.parse()?,
            };
            parse_measured(text.as_bytes(), "t.csv", &columns)
        };
        let good = "d,r\n500,80\n510,90\n520,100\n";
        assert_eq!(parse("d:kg/m3", "r:MPa", good).unwrap().density.len(), 3);
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
            ("d:kg/m3", "r:MPa", "d,r\n1,2\n,3\n", "1 rows"),
            ("d:kg/m3", "r:MPa", "d,r\n1,2,3\n", "line 2"),
        ] {
            let error = parse(density, rupture, text).unwrap_err().to_string();
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}
