//! Errors of files.

use greenstick_formats::FormatError;
use greenstick_geometry::ErrorKind;
use std::io;
use std::path::{Path, PathBuf};

/// Why files cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The ending of a name is that of no format.
    #[error("{}: {}; expected a name that ends in {}", path.display(), ending_of(path), expected)]
    UnknownEnding {
        /// The file.
        path: PathBuf,
        /// The known endings.
        expected: String,
    },
    /// A file has no annual rings.
    #[error("{}: {problem}; expected a section with `rings` (.json), or a folder that holds an inside", path.display())]
    Rings {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A file is no photograph that can be read.
    #[error("{}: {problem}; expected a photograph as JPEG or PNG", path.display())]
    Photograph {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A table has no measured specimens.
    #[cfg(feature = "simulate")]
    #[error(transparent)]
    Measured(#[from] crate::bending::MeasuredError),
    /// The content is invalid.
    #[error(transparent)]
    Content(FormatError),
    /// The format cannot represent the scene.
    #[error(transparent)]
    Encoding(FormatError),
    /// A file cannot be written; no other file was written either.
    #[error("{}: cannot be written: {source}; nothing was written", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Two outputs would be the same file, or one would replace a file that was read.
    #[error("{}: would overwrite {what}; choose another name for the output", path.display())]
    WouldOverwrite {
        /// The file.
        path: PathBuf,
        /// What the file already is.
        what: &'static str,
    },
}

impl FileError {
    /// Returns how an error of the file system makes a file unreadable.
    pub(super) fn unreadable(path: &Path) -> impl Fn(io::Error) -> FileError {
        |source| FileError::Unreadable {
            path: path.to_owned(),
            source,
        }
    }

    /// Returns how an error of the file system makes a file unwritable.
    pub(super) fn unwritable(path: &Path) -> impl Fn(io::Error) -> FileError {
        |source| FileError::Unwritable {
            path: path.to_owned(),
            source,
        }
    }

    /// Returns the error of a name whose ending is not one of those that are `expected`.
    pub(super) fn unknown_ending(
        path: &Path,
        expected: impl IntoIterator<Item = &'static str>,
    ) -> FileError {
        let expected: Vec<String> = expected.into_iter().map(|e| format!(".{e}")).collect();
        FileError::UnknownEnding {
            path: path.to_owned(),
            expected: expected.join(", "),
        }
    }

    /// Returns the kind of the error: [`ErrorKind::Request`] if other input or other names would help.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FileError::Unwritable { .. } | FileError::Encoding(_) => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}

fn ending_of(path: &Path) -> String {
    match path.extension() {
        Some(ending) => format!("unknown ending .{}", ending.display()),
        None => "the name has no ending".to_owned(),
    }
}
