//! JSON Schema (draft 2020-12) of files of parameters.

use crate::{Kind, ParameterInfo, Parameters, Scale, Unit, Value};
use serde_json::{Map, Value as Json, json};

/// What a length looks like: a number and its unit.
const LENGTH: &str = r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*(mm|cm|m)\s*$";
/// What several lengths look like: the last unit holds for those without one.
const LENGTHS: &str = r"^.*(mm|cm|m)\s*$";

/// The schema of a file that holds a set of parameters.
pub fn document_schema(title: &str, set: &dyn Parameters) -> Json {
    let mut schema = object_schema(set);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(title);
    schema
}

/// The schema of an object that holds a set of parameters.
///
/// Numbers with a unit may also be text that says it. Beside what JSON Schema knows there are `x-unit`, `x-symbol`,
/// `x-stage` (the stage of the work that a change starts at), `x-scale`, `x-labels` and `x-group`.
pub fn object_schema(set: &dyn Parameters) -> Json {
    let variants = set.variants();
    if !variants.is_empty() {
        let all: Vec<Json> = variants.iter().map(|v| plain(v.as_ref())).collect();
        return json!({ "oneOf": all });
    }
    plain(set)
}

fn plain(set: &dyn Parameters) -> Json {
    let mut properties = Map::new();
    for parameter in set.list() {
        let names: Vec<&str> = parameter.key.split('.').collect();
        let mut at = &mut properties;
        for name in &names[..names.len() - 1] {
            at = inner(at, name);
        }
        let name = names[names.len() - 1].to_owned();
        let tagged = set.tag() == Some(&name) && !parameter.key.contains('.');
        let schema = if tagged {
            json!({ "const": parameter.value, "description": parameter.doc })
        } else {
            of(&parameter)
        };
        at.insert(name, schema);
    }
    add_lists(set, &mut properties);
    let mut schema = object(properties);
    if let Some(tag) = set.tag() {
        schema["required"] = json!([tag]);
    }
    schema
}

fn add_lists(set: &dyn Parameters, properties: &mut Map<String, Json>) {
    let mut example = set.defaults();
    for list in set.lists() {
        if let Some(entry) = example.add_entry(list.key) {
            let items = object_schema(entry);
            let schema = json!({ "type": "array", "description": list.doc, "items": items });
            properties.insert(list.key.to_owned(), schema);
        }
    }
    for (name, table) in set.tables() {
        if !table.lists().is_empty() {
            add_lists(table, inner(properties, name));
        }
    }
}

/// An object with the given properties and no others.
fn object(properties: Map<String, Json>) -> Json {
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

/// The properties of an object inside.
fn inner<'a>(properties: &'a mut Map<String, Json>, name: &str) -> &'a mut Map<String, Json> {
    let entry = properties.entry(name).or_insert_with(|| object(Map::new()));
    let inner = entry["properties"].as_object_mut();
    inner.unwrap_or_else(|| unreachable!("objects are made with properties"))
}

/// The schema of one parameter.
fn of(p: &ParameterInfo) -> Json {
    let mut schema = of_kind(&p.kind);
    let mut others: Vec<Json> = p.words.iter().map(|w| json!({ "const": w.0 })).collect();
    if p.auto {
        others.push(json!({ "const": "auto" }));
    }
    if !others.is_empty() {
        others.insert(0, schema);
        schema = json!({ "anyOf": others });
    }
    schema["description"] = json!(p.doc);
    if p.default != Value::Auto || !matches!(p.kind, Kind::Text { .. }) {
        schema["default"] = json!(p.default);
    }
    for (key, value) in [
        ("x-unit", p.unit()),
        ("x-symbol", &p.symbol),
        ("x-stage", p.stage),
        ("x-group", &p.group),
    ] {
        if !value.is_empty() {
            schema[key] = json!(value);
        }
    }
    if p.scale == Scale::Logarithmic {
        schema["x-scale"] = json!("logarithmic");
    }
    if let Kind::Choice { options } = p.kind {
        let labels: Vec<String> = options.iter().map(|o| o.label()).collect();
        schema["x-labels"] = json!(labels);
    }
    schema
}

fn of_kind(kind: &Kind) -> Json {
    match kind {
        Kind::Number {
            unit: Unit::Metre,
            min,
            max,
            ..
        } => {
            let zero = *min <= 0.0 && *max >= 0.0;
            let text = json!({ "type": "string", "pattern": LENGTH });
            let length = json!({ "x-minimum": min, "x-maximum": max });
            let mut schema = length;
            schema["anyOf"] = if zero {
                json!([text, { "const": 0 }])
            } else {
                json!([text])
            };
            schema
        }
        Kind::Number {
            unit,
            min,
            max,
            above,
        } => {
            let mut schema = Map::new();
            let kinds = match unit {
                Unit::One => json!("number"),
                _ => json!(["number", "string"]),
            };
            schema.insert("type".to_owned(), kinds);
            let least = if *above {
                "exclusiveMinimum"
            } else {
                "minimum"
            };
            for (key, bound) in [(least, min), ("maximum", max)] {
                if bound.is_finite() {
                    schema.insert(key.to_owned(), json!(bound));
                }
            }
            Json::Object(schema)
        }
        Kind::Integer { min, max, step, .. } => {
            let bound = |n: &i128| i64::try_from(*n).map_or(json!(*n as f64), |n| json!(n));
            let mut schema =
                json!({ "type": "integer", "minimum": bound(min), "maximum": bound(max) });
            if *step != 1 {
                schema["multipleOf"] = bound(step);
            }
            schema
        }
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Choice { options } => {
            let words: Vec<&str> = options.iter().map(|o| o.word).collect();
            json!({ "enum": words })
        }
        Kind::Text { format } => json!({ "type": ["string", "number"], "x-format": format.name }),
        Kind::List { of, min, max } => {
            let list = json!({ "type": "array", "items": of_kind(of), "minItems": min });
            let mut list = list;
            if *max < usize::MAX {
                list["maxItems"] = json!(max);
            }
            if of.unit() == Unit::Metre {
                return json!({ "anyOf": [{ "type": "string", "pattern": LENGTHS }, list] });
            }
            json!({ "anyOf": [list, { "type": "string" }] })
        }
    }
}
