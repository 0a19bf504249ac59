//! Hexahedra with data of their own: an unstructured grid.

use super::fields::Field;
use super::piece::{CellArray, Piece};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::Metadata;

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
    let (points, count) = (grid.points.len(), grid.cells.len());
    let corners = || grid.cells.as_flattened().iter().copied();
    if let Some(i) = corners().find(|&i| i as usize >= points) {
        let right = format!("a number below {points}");
        return Err(file.unwritable(format!("a hexahedron has the point {i}"), right));
    }
    let arrays = vec![
        CellArray::integers("connectivity", corners()),
        CellArray::integers("offsets", (1..=count as u32).map(|k| 8 * k)),
        CellArray::bytes("types", &vec![HEXAHEDRON; count]),
    ];
    let piece = Piece {
        kind: "UnstructuredGrid",
        counts: format!("NumberOfCells=\"{count}\""),
        points: grid.points,
        point_data: grid.point_data,
        cell_data: grid.cell_data,
        cells: ("Cells", arrays),
        metadata: Some(grid.metadata),
    };
    piece.check(count, file)?;
    Ok(piece.write(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_geometry::Values;

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
