//! Points in binary PLY, little-endian. Positions are in single precision, as most readers expect, unless they are so far
//! from the origin that it would cost their details; other columns keep their type.

use super::positions::positions;
use crate::error::{FormatError, InFile};
use greenstick_geometry::{Table, Values};

/// Greatest coordinate in single precision, m: numbers there are a quarter of a millimetre apart.
const MAX_SINGLE: f64 = 4096.0;

/// Writes a table as points.
pub(super) fn write_ply(table: &Table, file: InFile) -> Result<Vec<u8>, FormatError> {
    let positions = positions(table, file)?;
    let others: Vec<_> = table
        .columns
        .iter()
        .filter(|c| !matches!(c.name.as_str(), "x" | "y" | "z"))
        .collect();
    let far = positions
        .iter()
        .any(|list| list.iter().any(|x| x.abs() > MAX_SINGLE));
    let mut header =
        "ply\nformat binary_little_endian 1.0\ncomment by Greenstick, in m\n".to_owned();
    for line in table.metadata.lines() {
        header += &format!("comment {line}\n");
    }
    for c in &others {
        let unit = if c.unit.is_empty() { "1" } else { &c.unit };
        header += &format!(
            "comment {} [{unit}]: {}\n",
            c.name,
            c.meaning.replace(char::is_control, " ")
        );
    }
    header += &format!("element vertex {}\n", table.rows());
    for name in ["x", "y", "z"] {
        let kind = if far { "double" } else { "float" };
        header += &format!("property {kind} {name}\n");
    }
    for c in &others {
        let kind = match c.values {
            Values::U8(_) => "uchar",
            Values::U32(_) => "uint",
            Values::F64(_) => "double",
            // Refused before.
            Values::Text(_) => continue,
        };
        header += &format!("property {kind} {}\n", c.name);
    }
    let mut bytes = header.into_bytes();
    bytes.extend_from_slice(b"end_header\n");
    for row in 0..table.rows() {
        for list in positions {
            if far {
                bytes.extend_from_slice(&list[row].to_le_bytes());
            } else {
                bytes.extend_from_slice(&(list[row] as f32).to_le_bytes());
            }
        }
        for c in &others {
            match &c.values {
                Values::U8(v) => bytes.push(v[row]),
                Values::U32(v) => bytes.extend_from_slice(&v[row].to_le_bytes()),
                Values::F64(v) => bytes.extend_from_slice(&v[row].to_le_bytes()),
                Values::Text(_) => {}
            }
        }
    }
    Ok(bytes)
}
