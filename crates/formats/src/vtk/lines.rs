//! Polylines with data: rods, or bonds as lines of two points.

use super::fields::Field;
use super::piece::{CellArray, Piece};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::Metadata;

/// Polylines through points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polylines<'a> {
    /// Points, m.
    pub points: &'a [DVec3],
    /// Points of all lines, one line after another.
    pub corners: &'a [u32],
    /// End of each line in `corners`, ascending.
    pub ends: &'a [u32],
    /// Data of the points.
    pub point_data: &'a [Field],
    /// Data of the lines.
    pub line_data: &'a [Field],
    /// Where the lines come from.
    pub metadata: Option<&'a Metadata>,
}

/// Writes lines as a `.vtp` file.
///
/// # Errors
/// [`FormatError::Unwritable`] if a line has no points or a point that does not exist, a field has the wrong number of
/// values, or a number is not finite.
pub fn write_lines(lines: &Polylines, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    check(lines, file)?;
    let count = lines.ends.len();
    let arrays = vec![
        CellArray::integers("connectivity", lines.corners.iter().copied()),
        CellArray::integers("offsets", lines.ends.iter().copied()),
    ];
    let piece = Piece {
        kind: "PolyData",
        counts: format!(
            "NumberOfVerts=\"0\" NumberOfLines=\"{count}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\""
        ),
        points: lines.points,
        point_data: lines.point_data,
        cell_data: lines.line_data,
        cells: ("Lines", arrays),
        metadata: lines.metadata,
    };
    piece.check(count, file)?;
    Ok(piece.write(name))
}

/// Refuses lines without points, and those whose points do not exist.
fn check(lines: &Polylines, file: InFile) -> Result<(), FormatError> {
    let points = lines.points.len();
    let mut from = 0;
    for (line, &end) in lines.ends.iter().enumerate() {
        if end <= from || end as usize > lines.corners.len() {
            let found = format!("line {line} has the points {from} to {end}");
            let right = format!("at least one of {}", lines.corners.len());
            return Err(file.unwritable(found, right));
        }
        from = end;
    }
    if from as usize != lines.corners.len() {
        let found = format!(
            "{} points for lines that end at {from}",
            lines.corners.len()
        );
        return Err(file.unwritable(found, "lines that use all points"));
    }
    if let Some(i) = lines.corners.iter().find(|&&i| i as usize >= points) {
        let right = format!("a number below {points}");
        return Err(file.unwritable(format!("a line passes through point {i}"), right));
    }
    Ok(())
}
