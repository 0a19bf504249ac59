//! Several stems in one call: a folder for each, and a table of all.

use super::job::{Done, Job, PrintedReport, file_name, to_json};
use crate::arguments::AnatomyOptions;
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::Progress;
use greenstick::ErrorKind;
use greenstick::anatomy::{AnatomyFile, StemOutcome, stems_files};
use greenstick::files;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `--json` prints.
#[derive(Serialize)]
struct PrintedStems<'a> {
    stems: Vec<PrintedReport<'a>>,
    failures: &'a [PrintedFailure],
    outputs: &'a [Written],
}

/// An input that failed.
#[derive(Serialize)]
struct PrintedFailure {
    input: String,
    message: String,
}

/// Makes the inside of every input. What fails is reported, and the others are made all the same; the exit code says that
/// something failed.
pub fn run(
    options: &AnatomyOptions,
    file: &AnatomyFile,
    progress: &Progress,
) -> Result<ExitCode, Failure> {
    let folders = folder_names(&options.inputs);
    let count = options.inputs.len();
    let (mut outcomes, mut done, mut failures) = (Vec::new(), Vec::new(), Vec::new());
    for (k, (input, folder)) in options.inputs.iter().zip(&folders).enumerate() {
        let job = Job {
            input: Some(input),
            output: &options.output.join(folder),
            file,
        };
        let report = match job.run(&progress.item(k, count)) {
            Ok(mut one) => {
                one.stages = progress.finish();
                let report = one.report.clone();
                done.push((input, one));
                Ok(report)
            }
            Err(failure) if failure.kind() == ErrorKind::Cancelled => return Err(failure),
            Err(failure) => {
                progress.finish();
                let failure = failure.about_once(input);
                let message = failure.message().to_owned();
                failure.print();
                failures.push(PrintedFailure {
                    input: input.display().to_string(),
                    message: message.clone(),
                });
                Err(message)
            }
        };
        outcomes.push(StemOutcome {
            file: file_name(input),
            folder: report.as_ref().map_or(String::new(), |_| folder.clone()),
            report,
        });
    }
    let tables = stems_files(&outcomes, &file.provenance(None))?;
    let outputs = written(&files::write_folder(&options.output, tables)?);
    if options.reporting.prints_report() {
        print(&format(&done, &failures, &outputs, options.reporting.json)?)?;
    }
    Ok(if failures.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn format(
    done: &[(&PathBuf, Done)],
    failures: &[PrintedFailure],
    outputs: &[Written],
    json: bool,
) -> Result<String, Failure> {
    if json {
        return to_json(&PrintedStems {
            stems: done.iter().map(|(_, one)| one.printed()).collect(),
            failures,
            outputs,
        });
    }
    let mut text = String::new();
    for (input, one) in done {
        let _ = writeln!(text, "stem {}", input.display());
        text += &one.format(false)?;
    }
    for file in outputs {
        let _ = writeln!(text, "wrote {}", file.path);
    }
    let _ = writeln!(
        text,
        "{} of {} done",
        done.len(),
        done.len() + failures.len()
    );
    Ok(text)
}

/// Names of folders: those of the files without their endings, with a number where two are alike.
fn folder_names(inputs: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for input in inputs {
        let stem = Path::new(input).file_stem().unwrap_or_default();
        let stem = stem.to_string_lossy().into_owned();
        let mut name = stem.clone();
        for number in 2.. {
            if !names.iter().any(|n| n.eq_ignore_ascii_case(&name)) {
                break;
            }
            name = format!("{stem}-{number}");
        }
        names.push(name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_alike_files_have_numbers() {
        let inputs = ["a/tree.las", "b/tree.laz", "TREE.ply", "oak.ply"].map(PathBuf::from);
        assert_eq!(folder_names(&inputs), ["tree", "tree-2", "TREE-3", "oak"]);
    }
}
