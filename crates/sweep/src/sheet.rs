//! The contact sheet of a sweep: small pictures of some variants, evenly spread over all, with their numbers.

use crate::error::SweepError;
use crate::making::CELL;
use crate::plan::Sweep;
use crate::worker::cell_file;
use greenstick::files::{self, Output};
use greenstick::picture::{Picture, SheetCell, contact_sheet};
use std::path::{Path, PathBuf};

/// Name of the contact sheet in the folder of a sweep.
pub const SHEET_FILE: &str = "sheet.png";

/// Writes the contact sheet into the folder of a sweep, of the small pictures that are there. Returns its path; `None` where
/// there are none.
///
/// # Errors
/// [`SweepError::File`] where it cannot be written.
pub fn write_sheet(sweep: &Sweep, folder: &Path) -> Result<Option<PathBuf>, SweepError> {
    let cells: Vec<SheetCell> = sweep
        .shown()
        .into_iter()
        .filter_map(|number| {
            let small = files::read_photograph(&folder.join(cell_file(number))).ok()?;
            Some(SheetCell {
                label: number.to_string(),
                picture: Picture {
                    width: small.width as u32,
                    height: small.height as u32,
                    rgb: small.rgb,
                },
            })
        })
        .collect();
    if cells.is_empty() {
        return Ok(None);
    }
    let sheet = contact_sheet(&cells, CELL);
    let path = folder.join(SHEET_FILE);
    files::write_all(&[Output {
        path: path.clone(),
        bytes: sheet.png_with(&sweep.base.provenance(None).metadata()),
    }])?;
    Ok(Some(path))
}
