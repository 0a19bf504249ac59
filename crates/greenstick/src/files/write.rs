//! Writing of files: several together or not at all.

use super::error::FileError;
use super::folder_of;
use super::staged::Staged;
use greenstick_formats::{Encoded, LengthUnit, OutputFormat};
use greenstick_geometry::Scene;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Its path.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Encodes a scene as files: the one at `path`, in the format of its ending, then its companions in the same folder.
///
/// # Errors
/// [`FileError`] if the ending is unknown or the format cannot represent the scene.
pub fn encode(scene: &Scene, path: &Path, unit: LengthUnit) -> Result<Vec<Output>, FileError> {
    let format = output_format(path)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let encoded = greenstick_formats::write_as(format, scene, &name, unit);
    let place = |(i, Encoded { name, bytes }): (usize, Encoded)| Output {
        path: if i == 0 {
            path.to_owned()
        } else {
            path.with_file_name(name)
        },
        bytes,
    };
    Ok(encoded
        .map_err(FileError::Encoding)?
        .into_iter()
        .enumerate()
        .map(place)
        .collect())
}

/// Returns the format of the ending of `path`.
///
/// # Errors
/// [`FileError::UnknownEnding`].
pub fn output_format(path: &Path) -> Result<OutputFormat, FileError> {
    OutputFormat::from_path(path).ok_or_else(|| {
        let endings = OutputFormat::all().into_iter().map(OutputFormat::extension);
        FileError::unknown_ending(path, endings)
    })
}

/// Checks that a file can be written at `path`, without leaving anything there, so that a program can fail before its
/// work instead of after it.
///
/// # Errors
/// [`FileError::Unwritable`] if not.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let staged = Staged::new(path, &[])?;
    drop(staged);
    Ok(())
}

/// Checks that no output is the same file as an input or another output.
///
/// # Errors
/// [`FileError::WouldOverwrite`].
pub fn check_distinct(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), FileError> {
    let real = |path: &Path| match (fs::canonicalize(path), path.file_name()) {
        (Ok(path), _) => path,
        (Err(_), Some(name)) => {
            fs::canonicalize(folder_of(path)).map_or_else(|_| path.to_owned(), |f| f.join(name))
        }
        (Err(_), None) => path.to_owned(),
    };
    let read: Vec<PathBuf> = inputs.iter().map(|p| real(p)).collect();
    let mut taken = Vec::new();
    for path in outputs {
        let this = real(path);
        let refuse = |what| FileError::WouldOverwrite {
            path: path.to_path_buf(),
            what,
        };
        if read.contains(&this) {
            return Err(refuse("an input file"));
        }
        if taken.contains(&this) {
            return Err(refuse("another output"));
        }
        taken.push(this);
    }
    Ok(())
}

/// Writes all files or none: each under a temporary name in its folder first; when all are complete they are renamed,
/// companions before the main file. No reader sees half a file, and earlier files are restored if a step fails.
///
/// # Errors
/// [`FileError::Unwritable`] with the file that failed.
pub fn write_all(outputs: &[Output]) -> Result<(), FileError> {
    let mut batch = Batch::default();
    outputs.iter().try_for_each(|output| batch.add(output))?;
    batch.finish()
}

/// Writes one file in a stream, under a temporary name first. If `write` fails, nothing is left of it.
///
/// # Errors
/// Those of `write`, and [`FileError::Unwritable`].
pub fn write_streamed<T, E: From<FileError>>(
    path: &Path,
    write: impl FnOnce(&mut io::BufWriter<fs::File>) -> Result<T, E>,
) -> Result<T, E> {
    let mut batch = Batch::default();
    let written = batch.stream(path, write)?;
    batch.finish()?;
    Ok(written)
}

/// Files that are written one after the other under temporary names and renamed together at the end. If the batch is
/// dropped unfinished, nothing is left of them.
#[derive(Default)]
pub struct Batch(Vec<Staged>);

impl Batch {
    /// Writes a file.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, output: &Output) -> Result<(), FileError> {
        self.0.push(Staged::new(&output.path, &output.bytes)?);
        Ok(())
    }

    /// Writes a file in a stream.
    ///
    /// # Errors
    /// Those of `write`, and [`FileError::Unwritable`].
    pub fn stream<T, E: From<FileError>>(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut io::BufWriter<fs::File>) -> Result<T, E>,
    ) -> Result<T, E> {
        let (staged, file) = Staged::begin(path)?;
        let mut file = io::BufWriter::new(file);
        let written = write(&mut file)?;
        file.flush().map_err(FileError::unwritable(path))?;
        self.0.push(staged);
        Ok(written)
    }

    /// Renames all files, the last one first. Earlier files are restored if a step fails.
    ///
    /// # Errors
    /// [`FileError::Unwritable`] with the file that failed.
    pub fn finish(mut self) -> Result<(), FileError> {
        for i in (0..self.0.len()).rev() {
            if let Err(error) = self.0[i].rename() {
                self.0.iter_mut().for_each(Staged::undo);
                return Err(error);
            }
        }
        self.0.iter_mut().for_each(Staged::commit);
        Ok(())
    }
}

/// Checks that a file `name` can be written into a folder, which need not exist yet.
///
/// # Errors
/// [`FileError::Unwritable`] if not.
pub fn check_folder(folder: &Path, name: &str) -> Result<(), FileError> {
    let mut existing = folder;
    while !existing.exists() {
        existing = match existing.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
    }
    check_writable(&existing.join(name))
}

/// Writes all files into a folder or none. The folder is created if it does not exist, and then removed again if a file
/// cannot be written.
///
/// # Errors
/// [`FileError::Unwritable`] with what failed.
pub fn write_folder(folder: &Path, files: Vec<Encoded>) -> Result<Vec<Output>, FileError> {
    let is_new = !folder.exists();
    fs::create_dir_all(folder).map_err(FileError::unwritable(folder))?;
    let outputs: Vec<Output> = files
        .into_iter()
        .map(|Encoded { name, bytes }| Output {
            path: folder.join(name),
            bytes,
        })
        .collect();
    match write_all(&outputs) {
        Ok(()) => Ok(outputs),
        Err(error) => {
            if is_new {
                // Fails unless the folder is empty.
                let _ = fs::remove_dir(folder);
            }
            Err(error)
        }
    }
}
