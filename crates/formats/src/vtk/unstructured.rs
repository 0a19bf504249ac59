//! Hexahedra with data of their own: an unstructured grid.

use super::appended::{Appended, CompressedArray, add_array, bytes_of, field_data, file_start};
use super::fields::{Field, check_fields, compress_fields};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::{Metadata, Values};

/// The VTK type of a hexahedron.
const HEXAHEDRON: u8 = 12;

/// Hexahedra through points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hexahedra<'a> {
    /// Points, m.
    pub points: &'a [DVec3],
    /// Corners of each: four around one face, then those above them.
    pub cells: &'a [[u32; 8]],
    /// Data of the points.
    pub point_data: &'a [Field],
    /// Data of the hexahedra.
    pub cell_data: &'a [Field],
    /// Where they come from.
    pub metadata: &'a Metadata,
}

/// Writes hexahedra as a `.vtu` file.
///
/// # Errors
/// [`FormatError::Unwritable`] if a hexahedron has a point that does not exist, a field has the wrong number of values, or a
/// number is not finite.
pub fn write_hexahedra(grid: &Hexahedra, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    check(grid, file)?;
    let (points, cells) = (grid.points.len(), grid.cells.len());
    let integers = |list: &mut dyn Iterator<Item = usize>| -> CompressedArray {
        let bytes: Vec<u8> = list.flat_map(|i| (i as i64).to_le_bytes()).collect();
        CompressedArray::new(&bytes)
    };
    let coordinates = Values::F64(grid.points.iter().flat_map(|p| p.to_array()).collect());
    let coordinates = CompressedArray::new(&bytes_of(&coordinates).1);
    let corners = integers(&mut grid.cells.as_flattened().iter().map(|&i| i as usize));
    let ends = integers(&mut (1..=cells).map(|k| 8 * k));
    let types = CompressedArray::new(&vec![HEXAHEDRON; cells]);
    let point_data = compress_fields(grid.point_data);
    let cell_data = compress_fields(grid.cell_data);
    let mut appended = Appended::default();
    let mut text = file_start("UnstructuredGrid", "1.0");
    text += &format!(
        "  <UnstructuredGrid>\n{}    <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n",
        field_data(grid.metadata)
    );
    for (kind, fields) in [("PointData", &point_data), ("CellData", &cell_data)] {
        text += &format!("      <{kind}>\n");
        for field in fields {
            add_array(&mut text, &mut appended, &field.attributes, &field.array);
        }
        text += &format!("      </{kind}>\n");
    }
    text += "      <Points>\n";
    let attributes = "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"";
    add_array(&mut text, &mut appended, attributes, &coordinates);
    text += "      </Points>\n      <Cells>\n";
    for (kind, name, array) in [
        ("Int64", "connectivity", &corners),
        ("Int64", "offsets", &ends),
        ("UInt8", "types", &types),
    ] {
        let attributes = format!("type=\"{kind}\" Name=\"{name}\"");
        add_array(&mut text, &mut appended, &attributes, array);
    }
    text += "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n";
    Ok(Encoded {
        name: name.to_owned(),
        bytes: appended.finish(text),
    })
}

/// Refuses invalid hexahedra and fields.
fn check(grid: &Hexahedra, file: InFile) -> Result<(), FormatError> {
    let points = grid.points.len();
    let corners = grid.cells.as_flattened().iter();
    if let Some(i) = corners.copied().find(|&i| i as usize >= points) {
        let right = format!("a number below {points}");
        return Err(file.unwritable(format!("a hexahedron has the point {i}"), right));
    }
    if let Some(i) = grid.points.iter().position(|p| !p.is_finite()) {
        let found = format!("point {i} lies at {}", grid.points[i]);
        return Err(file.unwritable(found, "finite coordinates"));
    }
    check_fields(grid.point_data, points, file)?;
    check_fields(grid.cell_data, grid.cells.len(), file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_written_and_what_is_wrong_refused() {
        let points: Vec<DVec3> = (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let metadata = Metadata::default();
        let cells = [[0, 1, 3, 2, 4, 5, 7, 6]];
        let wrong = [[0, 1, 3, 2, 4, 5, 7, 8]];
        let density = [Field::scalar("density_kg_m3", Values::F64(vec![500.0]))];
        let grid = |cells| Hexahedra {
            points: &points,
            cells,
            point_data: &[],
            cell_data: &density,
            metadata: &metadata,
        };
        let file = write_hexahedra(&grid(&cells), "cube.vtu").unwrap();
        let text = String::from_utf8_lossy(&file.bytes);
        assert!(text.contains("NumberOfPoints=\"8\" NumberOfCells=\"1\""));
        assert!(text.contains("Name=\"density_kg_m3\" NumberOfComponents=\"1\""));
        let error = write_hexahedra(&grid(&wrong), "cube.vtu").unwrap_err();
        assert!(error.to_string().contains("has the point 8"), "{error}");
    }
}
