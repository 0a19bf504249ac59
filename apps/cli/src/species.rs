//! `greenstick species`: the table of all species, and everything that is known about one.

use crate::arguments::SpeciesOptions;
use crate::failure::{Failure, print};
use crate::list::json;
use greenstick::wood::moisture::{AIR_DRY_PERCENT, Basis, Fallback, WETTEST_PERCENT};
use greenstick::wood::species::{DEFAULT_BUNDLE_DIAMETER, GreenRatio, Group, Property, Species};
use std::fmt::Write;
use std::process::ExitCode;

pub fn run(options: &SpeciesOptions) -> Result<ExitCode, Failure> {
    let text = match &options.name {
        Some(name) => {
            let species = Species::find(name).map_err(|e| {
                Failure::request(e).hint("`greenstick species` without a name lists all of them")
            })?;
            if options.json {
                json(species)?
            } else {
                one(species)
            }
        }
        None if options.json => json(&Species::all())?,
        None if options.markdown => markdown(),
        None => table(),
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Headings of the tables of all species, with units.
const HEADINGS: [&str; 8] = [
    "species",
    "scientific name",
    "density kg/m³",
    "bending MPa",
    "stiffness GPa",
    "crushing MPa",
    "shear MPa",
    "height rule",
];

/// Returns the cells of one species.
fn cells(s: &Species) -> [String; 8] {
    let number = |x: Option<f64>, unit: f64, digits: usize| {
        x.map_or("–".to_owned(), |x| format!("{:.digits$}", x / unit))
    };
    [
        s.name.clone(),
        s.scientific_name.clone(),
        number(s.air_dry_density, 1.0, 0),
        number(s.dry.modulus_of_rupture, 1e6, 0),
        number(s.dry.modulus_of_elasticity, 1e9, 1),
        number(s.dry.compression_parallel, 1e6, 0),
        number(s.dry.shear_parallel, 1e6, 1),
        rule(s),
    ]
}

/// Returns the rule for the height of the broken face of air-dry wood, and its result.
fn rule(s: &Species) -> String {
    if let Ok(ratio) = s.equation_9() {
        return format!("Eq. 9, {ratio:.2} radii");
    }
    let length = s.shear_lag_length(DEFAULT_BUNDLE_DIAMETER, AIR_DRY_PERCENT, Fallback::Estimate);
    match length {
        Ok(length) => format!("shear lag, {:.1} mm", length.value * 1e3),
        Err(_) => "–".to_owned(),
    }
}

const EXPLANATION: &str = "Values of clear wood at 12 % moisture: the *Wood Handbook*'s, those of nine European species, and of the \
four of Yang 2019. The height of a broken face comes from Eq. 9 of Yang \
2019 for the four species it was fitted to, and from the shear-lag length of a fibre bundle 1 mm wide for the others.";

fn table() -> String {
    let rows: Vec<[String; 8]> = Species::all().iter().map(cells).collect();
    let mut widths = HEADINGS.map(|h| h.chars().count());
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let line = |cells: [&str; 8]| {
        let mut line = String::new();
        for (i, (cell, width)) in cells.iter().zip(widths).enumerate() {
            let _ = match i {
                0 | 1 | 7 => write!(line, "{cell:width$}  "),
                _ => write!(line, "{cell:>width$}  "),
            };
        }
        line.trim_end().to_owned() + "\n"
    };
    let mut text = line(HEADINGS);
    for row in &rows {
        text.push_str(&line(std::array::from_fn(|i| row[i].as_str())));
    }
    let _ = write!(
        text,
        "\n{EXPLANATION}\n`greenstick species NAME` shows everything about one.\n"
    );
    text
}

fn markdown() -> String {
    let mut page = format!(
        "# Species\n\n{EXPLANATION} `greenstick species NAME` prints everything that is known about one, \
         `--json` with every digit. Sources are listed in `crates/wood/data/SOURCES.md`.\n\n| {} |\n|{}\n",
        HEADINGS.join(" | "),
        "---|".repeat(HEADINGS.len())
    );
    for s in Species::all() {
        let _ = writeln!(page, "| {} |", cells(s).join(" | "));
    }
    page
}

fn one(s: &Species) -> String {
    let mut text = String::new();
    let group = match s.group {
        Group::Hardwood => "hardwood",
        Group::Softwood => "softwood",
    };
    let _ = writeln!(text, "{} ({}), {group}", s.name, s.scientific_name);
    let _ = writeln!(text, "from {}\n", s.source);
    write_properties(&mut text, s);
    let mut fact = |name: &str, value: Option<f64>, scale: f64, unit: &str| {
        if let Some(value) = value {
            let _ = writeln!(text, "{name:50}{:>12}  {unit}", significant(value / scale));
        }
    };
    fact("density at 12 %", s.air_dry_density, 1.0, "kg/m³");
    fact("end hardness", s.end_hardness, 1.0, "N");
    fact("splitting resistance", s.splitting_resistance, 1.0, "N/m");
    fact(
        "radial shrinkage, green to oven-dry",
        s.shrinkage.radial,
        0.01,
        "%",
    );
    fact("tangential shrinkage", s.shrinkage.tangential, 0.01, "%");
    fact("volumetric shrinkage", s.shrinkage.volumetric, 0.01, "%");
    fact(
        "moisture of green heartwood",
        s.green_heartwood_percent,
        1.0,
        "%",
    );
    fact(
        "moisture of green sapwood",
        s.green_sapwood_percent,
        1.0,
        "%",
    );
    fact(
        "moisture below which strength rises",
        Some(s.intersection_percent()),
        1.0,
        "%",
    );
    let _ = writeln!(
        text,
        "{:50}{}",
        "height of the broken face, air-dry",
        rule(s)
    );
    text
}

/// Writes the table of mechanical properties, dry and green.
fn write_properties(text: &mut String, s: &Species) {
    let _ = writeln!(text, "{:50}{:>12}{:>12}", "", "12 %", "green");
    let mut estimates = false;
    for property in Property::ALL {
        let (scale, unit) = shown_in(property);
        let value = |x: Option<f64>| x.map_or("–".to_owned(), |x| significant(x / scale));
        let (green, spread) = match s.property_at(property, WETTEST_PERCENT, Fallback::Estimate) {
            Ok(green) => match green.basis {
                Basis::Estimate { error_percent } => {
                    estimates = true;
                    (Some(green.value), format!("  ± {error_percent} %"))
                }
                Basis::TableGreen => (Some(green.value), String::new()),
                _ => (None, String::new()),
            },
            // The dry row lacks what the green row may have.
            Err(_) => (
                s.green.as_ref().and_then(|g| g.get(property)),
                String::new(),
            ),
        };
        let _ = writeln!(
            text,
            "{:50}{:>12}{:>12}  {unit}{spread}",
            property.name(),
            value(s.dry.get(property)),
            value(green),
        );
    }
    let gravity = |x: Option<f64>| x.map_or("–".to_owned(), significant);
    let _ = writeln!(
        text,
        "{:50}{:>12}{:>12}\n",
        "specific gravity",
        gravity(s.dry.specific_gravity),
        gravity(green_gravity(s)),
    );
    if estimates {
        let _ = writeln!(text, "{}\n", estimate_note(s.group));
    }
}

/// Returns the specific gravity of green wood: the table's, or estimated like the other green values.
fn green_gravity(s: &Species) -> Option<f64> {
    let ratio = GreenRatio::of_specific_gravity(s.group).map(|r| r.ratio);
    match &s.green {
        Some(green) => green.specific_gravity,
        None => s
            .dry
            .specific_gravity
            .zip(ratio)
            .map(|(dry, ratio)| dry * ratio),
    }
}

/// Says what the green values with a spread are.
fn estimate_note(group: Group) -> String {
    let (group_name, count) = match GreenRatio::of_property(group, Property::ModulusOfRupture) {
        Some(ratio) if group == Group::Hardwood => ("hardwoods", ratio.species),
        Some(ratio) => ("softwoods", ratio.species),
        None => ("woods", 0),
    };
    format!(
        "Green values with ± are estimates: the 12 % value times the mean ratio of green to dry wood in the {count}\n\
         {group_name} that are known both ways, modulus of rupture from compression along the grain; ± is the error when each\n\
         of those is left out in turn."
    )
}

/// Returns the unit in which a property is shown, and its size in SI units.
fn shown_in(property: Property) -> (f64, &'static str) {
    match property {
        Property::ModulusOfElasticity => (1e9, "GPa"),
        Property::WorkToMaximumLoad => (1e3, "kJ/m³"),
        Property::ImpactHeight => (1e-3, "mm"),
        Property::SideHardness => (1.0, "N"),
        _ => (1e6, "MPa"),
    }
}

/// Formats a number with at most four significant digits.
fn significant(x: f64) -> String {
    let decimals = (3 - x.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_at_most() {
        let cases = [
            (105.0, "105"),
            (12.34567, "12.35"),
            (0.62, "0.62"),
            (7340.0, "7340"),
            (0.0, "0"),
        ];
        for (x, text) in cases {
            assert_eq!(significant(x), text);
        }
    }

    #[test]
    fn every_species_has_a_row_with_a_rule() {
        let page = markdown();
        for s in Species::all() {
            let row = page
                .lines()
                .find(|l| l.starts_with(&format!("| {} |", s.name)));
            let row = row.unwrap_or_else(|| panic!("{} has no row", s.name));
            assert_eq!(row.matches('|').count(), HEADINGS.len() + 1);
        }
        assert_eq!(page.matches("Eq. 9, ").count(), 4);
    }
}
