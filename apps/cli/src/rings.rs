//! `greenstick rings`: the annual rings of a section from its outline.

use crate::arguments::RingsOptions;
use crate::break_wood::check_png;
use crate::failure::{Failure, print};
use greenstick::files::{self, Output};
use greenstick::rings::{RingComparison, RingsError, Section};
use greenstick::wood::rings::RingList;
use std::fmt::Write;
use std::process::ExitCode;

/// Rings where nothing is said.
const RINGS: usize = 20;

pub fn run(options: &RingsOptions) -> Result<ExitCode, Failure> {
    let path = &options.section;
    if let Some(picture) = &options.picture {
        check_png(picture)?;
    }
    let outputs: Vec<_> = options.output.iter().chain(&options.picture).collect();
    let outputs: Vec<_> = outputs.into_iter().map(|p| p.as_path()).collect();
    let text = std::fs::read_to_string(path)
        .map_err(|e| Failure::request(format!("{} cannot be read: {e}", path.display())))?;
    files::check_distinct(&outputs, std::slice::from_ref(path))?;
    outputs.iter().try_for_each(|p| files::check_writable(p))?;
    let told = |e: RingsError| Failure::request(format!("{}: {e}", path.display()));
    let section = Section::parse(&text).map_err(told)?;
    let list = match (options.rings, &options.radii, &options.widths) {
        (_, Some(radii), _) => RingList::Radii(radii.clone()),
        (_, _, Some(widths)) => RingList::Widths(widths.clone()),
        (number, _, _) => RingList::Number(number.unwrap_or(RINGS)),
    };
    let pith = match options.pith.as_deref() {
        Some([x, y]) => Some([*x, *y].into()),
        Some(other) => {
            return Err(Failure::request(format!(
                "--pith takes two numbers x,y, not {}",
                other.len()
            )));
        }
        None => None,
    };
    let units = section.units().to_owned();
    let rings = section.rings(&list, pith).map_err(told)?;
    let mut words = format!(
        "{}: {} rings about the pith {:.2}, {:.2}{}; mean radius of the outline {:.2} {units}\n",
        path.display(),
        rings.coordinates.len(),
        rings.field.pith().x,
        rings.field.pith().y,
        if rings.guessed { " (guessed)" } else { "" },
        rings.field.mean_radius(1.0),
    );
    if options.compare {
        words += &table(&rings.compare().map_err(told)?, &units);
    }
    let mut written = Vec::new();
    if let Some(path) = &options.output {
        written.push(Output {
            path: path.clone(),
            bytes: rings.json().into_bytes(),
        });
    }
    if let Some(path) = &options.picture {
        written.push(Output {
            path: path.clone(),
            bytes: rings.picture(options.picture_size).png(),
        });
    }
    files::write_all(&written)?;
    for output in &written {
        let _ = writeln!(words, "wrote {}", output.path.display());
    }
    print(&words)?;
    Ok(ExitCode::SUCCESS)
}

/// What `--compare` prints: root mean square radial distances in % of each annotated ring's mean radius.
fn table(rings: &[RingComparison], units: &str) -> String {
    let mut text = format!(
        "{:>8} {:>12} {:>8} {:>10} {:>8}\n",
        "ring",
        format!("radius/{units}"),
        "field/%",
        "outline/%",
        "circle/%"
    );
    let mut sums = [0.0; 3];
    for ring in rings {
        let errors = [
            ring.field_percent,
            ring.outline_percent,
            ring.circle_percent,
        ];
        for (sum, e) in sums.iter_mut().zip(errors) {
            *sum += e / rings.len() as f64;
        }
        let [a, b, c] = errors;
        let _ = writeln!(
            text,
            "{:>8} {:>12.2} {a:>8.2} {b:>10.2} {c:>8.2}",
            ring.label, ring.mean_radius
        );
    }
    let [a, b, c] = sums;
    let _ = writeln!(text, "{:>8} {:>12} {a:>8.2} {b:>10.2} {c:>8.2}", "mean", "");
    text
}
