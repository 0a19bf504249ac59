//! Files that only grow while a simulation runs.

use super::SimulateError;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Name of the file of frames.
pub(crate) const FRAME_FILE: &str = "frames.gsf";
/// How many there are.
const COUNT: usize = 4;
/// Their names: energies, events, frames, forces.
pub(super) const GROWING: [&str; COUNT] = ["energy.csv", "events.csv", FRAME_FILE, "forces.csv"];
/// Places in [`GROWING`].
pub(super) const ENERGIES: usize = 0;
pub(super) const EVENTS: usize = 1;
pub(super) const FRAMES: usize = 2;
pub(super) const FORCES: usize = 3;

/// The files that grow, open for appending.
pub(super) struct Growing {
    paths: [PathBuf; COUNT],
    files: [BufWriter<File>; COUNT],
    pub(super) bytes: [u64; COUNT],
}

impl Growing {
    pub(super) fn open(folder: &Path, bytes: Option<[u64; COUNT]>) -> Result<Self, SimulateError> {
        let paths = GROWING.map(|name| folder.join(name));
        let mut opened = Vec::new();
        for (k, path) in paths.iter().enumerate() {
            let fail = |source| SimulateError::Unwritable {
                path: path.clone(),
                source,
            };
            let file = OpenOptions::new()
                .create(true)
                .append(true)
                .open(path)
                .map_err(fail)?;
            let expected = bytes.map_or(0, |b| b[k]);
            let found = file.metadata().map_err(fail)?.len();
            if found < expected {
                return Err(SimulateError::Short {
                    path: path.clone(),
                    found,
                    expected,
                });
            }
            file.set_len(expected).map_err(fail)?;
            opened.push(BufWriter::new(file));
        }
        let files = opened
            .try_into()
            .map_err(|_| SimulateError::NothingToResume {
                folder: folder.to_owned(),
            })?;
        Ok(Growing {
            paths,
            files,
            bytes: bytes.unwrap_or_default(),
        })
    }

    pub(super) fn write(&mut self, which: usize, bytes: &[u8]) -> Result<(), SimulateError> {
        self.bytes[which] += bytes.len() as u64;
        self.files[which]
            .write_all(bytes)
            .map_err(|source| SimulateError::Unwritable {
                path: self.paths[which].clone(),
                source,
            })
    }

    pub(super) fn flush(&mut self) -> Result<(), SimulateError> {
        for (file, path) in self.files.iter_mut().zip(&self.paths) {
            file.flush().map_err(|source| SimulateError::Unwritable {
                path: path.clone(),
                source,
            })?;
        }
        Ok(())
    }
}
