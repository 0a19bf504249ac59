//! Where a run's files came from, so that what is made of it later finds them again.

use crate::files::FileError;
use greenstick_formats::LengthUnit;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

const FILE: &str = "origin.json";

/// Where a run's files came from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// The mesh that it is of, where it is of one.
    pub input: Option<PathBuf>,
    /// Unit of length in the mesh, `mm`, `cm` or `m`, where one was named.
    pub unit: Option<String>,
    /// The folder that files of bodies are named from.
    pub beside: PathBuf,
}

impl Origin {
    /// The one of a run on `input`, with its unit, and files of bodies named from `beside`; as places that hold from
    /// everywhere.
    pub fn of(input: Option<(&Path, Option<LengthUnit>)>, beside: &Path) -> Self {
        let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let beside = if beside.as_os_str().is_empty() {
            Path::new(".")
        } else {
            beside
        };
        Origin {
            input: input.map(|(path, _)| whole(path)),
            unit: input.and_then(|(_, unit)| unit).map(|u| u.to_string()),
            beside: whole(beside),
        }
    }

    /// That of the run in `folder`; an empty one where nothing is said.
    ///
    /// # Errors
    /// [`FileError::Unreadable`] where it is there and cannot be read.
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(Origin::default());
        }
        let unreadable = |source| FileError::Unreadable {
            path: path.clone(),
            source,
        };
        let text = fs::read_to_string(&path).map_err(unreadable)?;
        serde_json::from_str(&text).map_err(|e| unreadable(e.into()))
    }

    /// The mesh and its unit.
    pub fn input_file(&self) -> Option<(PathBuf, Option<LengthUnit>)> {
        let unit = self.unit.as_deref().and_then(|u| u.parse().ok());
        self.input.clone().map(|path| (path, unit))
    }

    /// Name and content of the file that says so.
    pub(super) fn file(&self) -> (&'static str, Vec<u8>) {
        // Paths and words always fit.
        (FILE, serde_json::to_vec_pretty(self).unwrap_or_default())
    }
}
