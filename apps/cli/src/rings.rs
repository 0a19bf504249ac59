//! `greenstick rings`: the annual rings of a section from its outline.

use crate::arguments::RingsOptions;
use crate::break_wood::check_png;
use crate::failure::{Failure, print};
use greenstick::files::{self, Output};
use greenstick::geometry::Context;
use greenstick::schema::Parameters;
use greenstick::wood::anatomy::RingMethod;
use greenstick::wood::rings::{
    RingComparison, RingSeries, RingsFile, SectionFile, SectionFileError, SectionRingMethod,
};
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

/// Default number of rings.
const DEFAULT_RINGS: usize = 20;
/// Default number of pixels along each side of the bitmap that is eroded.
const DEFAULT_RESOLUTION: usize = 512;

pub fn run(options: &RingsOptions) -> Result<ExitCode, Failure> {
    let path = &options.section;
    if let Some(picture) = &options.picture {
        check_png(picture)?;
    }
    let method = method(options)?;
    let pith = pith(options)?;
    let outputs: Vec<&Path> = options
        .output
        .iter()
        .chain(&options.picture)
        .map(|p| p.as_path())
        .collect();
    let text = std::fs::read_to_string(path)
        .map_err(|e| Failure::request(format!("{} cannot be read: {e}", path.display())))?;
    files::check_distinct(&outputs, std::slice::from_ref(path))?;
    outputs.iter().try_for_each(|p| files::check_writable(p))?;

    let context = Context::quiet();
    let about_file = |e: SectionFileError| Failure::request(format!("{}: {e}", path.display()));
    let section = SectionFile::parse(&text).map_err(about_file)?;
    let units = section.units().to_owned();
    let onset = match (options.eccentricity_onset, options.fit) {
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
            "fitted: the stem began to be eccentric at {onset:.2} of its radius (--eccentricity-onset)"
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
    let mut files = Vec::new();
    if let Some(path) = &options.output {
        files.push(Output {
            path: path.clone(),
            bytes: section.json(&context)?.into_bytes(),
        });
    }
    if let Some(path) = &options.picture {
        files.push(Output {
            path: path.clone(),
            bytes: section.paint(options.picture_size, &context)?.png(),
        });
    }
    files::write_all(&files)?;
    for file in &files {
        let _ = writeln!(report, "wrote {}", file.path.display());
    }
    print(&report)?;
    Ok(ExitCode::SUCCESS)
}

fn method(options: &RingsOptions) -> Result<SectionRingMethod, Failure> {
    let counted = [
        ("--rings", options.rings.is_some()),
        ("--radii", options.radii.is_some()),
        ("--widths", options.widths.is_some()),
    ];
    let counted = counted.into_iter().find(|c| c.1).map(|c| c.0);
    let source = options.source.set()?;
    source.check().map_err(Failure::request)?;
    let method = source.method();
    if let (RingMethod::Erosion(_), Some(option)) = (&method, counted) {
        return Err(Failure::request(format!(
            "{option}: an erosion makes its own number of rings, by its kernels and --resolution; leave the option out"
        )));
    }
    match method {
        RingMethod::Field if options.resolution.is_some() => Err(Failure::request(
            "--resolution belongs to an erosion; add --rings-by erosion",
        )),
        RingMethod::Field => Ok(SectionRingMethod::Field(
            match (options.rings, &options.radii, &options.widths) {
                (_, Some(radii), _) => RingSeries::Radii(radii.clone()),
                (_, _, Some(widths)) => RingSeries::Widths(widths.clone()),
                (number, _, _) => RingSeries::Number(number.unwrap_or(DEFAULT_RINGS)),
            },
        )),
        RingMethod::Erosion(erosion) => Ok(SectionRingMethod::Erosion {
            erosion,
            resolution: options.resolution.unwrap_or(DEFAULT_RESOLUTION),
        }),
    }
}

fn pith(options: &RingsOptions) -> Result<Option<[f64; 2]>, Failure> {
    match options.pith.as_deref() {
        Some([x, y]) => Ok(Some([*x, *y])),
        Some(other) => Err(Failure::request(format!(
            "--pith takes two numbers x,y, not {}",
            other.len()
        ))),
        None => Ok(None),
    }
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
