//! Files that are written under temporary names and renamed when they are complete.

use super::error::FileError;
use super::folder_of;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file under a temporary name. Dropping it removes the temporary file and the backup.
pub(super) struct Staged {
    target: PathBuf,
    temporary: Option<PathBuf>,
    /// A second name of the file that the target was before.
    backup: Option<PathBuf>,
    renamed: bool,
}

impl Staged {
    /// Writes a file under a temporary name.
    pub fn new(target: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let (staged, mut file) = Staged::begin(target)?;
        let written = file.write_all(bytes).and_then(|()| file.flush());
        written.map_err(FileError::unwritable(target))?;
        Ok(staged)
    }

    /// Creates an empty temporary file for a target.
    pub fn begin(target: &Path) -> Result<(Self, fs::File), FileError> {
        // What a link points to is written, and the link stays.
        let real = fs::canonicalize(target).ok().or_else(|| linked(target));
        let unwritable = FileError::unwritable(target);
        if target.is_dir() {
            return Err(unwritable(io::Error::other("a folder has this name")));
        }
        if target.exists() && !target.is_file() {
            let why =
                "a device or a pipe has this name, in which no file can be renamed into place";
            return Err(unwritable(io::Error::other(why)));
        }
        let target = real.as_deref().unwrap_or(target);
        if target.file_name().is_none() {
            return Err(unwritable(io::Error::other("it names no file")));
        }
        if !folder_of(target).is_dir() {
            let missing = format!("there is no folder {}", folder_of(target).display());
            return Err(unwritable(io::Error::new(io::ErrorKind::NotFound, missing)));
        }
        let (temporary, file) =
            free_name(target, |path| fs::File::create_new(path)).map_err(unwritable)?;
        let staged = Staged {
            target: target.to_owned(),
            temporary: Some(temporary),
            backup: None,
            renamed: false,
        };
        Ok((staged, file))
    }

    /// Gives the file its name.
    pub fn rename(&mut self) -> Result<(), FileError> {
        let Some(temporary) = &self.temporary else {
            return Ok(());
        };
        if self.target.exists() {
            // Without hard links in the file system there is no backup.
            let backup = free_name(&self.target, |path| fs::hard_link(&self.target, path));
            self.backup = backup.ok().map(|(path, ())| path);
        }
        fs::rename(temporary, &self.target).map_err(FileError::unwritable(&self.target))?;
        (self.temporary, self.renamed) = (None, true);
        Ok(())
    }

    /// Restores what was there before, as far as possible.
    pub fn undo(&mut self) {
        match self.backup.take() {
            Some(backup) if self.renamed => drop(fs::rename(backup, &self.target)),
            Some(backup) => drop(fs::remove_file(backup)),
            None if self.renamed => drop(fs::remove_file(&self.target)),
            None => {}
        }
        self.renamed = false;
    }

    /// Removes the backup of the file that was replaced.
    pub fn commit(&mut self) {
        if let Some(backup) = self.backup.take() {
            drop(fs::remove_file(backup));
        }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if let Some(temporary) = self.temporary.take() {
            drop(fs::remove_file(temporary));
        }
        self.commit();
    }
}

/// The file that a link to nothing would make; none where `path` is no link.
fn linked(path: &Path) -> Option<PathBuf> {
    let next = |link: &PathBuf| fs::read_link(link).ok().map(|to| folder_of(link).join(to));
    // As many links as Linux follows (path_resolution(7)).
    let links = std::iter::successors(next(&path.to_owned()), next);
    links.take(40).last()
}

/// Tries temporary names in the folder of `target` until `make` succeeds with one.
fn free_name<T>(target: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    const TRIES: u32 = 100;
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut last = io::Error::other("no free name");
    for i in 0..TRIES {
        let path = target.with_file_name(format!(".{name}.{process}-{i}.part"));
        match make(&path) {
            Ok(made) => return Ok((path, made)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}
