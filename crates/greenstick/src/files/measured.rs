//! Measured specimens of bending tests, from files.

use super::error::FileError;
use crate::bending::{MeasuredColumns, parse_measured};
use greenstick_fibre::bend_test::MeasuredSpecimens;
use std::path::Path;

/// Reads the density and the modulus of rupture of measured specimens from comma-separated values.
///
/// # Errors
/// [`FileError`] where there is no such file, or no such columns of numbers in it.
pub fn read_measured(
    path: &Path,
    columns: &MeasuredColumns,
) -> Result<MeasuredSpecimens, FileError> {
    let bytes = std::fs::read(path).map_err(FileError::unreadable(path))?;
    let name = path.display().to_string();
    Ok(parse_measured(&bytes, &name, columns)?)
}
