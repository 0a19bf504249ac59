//! Points with data: every row of a table a vertex, every other column an array.

use super::{Appended, Packed, add, bytes_of, escaped, opening};
use crate::error::{FormatError, InFile};
use crate::table::places;
use greenstick_geometry::Table;

pub(crate) fn write_points(table: &Table, file: InFile) -> Result<Vec<u8>, FormatError> {
    let [x, y, z] = places(table, file)?;
    let rows = table.rows();
    let mut arrays: Vec<(String, Packed)> = Vec::new();
    for column in &table.columns {
        if matches!(column.name.as_str(), "x" | "y" | "z") {
            continue;
        }
        let (kind, bytes) = bytes_of(&column.values);
        let entry = format!("type=\"{kind}\" Name=\"{}\"", escaped(&column.heading()));
        arrays.push((entry, Packed::of(&bytes)));
    }
    let places: Vec<u8> = (0..rows)
        .flat_map(|i| [x[i], y[i], z[i]])
        .flat_map(f64::to_le_bytes)
        .collect();
    let places = Packed::of(&places);
    // Each point is a vertex of its own, so that it is drawn.
    let count = |from: usize| (from..rows + from).flat_map(|i| (i as i64).to_le_bytes());
    let connectivity = Packed::of(&count(0).collect::<Vec<u8>>());
    let offsets = Packed::of(&count(1).collect::<Vec<u8>>());
    let mut appended = Appended::default();
    let mut text = opening("PolyData", "1.0");
    text += &format!(
        "  <PolyData>\n    <Piece NumberOfPoints=\"{rows}\" NumberOfVerts=\"{rows}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n      <PointData>\n"
    );
    for (entry, packed) in &arrays {
        add(&mut text, &mut appended, entry, packed);
    }
    text += "      </PointData>\n      <Points>\n";
    add(
        &mut text,
        &mut appended,
        "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
        &places,
    );
    text += "      </Points>\n      <Verts>\n";
    add(
        &mut text,
        &mut appended,
        "type=\"Int64\" Name=\"connectivity\"",
        &connectivity,
    );
    add(
        &mut text,
        &mut appended,
        "type=\"Int64\" Name=\"offsets\"",
        &offsets,
    );
    text += "      </Verts>\n    </Piece>\n  </PolyData>\n";
    Ok(appended.finish(text))
}
