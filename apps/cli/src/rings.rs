//! `greenstick rings`: the annual rings of a section from its outline.

use crate::arguments::RingsOptions;
use crate::break_wood::check_png;
use crate::failure::{Failure, print};
use greenstick::anatomy::{Erosion, RingsBy};
use greenstick::files::{self, Output};
use greenstick::rings::{RingComparison, RingsError, Section};
use greenstick::wood::rings::RingList;
use std::fmt::Write;
use std::process::ExitCode;

/// Rings where nothing is said.
const RINGS: usize = 20;
/// Pixels along each side of the picture that is eroded, where nothing is said.
const RESOLUTION: usize = 512;

/// What a model of rings gives.
struct Made {
    rings: usize,
    pith: [f64; 2],
    guessed: bool,
    told: String,
    compared: Option<String>,
    json: String,
    picture: Option<Vec<u8>>,
}

pub fn run(options: &RingsOptions) -> Result<ExitCode, Failure> {
    let path = &options.section;
    if let Some(picture) = &options.picture {
        check_png(picture)?;
    }
    let counted = [
        ("--rings", options.rings.is_some()),
        ("--radii", options.radii.is_some()),
        ("--widths", options.widths.is_some()),
    ];
    let counted = counted.into_iter().find(|c| c.1).map(|c| c.0);
    let rings_by = options.source.rings_by(counted)?;
    if rings_by == RingsBy::Field && options.resolution.is_some() {
        return Err(Failure::request(
            "--resolution is of an erosion; say --rings-by erosion with it",
        ));
    }
    let outputs: Vec<_> = options.output.iter().chain(&options.picture).collect();
    let outputs: Vec<_> = outputs.into_iter().map(|p| p.as_path()).collect();
    let text = std::fs::read_to_string(path)
        .map_err(|e| Failure::request(format!("{} cannot be read: {e}", path.display())))?;
    files::check_distinct(&outputs, std::slice::from_ref(path))?;
    outputs.iter().try_for_each(|p| files::check_writable(p))?;
    let told = |e: RingsError| Failure::request(format!("{}: {e}", path.display()));
    let section = Section::parse(&text).map_err(told)?;
    let pith = match options.pith.as_deref() {
        Some([x, y]) => Some([*x, *y]),
        Some(other) => {
            return Err(Failure::request(format!(
                "--pith takes two numbers x,y, not {}",
                other.len()
            )));
        }
        None => None,
    };
    let made = match &rings_by {
        RingsBy::Field => by_field(options, section, pith),
        RingsBy::Erosion(erosion) => by_erosion(options, section, erosion, pith),
    };
    let made = made.map_err(told)?;
    let mut words = format!(
        "{}: {} rings about the pith {:.2}, {:.2}{}; {}\n",
        path.display(),
        made.rings,
        made.pith[0],
        made.pith[1],
        if made.guessed { " (guessed)" } else { "" },
        made.told,
    );
    words += made.compared.as_deref().unwrap_or_default();
    let mut written = Vec::new();
    if let Some(path) = &options.output {
        written.push(Output {
            path: path.clone(),
            bytes: made.json.into_bytes(),
        });
    }
    if let (Some(path), Some(bytes)) = (&options.picture, made.picture) {
        let path = path.clone();
        written.push(Output { path, bytes });
    }
    files::write_all(&written)?;
    for output in &written {
        let _ = writeln!(words, "wrote {}", output.path.display());
    }
    print(&words)?;
    Ok(ExitCode::SUCCESS)
}

fn by_field(
    options: &RingsOptions,
    section: Section,
    pith: Option<[f64; 2]>,
) -> Result<Made, RingsError> {
    let list = match (options.rings, &options.radii, &options.widths) {
        (_, Some(radii), _) => RingList::Radii(radii.clone()),
        (_, _, Some(widths)) => RingList::Widths(widths.clone()),
        (number, _, _) => RingList::Number(number.unwrap_or(RINGS)),
    };
    let units = section.units().to_owned();
    let rings = section.rings(&list, pith.map(Into::into))?;
    let compared = options.compare.then(|| rings.compare()).transpose()?;
    Ok(Made {
        rings: rings.coordinates.len(),
        pith: rings.field.pith().into(),
        guessed: rings.guessed,
        told: format!(
            "mean radius of the outline {:.2} {units}",
            rings.field.mean_radius(1.0)
        ),
        compared: compared.map(|c| table(&c, "field/%", &units)),
        json: rings.json(),
        picture: (options.picture.as_ref()).map(|_| rings.picture(options.picture_size).png()),
    })
}

fn by_erosion(
    options: &RingsOptions,
    section: Section,
    erosion: &Erosion,
    pith: Option<[f64; 2]>,
) -> Result<Made, RingsError> {
    let resolution = options.resolution.unwrap_or(RESOLUTION);
    let units = section.units().to_owned();
    let rings = section.eroded(erosion, resolution, pith.map(Into::into))?;
    let compared = options.compare.then(|| rings.compare()).transpose()?;
    Ok(Made {
        rings: rings.contours.len(),
        pith: rings.pith.into(),
        guessed: rings.guessed,
        told: format!(
            "{erosion}, {} passes on {resolution} × {resolution} pixels",
            rings.kinds.len()
        ),
        compared: compared.map(|c| table(&c, "erosion/%", &units)),
        json: rings.json(),
        picture: (options.picture.as_ref()).map(|_| rings.picture(options.picture_size).png()),
    })
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
