//! `greenstick bend-test`: bending tests of species beside the tables.

use crate::arguments::BendTestOptions;
use crate::break_wood::use_threads;
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use greenstick::Error;
use greenstick::ErrorKind;
use greenstick::bending::{
    BEND_REPORT_FILE, BEND_TABLE_FILE, BendRequest, BendSettings, BendingError, END_OF_TABLE, bend,
    bend_all, bend_table_files, bend_test_files,
};
use greenstick::fibre::BendTest;
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::geometry::{Context, Provenance};
use greenstick::provenance;
use serde::Serialize;
use std::fmt::{Display, Write};
use std::process::ExitCode;

#[derive(Serialize)]
struct FullReport<'a, T> {
    #[serde(flatten)]
    report: &'a T,
    provenance: &'a Provenance,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

pub fn run(options: &BendTestOptions) -> Result<ExitCode, Failure> {
    let settings = options.settings.set()?;
    let test = test(&settings, options.all_species);
    test.check().map_err(|e| failure(e.into()))?;
    if let Some(folder) = &options.output {
        let main = if options.all_species {
            BEND_TABLE_FILE
        } else {
            BEND_REPORT_FILE
        };
        files::check_folder(folder, main)?;
    }
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [work, write] = progress.split([("bend", 20.0), ("write", 1.0)]);
    let made = provenance("bend-test", options.species.as_deref(), &settings);
    match &options.species {
        Some(species) => {
            let request = BendRequest {
                species: species.clone(),
                moisture: settings.moisture,
                test,
            };
            let bent = bend(&request, &work).map_err(failure)?;
            write_report(options, (&bent.report, &made), (&progress, &write), || {
                bend_test_files(&bent, &made)
            })
        }
        None => {
            let table = bend_all(settings.moisture, &test, &work).map_err(failure)?;
            write_report(options, (&table, &made), (&progress, &write), || {
                bend_table_files(&table, &made)
            })
        }
    }
}

/// Returns the test. That of a table ends earlier where nothing else is asked for.
fn test(settings: &BendSettings, all_species: bool) -> BendTest {
    let mut test = settings.specimen.test();
    if all_species && settings.specimen.end.is_none() {
        test.end = END_OF_TABLE;
    }
    test
}

/// Writes the files, where a folder was named, and prints the report.
fn write_report<T: Serialize + Display>(
    options: &BendTestOptions,
    (report, provenance): (&T, &Provenance),
    (progress, write): (&Progress, &Context),
    make: impl FnOnce() -> Result<Vec<Encoded>, Error>,
) -> Result<ExitCode, Failure> {
    let mut listed = Vec::new();
    if let Some(folder) = &options.output {
        write.report(0.0)?;
        let outputs = files::write_folder(folder, make()?)?;
        listed = written(&outputs);
    }
    let stages = progress.finish();
    let text = if options.reporting.json {
        let full = FullReport {
            report,
            provenance,
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
    if options.reporting.prints_report() {
        print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn failure(error: BendingError) -> Failure {
    let failure = Failure::new(error.kind(), &error);
    match (&error, error.kind()) {
        (BendingError::Species(_), _) => failure.hint("`greenstick species` lists all of them"),
        (BendingError::Moisture(_) | BendingError::Strength(_), _) => {
            failure.hint("`greenstick species NAME` shows what is known about one")
        }
        (BendingError::Test(_), ErrorKind::Request) => {
            failure.hint("`greenstick bend-test --help` says how lengths follow from one another")
        }
        _ => failure,
    }
}
