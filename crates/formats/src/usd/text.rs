//! A layer as text (`.usda`), for stills: what a binary file holds already has no text.

use super::layer::{Content, Layer, Prim, Property, Value};
use std::fmt::{Display, Write};

/// The layer as text.
pub fn write(layer: &Layer) -> String {
    let mut out = String::from("#usda 1.0\n");
    metadata(&mut out, &layer.metadata, 0);
    out.push('\n');
    prim(&mut out, &layer.root, 0);
    out
}

fn indent(out: &mut String, depth: usize) {
    out.extend(std::iter::repeat_n("    ", depth));
}

/// `(key = value …)` on lines of their own, or nothing.
fn metadata(out: &mut String, entries: &[(&'static str, Value)], depth: usize) {
    if entries.is_empty() {
        return;
    }
    out.push_str("(\n");
    for (key, value) in entries {
        indent(out, depth + 1);
        if let Value::Prepended(_) = value {
            out.push_str("prepend ");
        }
        out.push_str(key);
        out.push_str(" = ");
        put(out, value);
        out.push('\n');
    }
    indent(out, depth);
    out.push_str(")\n");
}

fn prim(out: &mut String, prim_: &Prim, depth: usize) {
    indent(out, depth);
    put_all(out, &["def ", prim_.kind, " \"", &prim_.name, "\""]);
    if prim_.metadata.is_empty() {
        out.push('\n');
    } else {
        out.push(' ');
        metadata(out, &prim_.metadata, depth);
    }
    indent(out, depth);
    out.push_str("{\n");
    for p in &prim_.properties {
        property(out, p, depth + 1);
    }
    for (k, child) in prim_.children.iter().enumerate() {
        if k > 0 || !prim_.properties.is_empty() {
            out.push('\n');
        }
        prim(out, child, depth + 1);
    }
    indent(out, depth);
    out.push_str("}\n");
}

fn property(out: &mut String, property: &Property, depth: usize) {
    indent(out, depth);
    match &property.content {
        Content::Relationship(targets) => {
            put_all(out, &["rel ", &property.name, " = "]);
            list(out, targets, ("[", "]"), |out, t| {
                put_all(out, &["<", t, ">"])
            });
        }
        Content::Attribute {
            kind,
            uniform,
            custom,
            value,
            connection,
            ..
        } => {
            for (word, set) in [("custom ", custom), ("uniform ", uniform)] {
                if *set {
                    out.push_str(word);
                }
            }
            put_all(out, &[kind, " ", &property.name]);
            if let Some(path) = connection {
                put_all(out, &[".connect = <", path, ">"]);
            } else if let Some(value) = value {
                out.push_str(" = ");
                put(out, value);
            }
        }
    }
    if property.metadata.is_empty() {
        out.push('\n');
    } else {
        out.push(' ');
        metadata(out, &property.metadata, depth);
    }
}

fn put_all(out: &mut String, parts: &[&str]) {
    parts.iter().for_each(|p| out.push_str(p));
}

fn list<T>(
    out: &mut String,
    items: &[T],
    (open, close): (&str, &str),
    mut put: impl FnMut(&mut String, &T),
) {
    out.push_str(open);
    for (k, item) in items.iter().enumerate() {
        if k > 0 {
            out.push_str(", ");
        }
        put(out, item);
    }
    out.push_str(close);
}

fn number(out: &mut String, value: &impl Display) {
    // A text takes every character.
    let _ = write!(out, "{value}");
}

fn tuple<T: Display>(out: &mut String, numbers: &[T]) {
    list(out, numbers, ("(", ")"), |out, n| number(out, n));
}

fn quoted(out: &mut String, text: &str) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out.push('"');
}

fn put(out: &mut String, value: &Value) {
    const LIST: (&str, &str) = ("[", "]");
    match value {
        Value::Bool(v) => number(out, v),
        Value::Int64(v) => number(out, v),
        Value::Float(v) => number(out, v),
        Value::Double(v) => number(out, v),
        Value::Token(v) | Value::Text(v) => quoted(out, v),
        Value::Asset(v) => put_all(out, &["@", v, "@"]),
        Value::Float2(v) => tuple(out, v),
        Value::Float3(v) => tuple(out, v),
        Value::Float4(v) => tuple(out, v),
        Value::Double3(v) => tuple(out, v),
        Value::Turn([x, y, z, w]) => tuple(out, &[w, x, y, z]),
        Value::Matrix(rows) => list(out, rows, ("(", ")"), |out, row| tuple(out, row)),
        Value::Tokens(v) | Value::Prepended(v) => list(out, v, LIST, |out, t| quoted(out, t)),
        Value::Ints(v) => list(out, v, LIST, number),
        Value::Floats(v) => list(out, v, LIST, number),
        Value::Doubles(v) => list(out, v, LIST, number),
        Value::Float2s(v) => list(out, v, LIST, |out, n| tuple(out, n)),
        Value::Float3s(v) => list(out, v, LIST, |out, n| tuple(out, n)),
        Value::Float4s(v) => list(out, v, LIST, |out, n| tuple(out, n)),
        // Only films store values, and films are binary.
        Value::Stored(_) => out.push_str("None"),
    }
}
