//! Writer of text layers (`.usda`) for static scenes. Values that are stored in a binary file have no text form.

use super::layer::{Content, DOCUMENTATION, Layer, Metadatum, Prim, Property, Value};
use std::fmt::{Display, Write};

/// Formats a layer as text.
pub(super) fn write(layer: &Layer) -> String {
    let mut out = String::from("#usda 1.0\n");
    metadata(&mut out, &layer.metadata, 0);
    out.push('\n');
    prim(&mut out, &layer.root, 0);
    out
}

/// Appends the indentation of a depth.
fn indent(out: &mut String, depth: usize) {
    out.extend(std::iter::repeat_n("    ", depth));
}

/// Appends metadata, `(key = value …)` on separate lines, or nothing if there are none.
fn metadata(out: &mut String, entries: &[Metadatum], depth: usize) {
    if entries.is_empty() {
        return;
    }
    out.push_str("(\n");
    for Metadatum { key, value } in entries {
        indent(out, depth + 1);
        if let Value::Prepended(_) = value {
            out.push_str("prepend ");
        }
        out.push_str(if *key == DOCUMENTATION { "doc" } else { key });
        out.push_str(" = ");
        put(out, value);
        out.push('\n');
    }
    indent(out, depth);
    out.push_str(")\n");
}

/// Appends a prim with its descendants.
fn prim(out: &mut String, this: &Prim, depth: usize) {
    indent(out, depth);
    put_all(out, &["def ", this.kind, " \"", &this.name, "\""]);
    if this.metadata.is_empty() {
        out.push('\n');
    } else {
        out.push(' ');
        metadata(out, &this.metadata, depth);
    }
    indent(out, depth);
    out.push_str("{\n");
    for p in &this.properties {
        property(out, p, depth + 1);
    }
    for (k, child) in this.children.iter().enumerate() {
        if k > 0 || !this.properties.is_empty() {
            out.push('\n');
        }
        prim(out, child, depth + 1);
    }
    indent(out, depth);
    out.push_str("}\n");
}

/// Appends a property.
fn property(out: &mut String, property: &Property, depth: usize) {
    indent(out, depth);
    match &property.content {
        Content::Relationship(targets) => {
            put_all(out, &["rel ", &property.name, " = "]);
            list(out, targets, Brackets::Square, |out, t| {
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

/// Appends several strings.
fn put_all(out: &mut String, parts: &[&str]) {
    parts.iter().for_each(|p| out.push_str(p));
}

/// Brackets of a list.
#[derive(Clone, Copy)]
enum Brackets {
    Round,
    Square,
}

impl Brackets {
    fn open(self) -> char {
        match self {
            Brackets::Round => '(',
            Brackets::Square => '[',
        }
    }

    fn close(self) -> char {
        match self {
            Brackets::Round => ')',
            Brackets::Square => ']',
        }
    }
}

/// Appends items in brackets, separated by commas.
fn list<T>(
    out: &mut String,
    items: &[T],
    brackets: Brackets,
    mut put: impl FnMut(&mut String, &T),
) {
    out.push(brackets.open());
    for (k, item) in items.iter().enumerate() {
        if k > 0 {
            out.push_str(", ");
        }
        put(out, item);
    }
    out.push(brackets.close());
}

/// Appends a number.
fn number(out: &mut String, value: &impl Display) {
    // Writing to a string cannot fail.
    let _ = write!(out, "{value}");
}

/// Appends a tuple of numbers.
fn tuple<T: Display>(out: &mut String, numbers: &[T]) {
    list(out, numbers, Brackets::Round, |out, n| number(out, n));
}

/// Appends a string in quotes.
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

/// Appends a value.
fn put(out: &mut String, value: &Value) {
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
        Value::Quaternion([x, y, z, w]) => tuple(out, &[w, x, y, z]),
        Value::Matrix(rows) => list(out, rows, Brackets::Round, |out, row| tuple(out, row)),
        Value::Tokens(v) | Value::Prepended(v) => {
            list(out, v, Brackets::Square, |out, t| quoted(out, t))
        }
        Value::Ints(v) => list(out, v, Brackets::Square, number),
        Value::Floats(v) => list(out, v, Brackets::Square, number),
        Value::Doubles(v) => list(out, v, Brackets::Square, number),
        Value::Float2s(v) => list(out, v, Brackets::Square, |out, n| tuple(out, n)),
        Value::Float3s(v) => list(out, v, Brackets::Square, |out, n| tuple(out, n)),
        Value::Float4s(v) => list(out, v, Brackets::Square, |out, n| tuple(out, n)),
        // Only films have stored values, and they are binary.
        Value::Stored(_) => out.push_str("None"),
    }
}
