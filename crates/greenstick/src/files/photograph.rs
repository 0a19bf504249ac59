//! Photographs from files.

use super::error::FileError;
use greenstick_formats::photograph::{self, Photograph};
use greenstick_wood::colour::RgbImage;
use std::path::Path;

/// Reads a photograph: JPEG as the pixels are stored, whatever orientation the camera noted, or PNG of any depth and colour
/// type, of which what is transparent is white.
///
/// # Errors
/// [`FileError`] where there is no such file, or it is neither.
pub fn read_photograph(path: &Path) -> Result<RgbImage, FileError> {
    let bytes = std::fs::read(path).map_err(FileError::unreadable(path))?;
    let read = photograph::read_photograph(&bytes);
    let Photograph { width, height, rgb } = read.map_err(|problem| FileError::Photograph {
        path: path.to_owned(),
        problem: problem.to_string(),
    })?;
    Ok(RgbImage { width, height, rgb })
}
