//! `greenstick bend-test`: bending tests of species beside the tables.

use crate::arguments::BendTestOptions;
use crate::break_wood::use_threads;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::test_output::TestOutput;
use greenstick::ErrorKind;
use greenstick::bending::{
    BEND_REPORT_FILE, BEND_TABLE_FILE, BendRequest, BendSettings, BendingError, END_AT_MAXIMUM,
    MeasuredColumns, MeasuredError, MeasuredSpecimens, MeasurementError, SPECIMENS_FILE,
    SpecimensRequest, bend, bend_all, bend_specimens, bend_table_files, bend_test_files,
    specimens_files,
};
use greenstick::fibre::BendTest;
use greenstick::files::{self, FileError};
use greenstick::provenance;
use std::process::ExitCode;

pub fn run(options: &BendTestOptions) -> Result<ExitCode, Failure> {
    let settings = options.settings.set()?;
    let test = test(&settings, options.all_species);
    test.check().map_err(|e| failure(e.into()))?;
    if let Some(folder) = &options.output {
        files::check_folder(folder, main_file(options, &settings))?;
    }
    let measured = measured(options)?;
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [work, write] = progress.split([("bend", 20.0), ("write", 1.0)]);
    let made = provenance("bend-test", options.species.as_deref(), &settings);
    let moisture = settings.moisture;
    let output = TestOutput {
        folder: options.output.as_deref(),
        reporting: &options.reporting,
        provenance: &made,
        progress: &progress,
        write: &write,
    };
    match (options.species.clone(), settings.specimens) {
        (Some(species), None) => {
            let request = BendRequest {
                species,
                moisture,
                test,
            };
            let bent = bend(&request, &work).map_err(failure)?;
            output.write(&bent.report, || bend_test_files(&bent, &made))
        }
        (Some(species), Some(specimens)) => {
            let request = SpecimensRequest {
                species,
                moisture,
                specimens,
                flaws: settings.flaws,
                test,
            };
            let mut report = bend_specimens(&request, &work).map_err(failure)?;
            if let Some(measured) = &measured {
                report = report.beside(measured);
            }
            output.write(&report, || {
                specimens_files(&report, measured.as_ref(), &made)
            })
        }
        (None, _) => {
            let table = bend_all(moisture, &test, &work).map_err(failure)?;
            output.write(&table, || bend_table_files(&table, &made))
        }
    }
}

/// Returns the name of the file that stands for all files.
fn main_file(options: &BendTestOptions, settings: &BendSettings) -> &'static str {
    match settings.specimens {
        _ if options.all_species => BEND_TABLE_FILE,
        Some(_) => SPECIMENS_FILE,
        None => BEND_REPORT_FILE,
    }
}

/// Returns the test. That of a table ends earlier where nothing else is asked for.
fn test(settings: &BendSettings, all_species: bool) -> BendTest {
    let mut test = settings.test();
    if all_species && settings.specimen.end.is_none() {
        test.end = END_AT_MAXIMUM;
    }
    test
}

/// Reads the measured specimens, where a file was named.
fn measured(options: &BendTestOptions) -> Result<Option<MeasuredSpecimens>, Failure> {
    let Some(path) = &options.measured else {
        return Ok(None);
    };
    let mut columns = MeasuredColumns::default();
    if let Some(column) = &options.density_column {
        columns.density = column.clone();
    }
    if let Some(column) = &options.rupture_column {
        columns.modulus_of_rupture = column.clone();
    }
    let missing_column = |error: FileError| match &error {
        FileError::Measured(MeasuredError::Table(MeasurementError::NoColumn { .. })) => {
            Failure::from(error).hint(
                "--density-column and --rupture-column name the columns, such as Density:g/cm3",
            )
        }
        _ => error.into(),
    };
    files::read_measured(path, &columns)
        .map(Some)
        .map_err(missing_column)
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
