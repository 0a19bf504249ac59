//! `greenstick anatomy`: the inside of stems as files.

mod job;
mod many;

use crate::arguments::{AnatomyOptions, Declared};
use crate::break_wood::{in_metres, use_threads};
use crate::failure::{Failure, parameter_hint, print};
use crate::progress::Progress;
use greenstick::anatomy::AnatomyFile;
use greenstick::files;
use greenstick::schema::Parameters;
use job::Job;
use std::path::PathBuf;
use std::process::ExitCode;

pub fn run(options: &AnatomyOptions) -> Result<ExitCode, Failure> {
    let mut file = AnatomyFile::default();
    apply_options(&mut file, &options.request)?;
    if let Some(path) = &options.rings_from {
        let rings = files::read_rings(path)?;
        let request = &mut file.request;
        request.series.ring_shares = Some(rings.shares);
        request.stem.eccentricity_onset =
            request.stem.eccentricity_onset.or(rings.eccentricity_onset);
    }
    file.check()
        .map_err(|error| Failure::request(&error).hint(parameter_hint(&error)))?;
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    if options.inputs.len() > 1 {
        return many::run(options, &file, &progress);
    }
    let job = Job {
        input: options.inputs.first().map(PathBuf::as_path),
        output: &options.output,
        file: &file,
    };
    let mut done = job.run(&progress.item(0, 1))?;
    done.stages = progress.finish();
    if options.reporting.prints_report() {
        print(&done.format(options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Applies options to a request. Points are in the unit of the file.
fn apply_options(file: &mut AnatomyFile, options: &Declared<AnatomyFile>) -> Result<(), Failure> {
    if let Some(word) = options.text("unit") {
        file.set_text("unit", word).map_err(Failure::request)?;
    }
    let unit = file.unit.unwrap_or_default();
    options.apply(file, |key, text| in_metres(key, text, unit))
}
