//! Opening a recorded run, and pictures of it.

use super::error::FilmError;
use crate::pictures::picture_of_skin;
use greenstick_fibre::simulate::SceneMeshes;
use greenstick_fibre::store::RunSource;
use greenstick_geometry::{Context, Scene};
use greenstick_picture::{Picture, PictureError, PictureOptions};
use greenstick_skin::film::{Run, RunWood};
use std::sync::Arc;

/// Opens a run that was recorded: grows its wood again from its scene and the `meshes` that the scene names.
///
/// # Errors
/// [`FilmError`] where there is no run, or where it is of other meshes.
pub fn open_run(
    source: Arc<dyn RunSource>,
    meshes: &SceneMeshes,
    context: &Context,
) -> Result<Run, FilmError> {
    let scene = source.scene()?;
    if source.frames()?.count() == 0 {
        let error = greenstick_skin::film::FilmError::NoFrames { run: source.name() };
        return Err(error.into());
    }
    let wood = RunWood::from_scene(&scene, meshes, context)?;
    Ok(Run::new(source, wood)?)
}

/// Takes a picture of a scene that was made of a run, whose wood inside has the material `inner`.
///
/// # Errors
/// As [`greenstick_picture::render`].
pub fn picture_of_run(
    run: &Run,
    scene: &Scene,
    inner: u32,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    picture_of_skin(scene, run.stem(), run.appearance(), inner, options, context)
}
