//! Reading a recipe's TOML, with the line of whatever is wrong.

use super::{Problem, Recipe, RecipeError};
use crate::parameters::{Crack, ParameterError, Parameters, Value};
use greenstick_wood::spelling::closest_names;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const ENTRIES: [&str; 6] = [
    "preset",
    "species",
    "moisture",
    "break",
    "crack_groups",
    "crack",
];

/// What is wrong and the bytes of the text it stands at.
type Located = (Range<usize>, Problem);

/// Puts `text` over `recipe`.
pub(super) fn apply(
    recipe: &mut Recipe,
    text: &str,
    with_presets: bool,
) -> Result<(), RecipeError> {
    entries(recipe, text, with_presets).map_err(|(span, problem)| {
        let before = text.get(..span.start).unwrap_or(text);
        let last = before.rsplit('\n').next().unwrap_or_default();
        RecipeError::At {
            line: before.matches('\n').count() + 1,
            column: last.chars().count() + 1,
            problem,
        }
    })
}

fn entries(recipe: &mut Recipe, text: &str, with_presets: bool) -> Result<(), Located> {
    let document = DeTable::parse(text).map_err(|e| {
        (
            e.span().unwrap_or(0..0),
            Problem::Syntax(e.message().replace('\n', ", ")),
        )
    })?;
    let table = document.get_ref();
    for key in table.keys() {
        let name: &str = key.get_ref();
        if !ENTRIES.contains(&name) {
            // A parameter at the top of the file was meant for [break].
            let mut near = closest_names(name, ENTRIES);
            if recipe
                .face
                .list()
                .iter()
                .any(|p| p.key.split('.').next() == Some(name))
            {
                near.insert(0, format!("[break] {name}"));
            }
            let problem = Problem::UnknownEntry {
                key: name.to_owned(),
                nearest: near,
            };
            return Err((key.span(), problem));
        }
    }
    // Presets first, wherever they stand in the file.
    if let (Some(value), true) = (table.get("preset"), with_presets) {
        presets(recipe, value)?;
    }
    if let Some(value) = table.get("species") {
        let name = string("species", value)?;
        recipe.set_species(name).map_err(|p| (value.span(), p))?;
    }
    if let Some(value) = table.get("moisture") {
        let percent = match scalar("moisture", value)? {
            Value::Number(x) => x,
            Value::Integer(n) => n as f64,
            Value::Text(_) => return Err(wrong_type("moisture", value, "a number, in percent")),
        };
        recipe
            .set_moisture(percent)
            .map_err(|p| (value.span(), p))?;
    }
    if let Some(value) = table.get("break") {
        parameters("", sub_table("break", value)?, &mut |key, v| {
            recipe.face.set(key, v)
        })?;
        // What holds between parameters is checked with the whole; here it has a line to be told
        // with.
        recipe
            .face
            .consistent()
            .map_err(|e| (value.span(), e.into()))?;
    }
    let settings = &mut recipe.cracks.settings;
    if let Some(value) = table.get("crack_groups") {
        parameters("", sub_table("crack_groups", value)?, &mut |key, v| {
            settings.set(key, v)
        })?;
        settings
            .consistent()
            .map_err(|e| (value.span(), e.into()))?;
    }
    if let Some(value) = table.get("crack") {
        recipe.cracks.cracks = cracks(value)?;
    }
    Ok(())
}

fn presets(recipe: &mut Recipe, value: &Spanned<DeValue>) -> Result<(), Located> {
    let one = std::slice::from_ref(value);
    let names: &[Spanned<DeValue>] = match value.get_ref() {
        DeValue::Array(array) => array,
        _ => one,
    };
    for name in names {
        let word = string("preset", name)?;
        recipe.apply_preset(word).map_err(|p| (name.span(), p))?;
    }
    Ok(())
}

fn cracks(value: &Spanned<DeValue>) -> Result<Vec<Crack>, Located> {
    let DeValue::Array(array) = value.get_ref() else {
        return Err(wrong_type(
            "crack",
            value,
            "a list of tables, written [[crack]]",
        ));
    };
    let mut list = Vec::new();
    for entry in array {
        let table = sub_table("crack", entry)?;
        let kind = table.get("kind").ok_or_else(|| {
            let problem = ParameterError::Choice {
                key: "kind".to_owned(),
                found: String::new(),
                options: Crack::KINDS.join(", "),
            };
            (entry.span(), problem.into())
        })?;
        let mut crack =
            Crack::of_kind(string("kind", kind)?).map_err(|e| (kind.span(), e.into()))?;
        parameters("", table, &mut |key, v| {
            if key == "kind" {
                Ok(())
            } else {
                crack.set(key, v)
            }
        })?;
        crack.check().map_err(|e| (entry.span(), e.into()))?;
        list.push(crack);
    }
    Ok(list)
}

/// Hands every value of a table to `set`, keys of nested tables joined by dots.
fn parameters(
    prefix: &str,
    table: &DeTable,
    set: &mut dyn FnMut(&str, &Value) -> Result<(), ParameterError>,
) -> Result<(), Located> {
    for (name, value) in table {
        let key = format!("{prefix}{}", name.get_ref());
        if let DeValue::Table(nested) = value.get_ref() {
            parameters(&format!("{key}."), nested, set)?;
            continue;
        }
        let read = scalar(&key, value)?;
        set(&key, &read).map_err(|e| {
            // An unknown key is wrong itself; otherwise its value is.
            let unknown = matches!(e, ParameterError::UnknownKey { .. });
            (if unknown { name.span() } else { value.span() }, e.into())
        })?;
    }
    Ok(())
}

fn scalar(key: &str, value: &Spanned<DeValue>) -> Result<Value, Located> {
    match value.get_ref() {
        DeValue::String(text) => Ok(Value::Text(text.to_string())),
        DeValue::Float(x) => match x.as_str().parse() {
            Ok(x) => Ok(Value::Number(x)),
            Err(_) => Err(wrong_type(key, value, "a number")),
        },
        DeValue::Integer(n) => {
            // Negative numbers are no counts but may be real numbers.
            let (digits, radix) = (n.as_str(), n.radix());
            match (
                u64::from_str_radix(digits, radix),
                i64::from_str_radix(digits, radix),
            ) {
                (Ok(n), _) => Ok(Value::Integer(n)),
                (_, Ok(n)) => Ok(Value::Number(n as f64)),
                _ => Err(wrong_type(key, value, "a number of 64 bits at most")),
            }
        }
        _ => Err(wrong_type(key, value, "a number or a word")),
    }
}

fn string<'a>(key: &str, value: &'a Spanned<DeValue>) -> Result<&'a str, Located> {
    value
        .get_ref()
        .as_str()
        .ok_or_else(|| wrong_type(key, value, "a word in quotes"))
}

fn sub_table<'a, 'i>(
    key: &str,
    value: &'a Spanned<DeValue<'i>>,
) -> Result<&'a DeTable<'i>, Located> {
    value
        .get_ref()
        .as_table()
        .ok_or_else(|| wrong_type(key, value, "a table"))
}

fn wrong_type(key: &str, value: &Spanned<DeValue>, expected: &'static str) -> Located {
    let found = match value.get_ref() {
        DeValue::String(_) => "a word",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    };
    (
        value.span(),
        Problem::Type {
            key: key.to_owned(),
            found,
            expected,
        },
    )
}
