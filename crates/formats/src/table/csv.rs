//! Comma-separated values (RFC 4180, with line feeds): a header line with units, then numbers with the fewest digits that
//! read back as the same number; the cells of missing ones, NaN, are empty.

use crate::text::push_integer;
use greenstick_geometry::{Table, Values};

/// Writes a table.
pub(super) fn write(table: &Table) -> Vec<u8> {
    let headings: Vec<String> = table.columns.iter().map(|c| c.heading()).collect();
    let mut bytes = headings.join(",").into_bytes();
    bytes.push(b'\n');
    let mut buffer = zmij::Buffer::new();
    for row in 0..table.rows() {
        for (k, column) in table.columns.iter().enumerate() {
            if k > 0 {
                bytes.push(b',');
            }
            match &column.values {
                Values::U8(v) => push_integer(&mut bytes, v[row].into()),
                Values::U32(v) => push_integer(&mut bytes, v[row].into()),
                Values::Text(v) => push_text(&mut bytes, &v[row]),
                Values::F64(v) if v[row].is_nan() => {}
                Values::F64(v) => {
                    let text = buffer.format_finite(v[row]);
                    bytes.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
                }
            }
        }
        bytes.push(b'\n');
    }
    bytes
}

/// Appends a text, in quotes where it has characters that mean something.
fn push_text(bytes: &mut Vec<u8>, text: &str) {
    if text.contains(['"', ',', '\n', '\r']) {
        bytes.extend_from_slice(format!("\"{}\"", text.replace('"', "\"\"")).as_bytes());
    } else {
        bytes.extend_from_slice(text.as_bytes());
    }
}
