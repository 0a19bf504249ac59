//! Polylines with data: rods, or bonds as lines of two points.

use super::appended::{Appended, CompressedArray, add_array, bytes_of, field_data, file_start};
use super::fields::{Field, check_fields, compress_fields};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::{Metadata, Values};

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
    let (line_count, point_count) = (lines.ends.len(), lines.points.len());
    let coordinates = Values::F64(lines.points.iter().flat_map(|p| p.to_array()).collect());
    let points = CompressedArray::new(&bytes_of(&coordinates).1);
    let as_i64 = |list: &[u32]| -> Vec<u8> {
        list.iter()
            .flat_map(|&i| i64::from(i).to_le_bytes())
            .collect()
    };
    let corners = CompressedArray::new(&as_i64(lines.corners));
    let ends = CompressedArray::new(&as_i64(lines.ends));
    let point_data = compress_fields(lines.point_data);
    let line_data = compress_fields(lines.line_data);
    let mut appended = Appended::default();
    let mut text = file_start("PolyData", "1.0");
    text += &format!(
        "  <PolyData>\n{}    <Piece NumberOfPoints=\"{point_count}\" NumberOfVerts=\"0\" NumberOfLines=\"{line_count}\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n",
        lines.metadata.map_or(String::new(), field_data)
    );
    for (kind, fields) in [("PointData", &point_data), ("CellData", &line_data)] {
        text += &format!("      <{kind}>\n");
        for field in fields {
            add_array(&mut text, &mut appended, &field.attributes, &field.array);
        }
        text += &format!("      </{kind}>\n");
    }
    text += "      <Points>\n";
    let attributes = "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"";
    add_array(&mut text, &mut appended, attributes, &points);
    text += "      </Points>\n      <Lines>\n";
    for (name, array) in [("connectivity", &corners), ("offsets", &ends)] {
        let attributes = format!("type=\"Int64\" Name=\"{name}\"");
        add_array(&mut text, &mut appended, &attributes, array);
    }
    text += "      </Lines>\n    </Piece>\n  </PolyData>\n";
    Ok(Encoded {
        name: name.to_owned(),
        bytes: appended.finish(text),
    })
}

/// Refuses invalid lines and fields.
fn check(lines: &Polylines, file: InFile) -> Result<(), FormatError> {
    let (count, points) = (lines.ends.len(), lines.points.len());
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
    if let Some(i) = lines.points.iter().position(|p| !p.is_finite()) {
        let found = format!("point {i} lies at {}", lines.points[i]);
        return Err(file.unwritable(found, "finite coordinates"));
    }
    check_fields(lines.point_data, points, file)?;
    check_fields(lines.line_data, count, file)
}
