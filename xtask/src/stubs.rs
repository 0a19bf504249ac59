//! The types of a recipe's keys for Python: `python/greenstick/_keys.pyi`, from what `greenstick parameters --json` prints.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The first lines of the file.
const HEAD: &str = "\
# Written by `cargo xtask generate`; change the declarations, not this file.
\"\"\"The keys of a recipe with their types.\"\"\"

from collections.abc import Sequence
from typing import Any, Literal, TypedDict, overload

from numpy.typing import NDArray

";

/// Longest line of the file that is filled with keys.
const WIDTH: usize = 110;

/// A key of a recipe.
struct Key {
    /// As it is written in brackets.
    name: String,
    doc: String,
    /// What reading it gives.
    read: String,
    /// What it may be set to.
    write: String,
}

/// Returns the file.
pub fn stubs(printed: &str) -> Result<String, String> {
    let tables: Value = serde_json::from_str(printed).map_err(|e| e.to_string())?;
    let keys = keys(&tables)?;
    // Keys without a dot are attributes and keyword arguments.
    let plain: Vec<&Key> = keys.iter().filter(|k| !k.name.contains('.')).collect();
    let mut text = HEAD.to_owned();
    text += "class RequestKeys(TypedDict, total=False):\n";
    text += "    \"\"\"What a request may be given by keyword.\"\"\"\n\n";
    for key in &plain {
        let _ = writeln!(text, "    {}: {}", key.name, key.write);
    }
    text += "\nclass RequestAttributes:\n";
    text += "    \"\"\"The keys of a request, as attributes and in brackets.\"\"\"\n\n";
    for Key {
        name,
        doc,
        read,
        write,
    } in &plain
    {
        let _ = write!(
            text,
            "    @property\n    def {name}(self) -> {read}:\n        \"\"\"{doc}\"\"\"\n    \
             @{name}.setter\n    def {name}(self, value: {write}) -> None: ...\n"
        );
    }
    brackets(&mut text, &keys);
    Ok(text)
}

/// Appends the operators `[]`, by the type of what they give and take.
fn brackets(text: &mut String, keys: &[Key]) {
    let mut types: BTreeMap<(&str, &str), Vec<&str>> = BTreeMap::new();
    for key in keys {
        let names = types.entry((&key.read, &key.write)).or_default();
        names.push(&key.name);
    }
    for ((read, _), names) in &types {
        let _ = write!(
            text,
            "    @overload\n    def __getitem__(self, key: {}) -> {read}: ...\n",
            literal(names)
        );
    }
    text.push_str("    @overload\n    def __getitem__(self, key: str) -> Any: ...\n");
    for ((_, write), names) in &types {
        let _ = write!(
            text,
            "    @overload\n    def __setitem__(self, key: {}, value: {write}) -> None: ...\n",
            literal(names)
        );
    }
    text.push_str(
        "    @overload\n    def __setitem__(self, key: str, value: object) -> None: ...\n",
    );
}

/// `Literal[...]` of names, on several lines.
fn literal(names: &[&str]) -> String {
    let mut text = "Literal[".to_owned();
    let mut line = WIDTH;
    for name in names {
        let item = format!("\"{name}\",");
        if line + item.len() > WIDTH {
            text += "\n        ";
            line = 8;
        } else {
            text.push(' ');
            line += 1;
        }
        line += item.len();
        text += &item;
    }
    text + "\n    ]"
}

/// Every key of the tables that are no lists. Those of the table `break` stand alone unless another has their name.
fn keys(tables: &Value) -> Result<Vec<Key>, String> {
    let mut keys: Vec<Key> = Vec::new();
    for table in tables.as_array().ok_or("expected a list of tables")? {
        let name = table["table"].as_str().unwrap_or_default();
        let prefix = match name {
            "" | "[break]" => String::new(),
            list if list.starts_with("[[") => continue,
            other => format!("{}.", other.trim_matches(['[', ']'])),
        };
        for parameter in table["parameters"].as_array().unwrap_or(&Vec::new()) {
            let key = key(parameter, &prefix)?;
            if keys.iter().all(|k| k.name != key.name) {
                keys.push(key);
            }
        }
    }
    Ok(keys)
}

fn key(parameter: &Value, prefix: &str) -> Result<Key, String> {
    let name = parameter["key"].as_str().ok_or("a parameter has no key")?;
    let kind = &parameter["kind"];
    let (mut read, mut write) = types(kind).ok_or_else(|| format!("{name}: kind {kind}"))?;
    if parameter["auto"] == true {
        (read, write) = (format!("{read} | None"), format!("{write} | None"));
    }
    let unit = kind["number"]["unit"].as_str().unwrap_or_default();
    let doc = parameter["doc"].as_str().unwrap_or_default();
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" Unit: {unit}.")
    };
    Ok(Key {
        name: format!("{prefix}{name}"),
        doc: format!("{doc}{unit}")
            .replace('\\', "\\\\")
            .replace('"', "'"),
        read,
        write,
    })
}

/// What a parameter of a kind gives, and what it takes: numbers also as texts with a unit.
fn types(kind: &Value) -> Option<(String, String)> {
    if kind == "flag" {
        return Some(("bool".to_owned(), "bool".to_owned()));
    }
    let (kind, about) = kind.as_object()?.iter().next()?;
    Some(match kind.as_str() {
        "number" => ("float".to_owned(), "float | str".to_owned()),
        "integer" => ("int".to_owned(), "int | str".to_owned()),
        "text" => ("str".to_owned(), "str | float".to_owned()),
        "choice" => {
            let words = about["options"]
                .as_array()?
                .iter()
                .filter_map(Value::as_str);
            let words: Vec<String> = words.map(|w| format!("\"{w}\"")).collect();
            let literal = format!("Literal[{}]", words.join(", "));
            (literal.clone(), literal)
        }
        "list" => {
            let (of, _) = types(&about["of"])?;
            (
                format!("list[{of}]"),
                format!("Sequence[{of}] | NDArray[Any] | str"),
            )
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_type_and_tables_keep_their_names() {
        let printed = serde_json::json!([
            { "table": "", "parameters": [
                { "key": "rings", "doc": "Say \"12\".", "auto": true, "kind": { "number": { "unit": "m" } } },
            ] },
            { "table": "[break]", "parameters": [
                { "key": "rings", "doc": "Hidden.", "auto": false, "kind": "flag" },
                { "key": "high.height", "doc": "Height.", "auto": false, "kind": { "number": {} } },
            ] },
            { "table": "[heights]", "parameters": [
                { "key": "modes", "doc": "Modes.", "auto": false, "kind": { "list": { "of": { "choice": { "options": ["a", "b"] } } } } },
            ] },
            { "table": "[[crack]]", "parameters": [{ "key": "angle", "kind": "unknown" }] },
        ]);
        let text = stubs(&printed.to_string()).unwrap();
        for expected in [
            "def rings(self) -> float | None:\n        \"\"\"Say '12'. Unit: m.\"\"\"",
            "    rings: float | str | None\n",
            "key: Literal[\n        \"high.height\",\n    ]) -> float",
            "key: Literal[\n        \"heights.modes\",\n    ]) -> list[Literal[\"a\", \"b\"]]",
        ] {
            assert!(text.contains(expected), "{expected}\n{text}");
        }
        assert!(!text.contains("angle") && !text.contains("Hidden"));
        assert!(
            stubs("[{\"table\": \"\", \"parameters\": [{\"key\": \"x\", \"kind\": \"y\"}]}]")
                .is_err()
        );
    }
}
