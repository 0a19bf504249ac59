//! Measured specimens from tables of others.

use greenstick_fibre::bend_test::{MeasuredSpecimens, TooFewSpecimens};
use greenstick_formats::{
    DENSITY_UNITS, MeasurementError, STRESS_UNITS, UnitColumn, read_measurements,
};

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
        MeasuredColumns {
            density: UnitColumn::new("density_kg_per_m3", "kg/m3"),
            modulus_of_rupture: UnitColumn::new("modulus_of_rupture_Pa", "Pa"),
        }
    }
}

/// Why there are no measured specimens.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// The table does not hold them.
    #[error(transparent)]
    Table(#[from] MeasurementError),
    /// Too few specimens to speak of scatter.
    #[error(transparent)]
    TooFew(#[from] TooFewSpecimens),
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
///
/// let too_few = parse_measured(b"Density,Resistance\n0.51,81.3\n", "birch.csv", &columns);
/// assert!(too_few.unwrap_err().to_string().contains("1 rows"));
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
    let wanted = [
        (&columns.density, DENSITY_UNITS),
        (&columns.modulus_of_rupture, STRESS_UNITS),
    ];
    let rows = read_measurements(bytes, file, wanted)?;
    Ok(MeasuredSpecimens::from_rows(file, &rows)?)
}
