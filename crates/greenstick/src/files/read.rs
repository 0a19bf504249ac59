//! Reading of mesh files and point clouds with their companions.

use super::error::FileError;
use greenstick_formats::{
    CloudFormat, Content, Format, InputFormat, LengthUnit, relative_reference,
};
use greenstick_geometry::Scene;
use std::cell::RefCell;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Lists the endings of mesh files for messages.
pub fn mesh_endings() -> String {
    Format::ALL
        .map(|f| format!(".{}", f.extension()))
        .join(", ")
}

/// A scene and the files it was read from.
#[derive(Debug, Clone)]
pub struct Source {
    /// The scene.
    pub scene: Scene,
    /// The main file, then its companions, each once.
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
    let unknown = || FileError::unknown_ending(path, mesh_endings());
    let format = Format::from_path(path).ok_or_else(unknown);
    let (scene, files) = fetch(path, |bytes, name, resolve| {
        greenstick_formats::read(format?, bytes, name, unit, resolve).map_err(FileError::Content)
    })?;
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
    let clouds = CloudFormat::ALL.iter().flat_map(|f| f.extensions());
    let format = InputFormat::from_path(path).ok_or_else(|| {
        let all = clouds.fold(mesh_endings(), |all, e| format!("{all}, .{e}"));
        FileError::unknown_ending(path, all)
    });
    fetch(path, |bytes, name, resolve| {
        greenstick_formats::read_content(format?, bytes, name, unit, resolve)
            .map_err(FileError::Content)
    })
}

/// Calls `read` with the bytes of a file and a function that reads its companions. Returns the result and all files read.
fn fetch<T>(
    path: &Path,
    read: impl FnOnce(&[u8], &str, greenstick_formats::Resolve) -> Result<T, FileError>,
) -> Result<(T, Vec<PathBuf>), FileError> {
    let unreadable = FileError::unreadable(path);
    let about = fs::metadata(path).map_err(&unreadable)?;
    if about.is_dir() {
        return Err(unreadable(io::Error::other(
            "it is a folder, not a mesh file",
        )));
    }
    let bytes = fs::read(path).map_err(unreadable)?;
    let files = RefCell::new(vec![path.to_owned()]);
    let resolve = |reference: &str| {
        let companion = companion(path, reference)?;
        let bytes = fs::read(&companion)?;
        let mut files = files.borrow_mut();
        if !files.contains(&companion) {
            files.push(companion);
        }
        Ok(bytes)
    };
    let made = read(&bytes, &path.to_string_lossy(), &resolve)?;
    Ok((made, files.into_inner()))
}

/// Returns the file that `main` refers to. References may leave the folder of `main` (`../textures/bark.png`) but must be
/// relative and name a regular file, so that no mesh file causes a device or a system folder to be read.
pub(super) fn companion(main: &Path, reference: &str) -> io::Result<PathBuf> {
    let refuse = |why: &dyn ToString| io::Error::new(io::ErrorKind::InvalidInput, why.to_string());
    let relative = relative_reference(reference).map_err(|error| refuse(&error))?;
    let path = main.parent().unwrap_or(Path::new("")).join(relative);
    if !fs::metadata(&path)?.is_file() {
        return Err(refuse(&"it is not a plain file"));
    }
    Ok(path)
}
