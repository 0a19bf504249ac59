//! `greenstick fracture-test`: standard fracture tests of species along the grain.

use crate::arguments::FractureTestOptions;
use crate::break_wood::use_threads;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::test_output::TestOutput;
use greenstick::ErrorKind;
use greenstick::files;
use greenstick::provenance;
use greenstick::toughness::{
    FRACTURE_REPORT_FILE, FractureError, FractureRequest, fracture, fracture_test_files,
};
use std::process::ExitCode;

pub fn run(options: &FractureTestOptions) -> Result<ExitCode, Failure> {
    let parameters = options.parameters.set()?;
    let test = parameters.test();
    test.check().map_err(failure)?;
    if let Some(folder) = &options.output {
        files::check_folder(folder, FRACTURE_REPORT_FILE)?;
    }
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [work, write] = progress.split([("test", 20.0), ("write", 1.0)]);
    let made = provenance("fracture-test", Some(&options.species), &parameters);
    let request = FractureRequest {
        species: options.species.clone(),
        moisture: parameters.moisture,
        test,
    };
    let tested = fracture(&request, &work).map_err(failure)?;
    let output = TestOutput {
        folder: options.output.as_deref(),
        reporting: &options.reporting,
        provenance: &made,
        progress: &progress,
        write: &write,
    };
    output.write(&tested.report, || fracture_test_files(&tested, &made))
}

fn failure(error: FractureError) -> Failure {
    let failure = Failure::new(error.kind(), &error);
    match (&error, error.kind()) {
        (FractureError::Species(_), _) => failure.hint("`greenstick species` lists all of them"),
        (FractureError::Strength(_), _) => {
            failure.hint("`greenstick species NAME` shows what is known about one")
        }
        (_, ErrorKind::Request) => failure
            .hint("`greenstick fracture-test --help` says how lengths follow from one another"),
        _ => failure,
    }
}
