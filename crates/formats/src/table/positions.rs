//! Positions of the rows of a table.

use crate::error::{FormatError, InFile};
use greenstick_geometry::{Table, Values};

/// Returns the columns `x`, `y` and `z`.
pub(crate) fn positions<'a>(table: &'a Table, file: InFile) -> Result<[&'a [f64]; 3], FormatError> {
    let mut found: [&[f64]; 3] = [&[]; 3];
    for (list, name) in found.iter_mut().zip(["x", "y", "z"]) {
        match table.column(name).map(|c| &c.values) {
            Some(Values::F64(values)) => *list = values,
            _ => {
                let found = format!("a table without a column {name} of numbers");
                return Err(file.unwritable(found, "the columns x, y and z for a file of points"));
            }
        }
    }
    Ok(found)
}
