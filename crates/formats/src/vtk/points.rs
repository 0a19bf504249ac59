//! Points with data: each row of a table is a vertex, each column other than its position an array.

use super::appended::{
    Appended, CompressedArray, add_array, bytes_of, escape, field_data, file_start,
};
use crate::error::{FormatError, InFile};
use crate::table::positions;
use greenstick_geometry::Table;

/// Writes a table as points.
pub(crate) fn write_points(table: &Table, file: InFile) -> Result<Vec<u8>, FormatError> {
    let [x, y, z] = positions(table, file)?;
    let rows = table.rows();
    let mut arrays: Vec<(String, CompressedArray)> = Vec::new();
    for column in &table.columns {
        if matches!(column.name.as_str(), "x" | "y" | "z") {
            continue;
        }
        let (kind, bytes) = bytes_of(&column.values);
        let attributes = format!("type=\"{kind}\" Name=\"{}\"", escape(&column.heading()));
        arrays.push((attributes, CompressedArray::new(&bytes)));
    }
    let coordinates: Vec<u8> = (0..rows)
        .flat_map(|i| [x[i], y[i], z[i]])
        .flat_map(f64::to_le_bytes)
        .collect();
    let coordinates = CompressedArray::new(&coordinates);
    // Each point is a vertex cell, so that it is visible.
    let count = |from: usize| (from..rows + from).flat_map(|i| (i as i64).to_le_bytes());
    let connectivity = CompressedArray::new(&count(0).collect::<Vec<u8>>());
    let offsets = CompressedArray::new(&count(1).collect::<Vec<u8>>());
    let mut appended = Appended::default();
    let mut text = file_start("PolyData", "1.0");
    text += &format!(
        "  <PolyData>\n{}    <Piece NumberOfPoints=\"{rows}\" NumberOfVerts=\"{rows}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n      <PointData>\n",
        field_data(&table.metadata)
    );
    for (attributes, array) in &arrays {
        add_array(&mut text, &mut appended, attributes, array);
    }
    text += "      </PointData>\n      <Points>\n";
    add_array(
        &mut text,
        &mut appended,
        "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
        &coordinates,
    );
    text += "      </Points>\n      <Verts>\n";
    add_array(
        &mut text,
        &mut appended,
        "type=\"Int64\" Name=\"connectivity\"",
        &connectivity,
    );
    add_array(
        &mut text,
        &mut appended,
        "type=\"Int64\" Name=\"offsets\"",
        &offsets,
    );
    text += "      </Verts>\n    </Piece>\n  </PolyData>\n";
    Ok(appended.finish(text))
}
