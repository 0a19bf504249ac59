//! Files of a skin: their names, and scenes written in metres.

use crate::failure::Failure;
use greenstick::files::{self, Batch, Output};
use greenstick::formats::{Encoded, LengthUnit};
use greenstick::geometry::Scene;
use std::path::Path;

/// Writes a scene with the metre as its unit; returns the files' names and sizes.
pub fn in_metres(
    scene: &Scene,
    path: &Path,
    batch: &mut Batch,
) -> Result<Vec<(String, usize)>, Failure> {
    let outputs = files::encode(scene, path, LengthUnit::Metre)?;
    outputs.iter().try_for_each(|output| batch.add(output))?;
    let written = |o: &Output| (o.path.display().to_string(), o.bytes.len());
    Ok(outputs.iter().map(written).collect())
}

/// A file in a folder.
pub fn in_folder(folder: &Path, file: Encoded) -> Output {
    Output {
        path: folder.join(file.name),
        bytes: file.bytes,
    }
}

/// The ending of a file's name in lower case.
pub fn ending(path: &Path) -> String {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    ending.unwrap_or_default()
}
