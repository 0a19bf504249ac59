//! `greenstick parameters`, `greenstick schema` and `greenstick presets`: lists made from the declarations.

use crate::arguments::{ParametersOptions, PresetsOptions, SchemaOptions};
use crate::failure::{Failure, print};
use greenstick::RequestFile;
use greenstick::SectionRingSettings;
use greenstick::anatomy::AnatomyFile;
use greenstick::fibre::scene::Scene;
use greenstick::fracture::parameters::{RadialCrack, TangentialCrack};
use greenstick::fracture::presets::{PRESETS, Preset};
use greenstick::fracture::recipe::{Recipe, apply_preset};
use greenstick::schema::{
    ParameterInfo, Parameters, closest_names, did_you_mean, document_schema, markdown_tables,
};
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;
use std::process::ExitCode;

/// Maximum number of characters in a line.
const MAX_LINE_WIDTH: usize = 100;

/// A table of a recipe and its parameters.
#[derive(Serialize)]
struct Section {
    table: &'static str,
    #[serde(skip)]
    title: &'static str,
    parameters: Vec<ParameterInfo>,
}

pub fn parameters(options: &ParametersOptions) -> Result<ExitCode, Failure> {
    let sections = sections(options.key.as_deref())?;
    let text = if options.markdown {
        parameters_markdown(&sections)
    } else if options.schema {
        json(&RequestFile::schema())?
    } else if options.json {
        json(&sections)?
    } else {
        sections.iter().map(format_section).collect()
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the schemas of all kinds of file that hold parameters, with their names.
fn schemas() -> Vec<(&'static str, Value)> {
    vec![
        ("break", RequestFile::schema()),
        (
            "anatomy",
            document_schema("Greenstick anatomy", &AnatomyFile::default()),
        ),
        (
            "rings",
            document_schema("Greenstick rings", &SectionRingSettings::default()),
        ),
        (
            "scene",
            document_schema("Greenstick scene", &Scene::default()),
        ),
    ]
}

pub fn schema(options: &SchemaOptions) -> Result<ExitCode, Failure> {
    let mut all = schemas();
    let text = match &options.name {
        Some(name) => match all.iter().find(|(known, _)| known == name) {
            Some((_, schema)) => json(schema)?,
            None => {
                let names: Vec<&str> = all.iter().map(|f| f.0).collect();
                return Err(Failure::request(format!("unknown schema \"{name}\""))
                    .hint(format!("there are {}", names.join(", "))));
            }
        },
        None => {
            let mut definitions = Map::new();
            for (name, schema) in &mut all {
                let draft = schema.as_object_mut().and_then(|s| s.remove(DRAFT));
                debug_assert!(draft.is_some());
                definitions.insert((*name).to_owned(), schema.take());
            }
            json(&serde_json::json!({
                DRAFT: "https://json-schema.org/draft/2020-12/schema",
                "title": "Greenstick",
                "$defs": definitions,
            }))?
        }
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Key of the draft that a schema follows.
const DRAFT: &str = "$schema";

fn parameters_markdown(sections: &[Section]) -> String {
    let mut page = String::from(
        "# Parameters\n\nA recipe may hold all of these. Those at the top that are options of `greenstick break` too have \
         the same names there, with hyphens. `[[breaks]]` gives several breaks of one stem: each may have everything that \
         says where and how it breaks, and starts from what stands at the top.\n",
    );
    for section in sections {
        let _ = write!(page, "\n## {}\n", section.title);
        page.push_str(&markdown_tables(&section.parameters, "###"));
    }
    page
}

/// Returns all parameters, or those whose key is `key` or begins with `key` and a dot.
fn sections(key: Option<&str>) -> Result<Vec<Section>, Failure> {
    let of_table = |table: &str| -> Vec<ParameterInfo> {
        let all = RequestFile::table().into_iter();
        all.filter_map(|mut p| {
            let (first, rest) = p.key.split_once('.').unwrap_or(("", &p.key));
            let rest = rest.to_owned();
            (first == table).then(|| {
                p.key = rest;
                p
            })
        })
        .collect()
    };
    let mut sections = vec![
        Section {
            table: "",
            title: "At the top",
            parameters: of_table(""),
        },
        Section {
            table: "[break]",
            title: "`[break]`: the broken face",
            parameters: of_table("break"),
        },
        Section {
            table: "[heights]",
            title: "`[heights]`: heights of the face that were measured, simulated or painted",
            parameters: of_table("heights"),
        },
        Section {
            table: "[crack_groups]",
            title: "`[crack_groups]`: cracks drawn at random",
            parameters: of_table("crack_groups"),
        },
        Section {
            table: "[[crack]] of kind \"radial\"",
            title: "`[[crack]]` of `kind` \"radial\": single cracks along rays",
            parameters: RadialCrack::table(),
        },
        Section {
            table: "[[crack]] of kind \"tangential\"",
            title: "`[[crack]]` of `kind` \"tangential\": single cracks along rings",
            parameters: TangentialCrack::table(),
        },
    ];
    let Some(wanted) = key else {
        return Ok(sections);
    };
    let bare = wanted
        .trim_start_matches("break.")
        .trim_start_matches("heights.")
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

/// Formats a section as text.
fn format_section(section: &Section) -> String {
    let mut text = match section.table {
        "" => String::new(),
        table => format!("{table}\n"),
    };
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
        for line in wrapped(&p.doc, MAX_LINE_WIDTH - 8) {
            let _ = writeln!(text, "        {line}");
        }
    }
    text + "\n"
}

fn range(p: &ParameterInfo) -> String {
    let mut parts = vec![p.kind.range()];
    if parts[0].is_empty() {
        parts[0] = p.kind.placeholder();
    }
    parts.extend(p.words.iter().map(|w| w.0.to_owned()));
    parts.extend(p.auto.then(|| "auto".to_owned()));
    parts.join(", or ")
}

/// Wraps text to lines of at most `width` characters.
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
            apply_preset(&mut recipe, name).map_err(|e| {
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
        None => format_presets(),
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Formats the list of presets as text.
fn format_presets() -> String {
    let width = PRESETS.iter().map(|p| p.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for p in PRESETS {
        for (i, line) in wrapped(p.summary, MAX_LINE_WIDTH - width - 2)
            .iter()
            .enumerate()
        {
            let name = if i == 0 { p.name } else { "" };
            let _ = writeln!(text, "{name:width$}  {line}");
        }
    }
    text
}

/// Lists the parameters for which a preset differs from the defaults.
fn changes(preset: &Preset) -> Vec<String> {
    let (plain, mut recipe) = (Recipe::default(), Recipe::default());
    if apply_preset(&mut recipe, preset.name).is_err() {
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
        "# Presets\n\n`--preset NAME` selects one; `greenstick presets NAME` prints it as a recipe. \
         Presets of breaks replace the whole face, presets of cracks replace all cracks, so that one of each can be \
         combined.\n\n| preset | what it gives |\n|---|---|\n",
    );
    for p in PRESETS {
        let _ = writeln!(page, "| `{}` | {} |", p.name, p.summary);
    }
    page.push_str("\n## How they differ from the defaults\n");
    for p in PRESETS {
        let _ = writeln!(page, "\n### {}\n\n{}", p.name, changes(p).join(", "));
    }
    page
}

/// Converts a value to JSON text.
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
