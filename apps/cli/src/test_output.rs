//! The output of `greenstick bend-test` and `greenstick fracture-test`: a report, and files in a folder.

use crate::arguments::ReportingOptions;
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use greenstick::Error;
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::geometry::{Context, Provenance};
use serde::Serialize;
use std::fmt::{Display, Write};
use std::path::Path;
use std::process::ExitCode;

#[derive(Serialize)]
struct FullReport<'a, T> {
    #[serde(flatten)]
    report: &'a T,
    provenance: &'a Provenance,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

/// Where the report of a test goes.
pub struct TestOutput<'a> {
    /// Folder of its files, where one was named.
    pub folder: Option<&'a Path>,
    pub reporting: &'a ReportingOptions,
    pub provenance: &'a Provenance,
    pub progress: &'a Progress,
    /// The stage of writing.
    pub write: &'a Context,
}

impl TestOutput<'_> {
    /// Writes the files, where a folder was named, and prints the report.
    pub fn write<T: Serialize + Display>(
        &self,
        report: &T,
        make: impl FnOnce() -> Result<Vec<Encoded>, Error>,
    ) -> Result<ExitCode, Failure> {
        let mut listed = Vec::new();
        if let Some(folder) = self.folder {
            self.write.report(0.0)?;
            let outputs = files::write_folder(folder, make()?)?;
            listed = written(&outputs);
        }
        let stages = self.progress.finish();
        let text = if self.reporting.json {
            let full = FullReport {
                report,
                provenance: self.provenance,
                outputs: &listed,
                stages: &stages,
            };
            serde_json::to_string_pretty(&full).map_err(Failure::work)? + "\n"
        } else {
            let mut text = report.to_string();
            for file in &listed {
                let _ = writeln!(text, "wrote     {}", file.path);
            }
            let seconds: f64 = stages.iter().map(|s| s.seconds).sum();
            let _ = writeln!(text, "took      {seconds:.2} s");
            text
        };
        if self.reporting.prints_report() {
            print(&text)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
