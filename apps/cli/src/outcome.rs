//! What reports of several commands have in common: the files that were written and the time that was spent.

use crate::progress::StageTime;
use greenstick::files::Output;
use serde::Serialize;

/// A file that was written.
#[derive(Serialize)]
pub struct Written {
    pub path: String,
    pub bytes: usize,
}

/// Files as reports list them.
pub fn written(outputs: &[Output]) -> Vec<Written> {
    let told = |o: &Output| Written {
        path: o.path.display().to_string(),
        bytes: o.bytes.len(),
    };
    outputs.iter().map(told).collect()
}

/// Seconds of every stage that took any worth telling.
pub fn spent(stages: &[StageTime]) -> String {
    let told = |s: &StageTime| (s.seconds >= 0.005).then(|| format!("{} {:.2}", s.name, s.seconds));
    stages
        .iter()
        .filter_map(told)
        .collect::<Vec<_>>()
        .join(", ")
}
