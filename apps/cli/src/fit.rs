//! `greenstick fit`: from a run's folder to a recipe.

use crate::arguments::FitOptions;
use crate::failure::{Failure, print};
use crate::outcome::{Written, check_recipe, comment_lines};
use crate::progress::Progress;
use crate::skin::{self, MeshImages};
use greenstick::files::{self, Output};
use greenstick::fit::{Fit, FitError, FitReport, fit};
use greenstick::geometry::text::one_line;
use greenstick::provenance;
use serde::Serialize;
use std::fmt::Write;
use std::process::ExitCode;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    report: &'a FitReport,
    outputs: &'a [Written],
}

pub fn run(options: &FitOptions) -> Result<ExitCode, Failure> {
    if let Some(path) = &options.output {
        check_recipe(path)?;
    }
    let progress = Progress::start(options.quiet);
    let [read, work] = progress.split([("read", 1.0), ("fit", 3.0)]);
    let mut run = skin::open(
        &options.run,
        skin::named(&options.mesh),
        MeshImages::Left,
        &read,
    )?;
    let number = skin::frame_number(&run, options.frame)?;
    let Fit { recipe, report, .. } = fit(&mut run, number, &work).map_err(failure)?;
    let mut written = Vec::new();
    if let Some(path) = &options.output {
        let text = format!(
            "# from the break that was simulated in {}\n# greenstick break ... --at {} --recipe {}\n{}{}",
            one_line(&options.run.display().to_string()),
            report.at,
            one_line(&path.display().to_string()),
            comment_lines(&provenance("fit", None, &run.scene)),
            recipe.to_toml()
        );
        written.push(Written {
            path: path.display().to_string(),
            bytes: text.len(),
        });
        files::write_all(&[Output {
            path: path.clone(),
            bytes: text.into_bytes(),
        }])?;
    }
    if options.json {
        let full = FullReport {
            report: &report,
            outputs: &written,
        };
        print(&(serde_json::to_string_pretty(&full).map_err(Failure::work)? + "\n"))?;
    } else if !options.quiet {
        let mut text = report.to_string();
        for file in &written {
            let _ = writeln!(
                text,
                "wrote    {}: greenstick break ... --at {} --recipe {}",
                file.path, report.at, file.path
            );
        }
        if written.is_empty() {
            let _ = writeln!(
                text,
                "next     -o FILE.toml writes a recipe for greenstick break ... --at {} --recipe FILE.toml",
                report.at
            );
        }
        print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn failure(error: FitError) -> Failure {
    match error {
        FitError::Run(error) => error.into(),
        other => Failure::new(other.kind(), &other),
    }
}
