//! `greenstick cracks`: from a photograph of a sawn end to a recipe of its cracks.

use crate::arguments::CracksOptions;
use crate::break_wood::file_name;
use crate::failure::{Failure, print};
use crate::outcome::{check_recipe, comment_lines};
use greenstick::files::{self, Output, read_photograph};
use greenstick::fracture::cracks::measure::{
    MeasuredCracks, PhotographedSection, SectionPhotograph, measure_cracks,
};
use greenstick::fracture::parameters::CrackKind;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::Provenance;
use greenstick::geometry::text::one_line;
use greenstick::provenance;
use greenstick::wood::polygon::area_and_centroid;
use greenstick::wood::rings::SectionFile;
use std::fmt::Write;
use std::process::ExitCode;

pub fn run(options: &CracksOptions) -> Result<ExitCode, Failure> {
    if let Some(path) = &options.output {
        check_recipe(path)?;
    }
    let mut recipe = Recipe {
        species: options.species.clone(),
        ..Recipe::default()
    };
    recipe.complete().map_err(Failure::request)?;
    let shrinkage = recipe.crack_shrinkage().map_err(Failure::request)?;
    let photograph = SectionPhotograph::from(&read_photograph(&options.from)?);
    let about = |e| Failure::request(format!("{}: {e}", options.from.display()));
    let section = section(options, &photograph)?;
    let measured = measure_cracks(&photograph, &section).map_err(about)?;
    let both = (shrinkage.tangential, shrinkage.radial);
    recipe.cracks = if options.alike {
        measured.alike(both)
    } else {
        measured.each(both)
    };
    recipe.complete().map_err(Failure::work)?;
    if let Some(path) = &options.output {
        let made = Provenance {
            parameters: Vec::new(),
            seed: None,
            ..provenance("cracks", file_name(Some(&options.from)).as_deref(), &recipe)
        };
        let text = format!(
            "# cracks measured in {}\n{}{}",
            one_line(&options.from.display().to_string()),
            comment_lines(&made),
            recipe.to_toml()
        );
        files::write_all(&[Output {
            path: path.clone(),
            bytes: text.into_bytes(),
        }])?;
    }
    if options.json {
        print(&(serde_json::to_string_pretty(&measured).map_err(Failure::work)? + "\n"))?;
    } else if !options.quiet {
        let mut text = report(&measured, options.diameter);
        let _ = writeln!(text, "opened   by the {}", shrinkage.basis);
        if let Some(path) = &options.output {
            let path = path.display();
            let _ = writeln!(text, "wrote    {path}: greenstick break --recipe {path}");
        }
        print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The section: as given, or as found in the photograph.
fn section(
    options: &CracksOptions,
    photograph: &SectionPhotograph,
) -> Result<PhotographedSection, Failure> {
    let pith = match options.pith.as_deref() {
        None => None,
        Some([x, y]) => Some([*x, *y]),
        Some(other) => {
            return Err(Failure::request(format!(
                "--pith takes two numbers x,y, not {}",
                other.len()
            )));
        }
    };
    if let (Some(pith), Some(radius)) = (pith, options.radius) {
        return Ok(PhotographedSection::circle(pith, radius));
    }
    let mut section = match &options.outline {
        Some(path) => {
            let about =
                |e: &dyn std::fmt::Display| Failure::request(format!("{}: {e}", path.display()));
            let text = files::read_text(path)?;
            let file = SectionFile::parse(&text).map_err(|e| about(&e))?;
            let outline = file.outline();
            let height = photograph.size().1 as f64;
            let down = |[x, y]: [f64; 2]| [x, if outline.y_up { height - y } else { y }];
            let points = outline.points.iter().map(|p| down(p.to_array()));
            PhotographedSection {
                pith: down(
                    outline
                        .pith
                        .unwrap_or_else(|| area_and_centroid(&outline.points).1)
                        .to_array(),
                ),
                outline: points.collect(),
            }
        }
        None => photograph.find_section().map_err(|e| {
            Failure::request(format!(
                "{}: {e}: --outline, or --pith and --radius",
                options.from.display()
            ))
        })?,
    };
    section.pith = pith.unwrap_or(section.pith);
    Ok(section)
}

fn report(measured: &MeasuredCracks, diameter: Option<f64>) -> String {
    let mut text = String::new();
    let radius = diameter.map(|d| 500.0 * d);
    let millimetres =
        |radii: f64| radius.map_or(String::new(), |r| format!(" ({:.2} mm)", r * radii));
    let [x, y] = measured.section.pith;
    let radial = measured
        .cracks
        .iter()
        .filter(|c| c.kind == CrackKind::Radial)
        .count();
    let _ = writeln!(
        text,
        "section  pith at {x:.1}, {y:.1} pixels; {radial} radial cracks, {} along rings",
        measured.cracks.len() - radial
    );
    for c in &measured.cracks {
        let course = match c.kind {
            CrackKind::Radial => format!("from {:.2} to {:.2} of the radius", c.begin, c.end),
            CrackKind::Tangential => format!("to {:.1}°, at {:.2} of the radius", c.end, c.begin),
        };
        let taper = if c.open_at_bark {
            "at the bark"
        } else {
            "in its middle"
        };
        let _ = writeln!(
            text,
            "crack    {:.1}°, {course}; length {:.3} radii{}; widest {taper}, {:.4} radii{}; taper within {:.0} %",
            c.angle,
            c.length(),
            millimetres(c.length()),
            c.width,
            millimetres(c.width),
            100.0 * c.residual
        );
    }
    if measured.texture_lines > 0 {
        let _ = writeln!(text, "texture  {}", texture(measured));
    }
    for (name, g) in ["large", "medium", "small"].iter().zip(&measured.groups) {
        let _ = writeln!(
            text,
            "{name:<8} {} cracks, the first at {:.1}°, {:.1}° apart ± {:.1}°; lengths {:.2} to {:.2}, widths {:.4} to {:.4} radii; {} open at the bark",
            g.count,
            g.direction,
            g.spacing,
            g.angle_deviation,
            g.length[0],
            g.length[1],
            g.width[0],
            g.width[1],
            g.open_at_bark
        );
    }
    text
}

/// What is said of dark lines that are no cracks.
fn texture(measured: &MeasuredCracks) -> String {
    let lines = match measured.texture_lines {
        1 => "1 dark line along the radius was".to_owned(),
        n => format!("{n} dark lines along the radius were"),
    };
    let left_out = format!(
        "{lines} left out as rays, cells, grain or dirt: broken, crooked, short or of uneven width"
    );
    match (measured.is_texture, measured.cracks.is_empty()) {
        (false, _) => left_out,
        (true, true) => format!("{left_out}; the photograph shows texture, and no crack"),
        (true, false) => format!(
            "{left_out}; they are longer than the cracks taken together, of which only those count that open more"
        ),
    }
}
