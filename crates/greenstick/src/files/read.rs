//! Reading of mesh files and point clouds with their companions.

use super::error::FileError;
use super::images::image_files;
use super::whole::{companion, look, read_bytes};
use greenstick_formats::{CloudFormat, Content, Format, FormatError, InputFormat, LengthUnit};
use greenstick_geometry::Scene;
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// A scene and the files it was read from.
#[derive(Debug, Clone)]
pub struct Source {
    /// The scene.
    pub scene: Scene,
    /// The main file, then its companions, and the images that it refers to.
    pub files: Vec<PathBuf>,
}

/// Reads a mesh file. `unit` is the unit of length in it (see [`greenstick_formats::read`]).
///
/// # Errors
/// [`FileError`] if the file or a companion that it needs does not exist or is invalid.
pub fn read(path: &Path, unit: Option<LengthUnit>) -> Result<Scene, FileError> {
    load(path, unit).map(|source| source.scene)
}

/// Reads a mesh file as [`read`] does, and lists all files that were read.
///
/// # Errors
/// As [`read`].
pub fn load(path: &Path, unit: Option<LengthUnit>) -> Result<Source, FileError> {
    let unknown = || FileError::unknown_ending(path, Format::ALL.map(Format::extension));
    let format = Format::from_path(path).ok_or_else(unknown);
    let (scene, mut files) = fetch(path, format, |format, bytes, name, resolve| {
        greenstick_formats::read(format, bytes, name, unit, resolve)
    })?;
    files.extend(image_files(&scene, path));
    let scene = in_metres(scene, unit);
    Ok(Source { scene, files })
}

/// Reads a file with a mesh or a point cloud, and lists all files that were read.
///
/// # Errors
/// As [`read`].
pub fn load_content(
    path: &Path,
    unit: Option<LengthUnit>,
) -> Result<(Content, Vec<PathBuf>), FileError> {
    let format = InputFormat::from_path(path).ok_or_else(|| {
        let clouds = CloudFormat::ALL.iter().flat_map(|f| f.extensions());
        let meshes = Format::ALL.map(Format::extension).into_iter();
        FileError::unknown_ending(path, meshes.chain(clouds.copied()))
    });
    let (content, mut files) = fetch(path, format, |format, bytes, name, resolve| {
        greenstick_formats::read_content(format, bytes, name, unit, resolve)
    })?;
    let content = match content {
        Content::Mesh(scene) => {
            files.extend(image_files(&scene, path));
            Content::Mesh(in_metres(scene, unit))
        }
        cloud => cloud,
    };
    Ok((content, files))
}

/// Returns a scene whose meshes are in metres, too: what is written of it has no scale that other programs have to apply.
fn in_metres(mut scene: Scene, unit: Option<LengthUnit>) -> Scene {
    if let Some(unit) = unit.filter(|unit| *unit != LengthUnit::Metre) {
        scene.move_scale_into_meshes(unit.metres());
    }
    scene
}

/// Calls `read` with the bytes of a file of a known format and a function that reads its companions, after a look at the file
/// and its ending. Returns the result and all files read.
fn fetch<F, T>(
    path: &Path,
    format: Result<F, FileError>,
    read: impl FnOnce(F, &[u8], &str, greenstick_formats::Resolve) -> Result<T, FormatError>,
) -> Result<(T, Vec<PathBuf>), FileError> {
    let unreadable = FileError::unreadable(path);
    look(path, u64::MAX).map_err(&unreadable)?;
    let format = format?;
    let bytes = read_bytes(path).map_err(unreadable)?;
    let files = RefCell::new(vec![path.to_owned()]);
    let resolve = |reference: &str| {
        let companion = companion(path, reference)?;
        let bytes = read_bytes(&companion)?;
        let mut files = files.borrow_mut();
        if !files.contains(&companion) {
            files.push(companion);
        }
        Ok(bytes)
    };
    let made = read(format, &bytes, &path.to_string_lossy(), &resolve);
    Ok((made.map_err(FileError::Content)?, files.into_inner()))
}
