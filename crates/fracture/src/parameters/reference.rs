//! What is derived from the declarations for people and programs: a reference page and a JSON
//! schema.

use super::{
    BreakParameters, CrackSettings, Kind, ParameterInfo, Parameters, RadialCrack, TangentialCrack,
    Value,
};
use serde_json::{Map, Value as Json, json};

fn range(p: &ParameterInfo) -> String {
    match p.kind {
        Kind::Number { min, max, auto, .. } => {
            let auto = if auto { " or auto" } else { "" };
            format!("{min} … {max}{auto}")
        }
        Kind::Integer { min, max } => format!("{min} … {max}, whole"),
        Kind::Choice { options } => options.join(", "),
    }
}

fn markdown_table(list: &[ParameterInfo], level: &str, page: &mut String) {
    let mut group = "";
    for p in list {
        if p.group != group {
            group = &p.group;
            page.push_str(&format!(
                "\n{level} {}\n\n| key | symbol | unit | range | default | what it does |\n|---|---|---|---|---|---|\n",
                group
            ));
        }
        page.push_str(&format!(
            "| `{}` | {} | {} | {} | {} | {} |\n",
            p.key,
            p.symbol,
            p.unit(),
            range(p),
            p.value,
            p.doc.replace('|', "\\|")
        ));
    }
}

/// The reference page of all parameters, in Markdown.
pub fn reference_markdown() -> String {
    let mut page = String::from("# Parameters\n\n## `[break]`: the broken face\n");
    markdown_table(&BreakParameters::table(), "###", &mut page);
    page.push_str("\n## `[crack_groups]`: cracks drawn at random\n");
    markdown_table(&CrackSettings::table(), "###", &mut page);
    page.push_str("\n## `[[crack]]`: single cracks, of `kind` \"radial\" or \"tangential\"\n");
    markdown_table(&RadialCrack::table(), "###", &mut page);
    markdown_table(&TangentialCrack::table(), "###", &mut page);
    page
}

fn schema_of(p: &ParameterInfo) -> Json {
    let mut schema = match p.kind {
        Kind::Number { min, max, auto, .. } => {
            let number = json!({ "type": "number", "minimum": min, "maximum": max });
            if auto {
                json!({ "anyOf": [number, { "const": "auto" }] })
            } else {
                number
            }
        }
        Kind::Integer { min, max } => json!({ "type": "integer", "minimum": min, "maximum": max }),
        Kind::Choice { options } => json!({ "enum": options }),
    };
    schema["description"] = json!(p.doc);
    schema["default"] = match &p.value {
        Value::Number(x) => json!(x),
        Value::Integer(n) => json!(n),
        Value::Text(t) => json!(t),
    };
    if !p.unit().is_empty() {
        schema["x-unit"] = json!(p.unit());
    }
    if !p.symbol.is_empty() {
        schema["x-symbol"] = json!(p.symbol);
    }
    schema
}

/// An object with the listed parameters; dotted keys become nested objects.
fn object(list: &[ParameterInfo]) -> Json {
    let mut properties = Map::new();
    for p in list {
        match p.key.split_once('.') {
            None => {
                properties.insert(p.key.clone(), schema_of(p));
            }
            Some((group, key)) => {
                let nested = properties.entry(group).or_insert_with(
                    || json!({ "type": "object", "additionalProperties": false, "properties": {} }),
                );
                nested["properties"][key] = schema_of(p);
            }
        }
    }
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

fn crack(kind: &str, list: &[ParameterInfo]) -> Json {
    let mut schema = object(list);
    schema["properties"]["kind"] = json!({ "const": kind });
    schema["required"] = json!(["kind"]);
    schema
}

/// JSON schema (draft 2020-12) of a recipe. In a recipe numbers may also be text with a unit; the
/// schema asks for plain numbers.
pub fn json_schema() -> Json {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Greenstick recipe",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "preset": {
                "description": "Presets to start from, later ones over earlier ones.",
                "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }],
            },
            "species": { "type": "string", "description": "Common or scientific name." },
            "moisture": {
                "type": "number",
                "exclusiveMinimum": 0,
                "maximum": greenstick_wood::moisture::WETTEST_PERCENT,
                "description": "Moisture content, percent of the oven-dry mass.",
            },
            "break": object(&BreakParameters::table()),
            "crack_groups": object(&CrackSettings::table()),
            "crack": { "type": "array", "items": { "oneOf": [
                crack("radial", &RadialCrack::table()),
                crack("tangential", &TangentialCrack::table()),
            ] } },
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_has_every_parameter_with_its_range() {
        let schema = json_schema();
        for p in BreakParameters::table() {
            let pointer = p.key.replace('.', "/properties/");
            let at = schema.pointer(&format!("/properties/break/properties/{pointer}"));
            let at = at.unwrap_or_else(|| panic!("{} is not in the schema", p.key));
            assert_eq!(
                at.get("maximum").and_then(Json::as_f64),
                p.max(),
                "{}",
                p.key
            );
            assert_eq!(at["description"], json!(p.doc));
        }
        let cracks = &schema["properties"]["crack"]["items"]["oneOf"];
        assert_eq!(cracks[1]["properties"]["kind"]["const"], "tangential");
    }

    #[test]
    fn the_reference_page_has_a_row_for_every_parameter() {
        let page = reference_markdown();
        for p in BreakParameters::table()
            .iter()
            .chain(&CrackSettings::table())
        {
            let row = format!("| `{}` | {} |", p.key, p.symbol);
            assert_eq!(page.matches(&row).count(), 1, "{row}");
        }
    }
}
