//! `greenstick rings`: the annual rings of a section from its outline.

use crate::arguments::RingsOptions;
use crate::break_files::check_png;
use crate::break_wood::file_name;
use crate::failure::{Failure, parameter_hint, print};
use greenstick::SectionRingSettings;
use greenstick::files::{self, Output, read_photograph};
use greenstick::geometry::Context;
use greenstick::provenance;
use greenstick::schema::Parameters;
use greenstick::wood::rings::{
    RingComparison, RingsFile, SectionFile, SectionFileError, SectionRingMethod,
};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub fn run(options: &RingsOptions) -> Result<ExitCode, Failure> {
    let path = &options.section;
    if let Some(picture) = &options.picture {
        check_png(picture)?;
    }
    let settings = settings(options)?;
    let (method, pith) = (settings.method(), settings.pith_point());
    let photo = options.photo.as_deref().map(read_photograph).transpose()?;
    let outputs: Vec<&Path> = options
        .output
        .iter()
        .chain(&options.picture)
        .map(|p| p.as_path())
        .collect();
    let text = files::read_text(path)?;
    let inputs: Vec<PathBuf> = std::iter::once(path)
        .chain(&options.photo)
        .cloned()
        .collect();
    files::check_distinct(&outputs, &inputs)?;
    outputs.iter().try_for_each(|p| files::check_writable(p))?;

    let context = Context::quiet();
    let about_file = |e: SectionFileError| Failure::request(format!("{}: {e}", path.display()));
    let section = SectionFile::parse(&text).map_err(about_file)?;
    let units = section.units().to_owned();
    let onset = match (settings.eccentricity_onset, options.fit) {
        (None, true) => Some(
            section
                .fit_eccentricity_onset(pith.map(Into::into), &context)
                .map_err(about_file)?,
        ),
        (given, _) => given,
    };
    let section = section
        .with_eccentricity_onset(onset)
        .rings(&method, pith.map(Into::into), &context)
        .map_err(about_file)?;
    let mut report = summary(path, &section, &method, &units);
    if let (true, Some(onset)) = (options.fit, onset) {
        let _ = writeln!(
            report,
            "fitted: the stem began to lean at {onset:.2} of its radius (--eccentricity-onset)"
        );
    }
    if options.compare {
        let rings = section.compare(&context).map_err(about_file)?;
        let model = match method {
            SectionRingMethod::Field(_) => "field/%",
            SectionRingMethod::Erosion { .. } => "erosion/%",
        };
        report += &table(&rings, model, &units);
    }
    let made = provenance("rings", file_name(Some(path)).as_deref(), &settings);
    let mut files = Vec::new();
    if let Some(path) = &options.output {
        files.push(Output {
            path: path.clone(),
            bytes: section.json(&made, &context)?.into_bytes(),
        });
    }
    if let Some(path) = &options.picture {
        let picture = match &photo {
            Some(photo) => section.paint_over(photo, &context)?,
            None => section.paint(settings.picture_size, &context)?,
        };
        files.push(Output {
            path: path.clone(),
            bytes: picture.png_with(&made.metadata()),
        });
    }
    files::write_all(&files)?;
    for file in &files {
        let _ = writeln!(report, "wrote {}", file.path.display());
    }
    print(&report)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the settings with their defaults and the options.
fn settings(options: &RingsOptions) -> Result<SectionRingSettings, Failure> {
    let settings = options.settings.set()?;
    settings
        .check()
        .map_err(|error| Failure::request(&error).hint(parameter_hint(&error)))?;
    Ok(settings)
}

/// Summarises the rings in one line.
fn summary(path: &Path, section: &RingsFile, method: &SectionRingMethod, units: &str) -> String {
    let rings = &section.rings;
    let pith = rings.pith();
    let about_method = match method {
        SectionRingMethod::Field(_) => format!(
            "mean radius of the outline {:.2} {units}",
            rings.outline_mean_radius()
        ),
        SectionRingMethod::Erosion {
            erosion,
            resolution,
        } => format!(
            "{erosion}, {} passes on {resolution} × {resolution} pixels",
            rings.pass_count().unwrap_or(0)
        ),
    };
    format!(
        "{}: {} rings about the pith {:.2}, {:.2}{}; {about_method}\n",
        path.display(),
        rings.ring_count(),
        pith.x,
        pith.y,
        if rings.is_pith_estimated() {
            " (guessed)"
        } else {
            ""
        },
    )
}

/// What `--compare` prints: root mean square radial distances in % of each annotated ring's mean radius.
fn table(rings: &[RingComparison], model: &str, units: &str) -> String {
    let mut text = format!(
        "{:>8} {:>12} {:>9} {:>10} {:>8}\n",
        "ring",
        format!("radius/{units}"),
        model,
        "outline/%",
        "circle/%"
    );
    let mut sums = [0.0; 3];
    for ring in rings {
        let errors = [
            ring.model_percent,
            ring.outline_percent,
            ring.circle_percent,
        ];
        for (sum, e) in sums.iter_mut().zip(errors) {
            *sum += e / rings.len() as f64;
        }
        let [a, b, c] = errors;
        let _ = writeln!(
            text,
            "{:>8} {:>12.2} {a:>9.2} {b:>10.2} {c:>8.2}",
            ring.label, ring.mean_radius
        );
    }
    let [a, b, c] = sums;
    let _ = writeln!(text, "{:>8} {:>12} {a:>9.2} {b:>10.2} {c:>8.2}", "mean", "");
    text
}
