//! Parts of the reports of several commands: the files that were written and the time that was spent.

use crate::progress::StageTime;
use greenstick::files::Output;
use serde::Serialize;

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
