//! The scene that comes of a forest: whole trees as they were, and the pieces of those that broke.

use crate::error::SweepError;
use crate::journal::Journal;
use crate::plan::Sweep;
use greenstick::files;
use greenstick::formats::LengthUnit;
use greenstick::geometry::Context;
use std::path::{Path, PathBuf};

/// Name of the scene in the folder of a sweep, without its ending.
pub const SCENE_FILE: &str = "forest";

/// Writes the scene of a forest whose trees are done into the folder of a sweep. Returns its path; `None` where none is asked
/// for.
///
/// # Errors
/// [`SweepError`] where pieces cannot be read or the scene cannot be written, or the caller cancelled.
pub fn write_scene(
    sweep: &Sweep,
    journal: &Journal,
    folder: &Path,
    context: &Context,
) -> Result<Option<PathBuf>, SweepError> {
    let (Some(forest), Some(ending)) = (&sweep.forest, sweep.settings.scene_ending()) else {
        return Ok(None);
    };
    let mut pieces = Vec::new();
    for place in journal.places()?.into_iter().flatten() {
        let record = journal.at(place)?;
        let file = record.file.map(|file| folder.join(file));
        pieces.extend(file.map(|file| (record.variant as usize, file)));
    }
    let mut scene = forest.with_pieces(&pieces, context)?;
    let input = sweep.input_path(&sweep.base);
    let name = input.as_deref().and_then(Path::file_name);
    let name = name.map(|name| name.to_string_lossy().into_owned());
    scene.metadata = sweep.base.provenance(name.as_deref()).metadata();
    let path = folder.join(format!("{SCENE_FILE}.{ending}"));
    let outputs = files::encode(&scene, &path, LengthUnit::Metre).map_err(SweepError::File)?;
    files::write_all(&outputs)?;
    Ok(Some(path))
}
