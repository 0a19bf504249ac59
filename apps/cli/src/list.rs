//! `greenstick parameters` and `greenstick presets`: what there is, from the declarations.

use crate::arguments::{ParametersOptions, PresetsOptions};
use crate::failure::{Failure, print};
use greenstick::fracture::parameters::{
    BreakParameters, CrackSettings, Kind, ParameterInfo, Parameters, RadialCrack, TangentialCrack,
    json_schema, reference_markdown,
};
use greenstick::fracture::presets::{PRESETS, Preset};
use greenstick::fracture::recipe::Recipe;
use greenstick::wood::spelling::{closest_names, did_you_mean};
use serde::Serialize;
use std::fmt::Write;
use std::process::ExitCode;

/// Most characters in a line of text.
const WIDTH: usize = 100;

/// A table of a recipe and its parameters.
#[derive(Serialize)]
struct Section {
    table: &'static str,
    parameters: Vec<ParameterInfo>,
}

pub fn parameters(options: &ParametersOptions) -> Result<ExitCode, Failure> {
    let sections = sections(options.key.as_deref())?;
    let text = if options.markdown {
        reference_markdown()
    } else if options.schema {
        json(&json_schema())?
    } else if options.json {
        json(&sections)?
    } else {
        sections.iter().map(words).collect()
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// All parameters, or those whose key is `key` or begins with it and a dot.
fn sections(key: Option<&str>) -> Result<Vec<Section>, Failure> {
    let mut sections = vec![
        Section {
            table: "[break]",
            parameters: BreakParameters::table(),
        },
        Section {
            table: "[crack_groups]",
            parameters: CrackSettings::table(),
        },
        Section {
            table: "[[crack]] of kind \"radial\"",
            parameters: RadialCrack::table(),
        },
        Section {
            table: "[[crack]] of kind \"tangential\"",
            parameters: TangentialCrack::table(),
        },
    ];
    let Some(wanted) = key else {
        return Ok(sections);
    };
    let bare = wanted
        .trim_start_matches("break.")
        .trim_start_matches("crack_groups.");
    let known: Vec<String> = sections
        .iter()
        .flat_map(|s| s.parameters.iter().map(|p| p.key.clone()))
        .collect();
    for section in &mut sections {
        section.parameters.retain(|p| {
            p.key
                .strip_prefix(bare)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        });
    }
    sections.retain(|s| !s.parameters.is_empty());
    if sections.is_empty() {
        let groups = known.iter().filter_map(|k| k.split('.').next());
        let mut near = closest_names(wanted, known.iter().map(String::as_str).chain(groups));
        near.dedup();
        return Err(Failure::request(format!(
            "unknown parameter \"{wanted}\"{}",
            did_you_mean(&near)
        ))
        .hint("`greenstick parameters` without a name lists all of them"));
    }
    Ok(sections)
}

fn words(section: &Section) -> String {
    let mut text = format!("{}\n", section.table);
    let mut group = "";
    for p in &section.parameters {
        if p.group != group {
            group = &p.group;
            let _ = writeln!(text, "\n  {group}");
        }
        let symbol = if p.symbol.is_empty() {
            String::new()
        } else {
            format!("  {}", p.symbol)
        };
        let _ = writeln!(text, "    {} = {}  ({}){symbol}", p.key, p.value, range(p));
        for line in wrapped(&p.doc, WIDTH - 8) {
            let _ = writeln!(text, "        {line}");
        }
    }
    text + "\n"
}

fn range(p: &ParameterInfo) -> String {
    let unit = match p.unit() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    match p.kind {
        Kind::Number { min, max, auto, .. } => {
            let auto = if auto { ", or auto" } else { "" };
            format!("{min} to {max}{unit}{auto}")
        }
        Kind::Integer { min, max } => format!("whole, {min} to {max}"),
        Kind::Choice { options } => options.join(", "),
    }
}

/// The text in lines of at most `width` characters.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |l| l.chars().count());
        if last > 0 && last + 1 + word.chars().count() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

pub fn presets(options: &PresetsOptions) -> Result<ExitCode, Failure> {
    let text = match &options.name {
        Some(name) => {
            let mut recipe = Recipe::default();
            recipe.apply_preset(name).map_err(|e| {
                Failure::request(e).hint("`greenstick presets` without a name lists all of them")
            })?;
            if options.json {
                json(&recipe)?
            } else {
                recipe.to_toml()
            }
        }
        None if options.json => json(&PRESETS)?,
        None if options.markdown => presets_markdown(),
        None => presets_words(),
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn presets_words() -> String {
    let width = PRESETS.iter().map(|p| p.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for p in PRESETS {
        for (i, line) in wrapped(p.summary, WIDTH - width - 2).iter().enumerate() {
            let name = if i == 0 { p.name } else { "" };
            let _ = writeln!(text, "{name:width$}  {line}");
        }
    }
    text
}

/// What a preset changes against the defaults.
fn changes(preset: &Preset) -> Vec<String> {
    let (plain, mut recipe) = (Recipe::default(), Recipe::default());
    if recipe.apply_preset(preset.name).is_err() {
        return Vec::new();
    }
    let differences = |before: Vec<ParameterInfo>, after: Vec<ParameterInfo>, prefix: &str| {
        before
            .into_iter()
            .zip(after)
            .filter(|(b, a)| a.value != b.value)
            .map(|(_, a)| format!("`{prefix}{}={}`", a.key, a.value))
            .collect::<Vec<String>>()
    };
    let mut changed = differences(plain.face.list(), recipe.face.list(), "");
    changed.extend(differences(
        plain.cracks.settings.list(),
        recipe.cracks.settings.list(),
        "crack_groups.",
    ));
    let single = recipe.cracks.cracks.len();
    if single > 0 {
        changed.push(format!("{single} single cracks"));
    }
    changed
}

fn presets_markdown() -> String {
    let mut page = String::from(
        "# Presets\n\nEach is asked for with `--preset NAME`; `greenstick presets NAME` prints it as a recipe. \
         Presets of breaks replace the whole face, presets of cracks replace all cracks, so that one of each can be \
         put together.\n\n| preset | what it gives |\n|---|---|\n",
    );
    for p in PRESETS {
        let _ = writeln!(page, "| `{}` | {} |", p.name, p.summary);
    }
    page.push_str("\n## What they change against the defaults\n");
    for p in PRESETS {
        let _ = writeln!(page, "\n### {}\n\n{}", p.name, changes(p).join(", "));
    }
    page
}

/// As JSON text.
pub fn json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| Failure::work(format!("cannot be put into JSON: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_changes_something_and_can_be_set_by_hand() {
        for preset in PRESETS {
            let changed = changes(preset);
            assert!(!changed.is_empty(), "{}", preset.name);
            let settings: Vec<String> = changed
                .iter()
                .filter(|c| c.contains('='))
                .map(|c| c.trim_matches('`').to_owned())
                .collect();
            let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
            let by_hand = Recipe::resolve(&[], None, &settings).unwrap();
            let by_name = Recipe::resolve(&[preset.name], None, &[]).unwrap();
            assert_eq!(by_hand.face, by_name.face, "{}", preset.name);
            assert_eq!(by_hand.cracks.settings, by_name.cracks.settings);
        }
    }

    #[test]
    fn lines_are_broken_between_words() {
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
        assert_eq!(wrapped("incomprehensible a", 5), ["incomprehensible", "a"]);
    }
}
