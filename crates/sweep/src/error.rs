//! Errors of sweeps.

use greenstick::ErrorKind;
use greenstick::fibre::scene::SceneError;
use greenstick::files::FileError;
use greenstick::fracture::recipe::RecipeError;
use greenstick::geometry::Cancelled;
use std::io;
use std::path::{Path, PathBuf};

/// Why a sweep cannot be made, begun or go on. What is wrong with a single variant is in its [`crate::Record`] instead.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The recipe in the sweep is wrong, or its syntax.
    #[error(transparent)]
    Recipe(Box<RecipeError>),
    /// The scene is wrong, or there is none of that name.
    #[error(transparent)]
    Scene(Box<SceneError>),
    /// The file of the scene is wrong.
    #[error("{}: {error}", path.display())]
    SceneFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: Box<SceneError>,
    },
    /// Something that varies is wrong.
    #[error("[vary] {key}: {problem}")]
    Vary {
        /// Its key.
        key: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// The forest is none.
    #[error("{}{problem}", path.as_ref().map_or(String::new(), |path| format!("{}: ", path.display())))]
    Forest {
        /// Its file, if one is named.
        path: Option<PathBuf>,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// There are more variants than can be numbered.
    #[error(
        "the values that vary make more than {most} variants; expected fewer values or samples"
    )]
    TooMany {
        /// The most there may be.
        most: u64,
    },
    /// The number of a variant that is not there.
    #[error("there is no variant {found}; expected 0 to {last}")]
    NoVariant {
        /// The number.
        found: u64,
        /// The last one there is.
        last: u64,
    },
    /// The folder is that of another sweep.
    #[error("{}: this folder holds another sweep ({found}); expected an empty folder, or the sweep that it was begun with", path.display())]
    Another {
        /// The folder.
        path: PathBuf,
        /// What is different.
        found: String,
    },
    /// Another process writes to the folder.
    #[error("{}: another sweep is at work in this folder", path.display())]
    AtWork {
        /// The folder.
        path: PathBuf,
    },
    /// The journal is damaged.
    #[error("{}: line {line} is no line of a journal: {problem}", path.display())]
    Journal {
        /// The journal.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        problem: String,
    },
    /// The journal cannot be read or written.
    #[error("{}: {source}; what is in it is kept", path.display())]
    Io {
        /// The journal.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SweepError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SweepError::Cancelled(_) => ErrorKind::Cancelled,
            SweepError::File(error) => error.kind(),
            SweepError::Io { .. } | SweepError::AtWork { .. } => ErrorKind::Work,
            SweepError::Recipe(_)
            | SweepError::Scene(_)
            | SweepError::SceneFile { .. }
            | SweepError::Vary { .. }
            | SweepError::Forest { .. }
            | SweepError::TooMany { .. }
            | SweepError::NoVariant { .. }
            | SweepError::Another { .. }
            | SweepError::Journal { .. } => ErrorKind::Request,
        }
    }

    /// Returns how a journal cannot be read or written.
    pub(crate) fn io(path: &Path) -> impl Fn(io::Error) -> SweepError + use<> {
        let path = path.to_owned();
        move |source| SweepError::Io {
            path: path.clone(),
            source,
        }
    }
}

impl From<SceneError> for SweepError {
    fn from(error: SceneError) -> Self {
        SweepError::Scene(error.into())
    }
}

impl From<RecipeError> for SweepError {
    fn from(error: RecipeError) -> Self {
        SweepError::Recipe(error.into())
    }
}
