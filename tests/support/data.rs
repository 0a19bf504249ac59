//! Where the tests of all crates find their data.
#![allow(dead_code)] // Each test file uses a part of this.

use std::path::{Path, PathBuf};

/// A file of `tests/data`.
pub fn data(name: &str) -> PathBuf {
    existing(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data")).join(name))
}

/// A file of the data that may not be redistributed with the repository, in the folder that the environment variable
/// `GREENSTICK_DATA` names. Tests that need one are ignored; `cargo test -- --include-ignored` runs them.
pub fn outside_data(name: &str) -> PathBuf {
    let folder = std::env::var_os("GREENSTICK_DATA")
        .expect("GREENSTICK_DATA must name the folder of the test data");
    existing(Path::new(&folder).join(name))
}

fn existing(path: PathBuf) -> PathBuf {
    assert!(path.exists(), "{} does not exist", path.display());
    path
}
