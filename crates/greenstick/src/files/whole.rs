//! Files that are read whole: looked at first, then read. Rings, photographs and measured specimens from files.

use super::error::FileError;
use super::folder_of;
use crate::anatomy::ANATOMY_FILE;
#[cfg(feature = "simulate")]
use crate::bending::{MeasuredColumns, parse_measured};
#[cfg(feature = "simulate")]
use greenstick_fibre::bend_test::MeasuredSpecimens;
use greenstick_formats::photograph::{self, Photograph};
use greenstick_formats::{Reach, reference_within};
pub use greenstick_wood::anatomy::OtherRings;
use greenstick_wood::colour::RgbImage;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Most bytes of a file: what is read stays in memory.
const MAX_FILE_SIZE: u64 = 1 << 33;
/// Most bytes of a text that somebody wrote: a recipe, a scene, a section.
const MAX_TEXT_SIZE: u64 = 1 << 27;

/// Refuses what is no plain file, or more than `most` bytes: devices and pipes may never end.
pub(super) fn look(path: &Path, most: u64) -> io::Result<()> {
    let about = fs::metadata(path)?;
    let refuse = |why: String| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    match about.len() {
        _ if about.is_dir() => refuse("it is a folder, not a plain file".to_owned()),
        _ if !about.is_file() => refuse("it is not a plain file".to_owned()),
        size if size > most => refuse(format!("it has {size} bytes; expected {most} at most")),
        _ => Ok(()),
    }
}

/// Reads a file whole, after a look at it.
pub(super) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    look(path, MAX_FILE_SIZE)?;
    fs::read(path)
}

/// Reads a text that somebody wrote.
///
/// # Errors
/// [`FileError::Unreadable`] where it is no plain file of reasonable size, or no UTF-8.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let read = look(path, MAX_TEXT_SIZE).and_then(|()| fs::read_to_string(path));
    read.map_err(FileError::unreadable(path))
}

/// Reads the rings of another section: a section file with annotated rings (JSON, as `rings` writes them), or the folder or
/// the report of an inside.
///
/// # Errors
/// [`FileError`] where there is no such file, or no rings in it.
pub fn read_rings(path: &Path) -> Result<OtherRings, FileError> {
    let report = path.join(ANATOMY_FILE);
    let file = if path.is_dir() { &report } else { path };
    OtherRings::parse(&read_text(file)?).map_err(|problem| FileError::Rings {
        path: file.to_owned(),
        problem: problem.to_string(),
    })
}

/// Reads a photograph: JPEG as the pixels are stored, whatever orientation the camera noted, or PNG of any depth and colour
/// type, of which what is transparent is white.
///
/// # Errors
/// [`FileError`] where there is no such file, or it is neither.
pub fn read_photograph(path: &Path) -> Result<RgbImage, FileError> {
    let bytes = read_bytes(path).map_err(FileError::unreadable(path))?;
    let read = photograph::read_photograph(&bytes);
    let Photograph { width, height, rgb } = read.map_err(|problem| FileError::Photograph {
        path: path.to_owned(),
        problem: problem.to_string(),
    })?;
    Ok(RgbImage { width, height, rgb })
}

/// Reads the density and the modulus of rupture of measured specimens from comma-separated values.
///
/// # Errors
/// [`FileError`] where there is no such file, or no such columns of numbers in it.
#[cfg(feature = "simulate")]
pub fn read_measured(
    path: &Path,
    columns: &MeasuredColumns,
) -> Result<MeasuredSpecimens, FileError> {
    let bytes = read_bytes(path).map_err(FileError::unreadable(path))?;
    Ok(parse_measured(
        &bytes,
        &path.display().to_string(),
        columns,
    )?)
}

/// Returns the file that `main` refers to. References may leave the folder of `main` (`../textures/bark.png`) but must be
/// relative and name a plain file, so that no mesh file causes a device or a system folder to be read.
pub(super) fn companion(main: &Path, reference: &str) -> io::Result<PathBuf> {
    named_file(folder_of(main), reference, Reach::Outside)
}

/// Returns the plain file in or about a `folder` that a reference names.
pub(super) fn named_file(folder: &Path, reference: &str, reach: Reach) -> io::Result<PathBuf> {
    let refuse = |error| io::Error::new(io::ErrorKind::InvalidInput, error);
    let path = folder.join(reference_within(reference, reach).map_err(refuse)?);
    look(&path, u64::MAX)?;
    Ok(path)
}
