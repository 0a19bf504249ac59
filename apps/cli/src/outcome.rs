//! What several commands have in common: the files that were written and the time that was spent, and the recipes that
//! are made of measurements.

use crate::failure::Failure;
use crate::progress::StageTime;
use greenstick::files::{self, Output};
use greenstick::geometry::Provenance;
use serde::Serialize;
use std::path::Path;

/// A file that was written.
#[derive(Serialize)]
pub struct Written {
    pub path: String,
    pub bytes: usize,
}

/// Lists files as reports show them.
pub fn written(outputs: &[Output]) -> Vec<Written> {
    let entry = |o: &Output| Written {
        path: o.path.display().to_string(),
        bytes: o.bytes.len(),
    };
    outputs.iter().map(entry).collect()
}

/// Lists the seconds of every stage that took at least 5 ms.
pub fn spent(stages: &[StageTime]) -> String {
    let entry =
        |s: &StageTime| (s.seconds >= 0.005).then(|| format!("{} {:.2}", s.name, s.seconds));
    stages
        .iter()
        .filter_map(entry)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Checks that a recipe can be written, before any work is done.
pub fn check_recipe(path: &Path) -> Result<(), Failure> {
    if path.extension().is_none_or(|e| e != "toml") {
        return Err(Failure::request(format!(
            "{}: recipes are TOML files; expected a name that ends in .toml",
            path.display()
        )));
    }
    Ok(files::check_writable(path)?)
}

/// Where a recipe comes from, as comments.
pub fn comment_lines(provenance: &Provenance) -> String {
    let metadata = provenance.metadata();
    metadata.lines().map(|line| format!("# {line}\n")).collect()
}
