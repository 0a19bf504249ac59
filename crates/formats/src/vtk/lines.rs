//! Lines with data: rods as polylines, bonds as lines of two points, and lists of such files over time.

use super::{Appended, Packed, add, bytes_of, escaped, opening};
use crate::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::Values;

/// Data of points or lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Name, with the unit where there is one: `force_N`.
    pub name: String,
    /// Numbers for each point or line: 1, 3 for a vector …
    pub components: usize,
    /// The numbers.
    pub values: Values,
}

impl Field {
    /// One number for each.
    pub fn scalar(name: &str, values: Values) -> Self {
        Field {
            name: name.to_owned(),
            components: 1,
            values,
        }
    }

    /// A vector for each.
    pub fn vectors(name: &str, vectors: &[DVec3]) -> Self {
        Field {
            name: name.to_owned(),
            components: 3,
            values: Values::F64(vectors.iter().flat_map(|v| v.to_array()).collect()),
        }
    }
}

/// Lines through points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polylines<'a> {
    /// Points, m.
    pub points: &'a [DVec3],
    /// Points of all lines, one line after the other.
    pub corners: &'a [u32],
    /// Where each line ends in `corners`, ascending.
    pub ends: &'a [u32],
    /// Data of the points.
    pub point_data: &'a [Field],
    /// Data of the lines.
    pub line_data: &'a [Field],
}

/// Writes lines as a `.vtp` file.
///
/// # Errors
/// [`FormatError::Unwritable`] where a line has a point that does not exist or no points, a field has not the numbers that
/// it should have, or a number is not finite.
pub fn lines(lines: &Polylines, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    check(lines, file)?;
    let (count, places) = (lines.ends.len(), lines.points.len());
    let coordinates = Values::F64(lines.points.iter().flat_map(|p| p.to_array()).collect());
    let points = Packed::of(&bytes_of(&coordinates).1);
    let long = |list: &[u32]| -> Vec<u8> {
        list.iter()
            .flat_map(|&i| i64::from(i).to_le_bytes())
            .collect()
    };
    let corners = Packed::of(&long(lines.corners));
    let ends = Packed::of(&long(lines.ends));
    let of_points = packed(lines.point_data);
    let of_lines = packed(lines.line_data);
    let mut appended = Appended::default();
    let mut text = opening("PolyData", "1.0");
    text += &format!(
        "  <PolyData>\n    <Piece NumberOfPoints=\"{places}\" NumberOfVerts=\"0\" NumberOfLines=\"{count}\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n"
    );
    for (kind, fields) in [("PointData", &of_points), ("CellData", &of_lines)] {
        text += &format!("      <{kind}>\n");
        for (entry, packed) in fields {
            add(&mut text, &mut appended, entry, packed);
        }
        text += &format!("      </{kind}>\n");
    }
    text += "      <Points>\n";
    let entry = "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"";
    add(&mut text, &mut appended, entry, &points);
    text += "      </Points>\n      <Lines>\n";
    for (name, packed) in [("connectivity", &corners), ("offsets", &ends)] {
        let entry = format!("type=\"Int64\" Name=\"{name}\"");
        add(&mut text, &mut appended, &entry, packed);
    }
    text += "      </Lines>\n    </Piece>\n  </PolyData>\n";
    Ok(Encoded {
        name: name.to_owned(),
        bytes: appended.finish(text),
    })
}

fn packed(fields: &[Field]) -> Vec<(String, Packed)> {
    let pack = |field: &Field| {
        let (kind, bytes) = bytes_of(&field.values);
        let entry = format!(
            "type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{}\"",
            escaped(&field.name),
            field.components
        );
        (entry, Packed::of(&bytes))
    };
    fields.iter().map(pack).collect()
}

fn check(lines: &Polylines, file: InFile) -> Result<(), FormatError> {
    let (count, places) = (lines.ends.len(), lines.points.len());
    let mut from = 0;
    for (line, &end) in lines.ends.iter().enumerate() {
        if end <= from || end as usize > lines.corners.len() {
            let found = format!("line {line} takes points {from} to {end}");
            let right = format!("at least one of the {}", lines.corners.len());
            return Err(file.unwritable(found, right));
        }
        from = end;
    }
    if from as usize != lines.corners.len() {
        let found = format!("{} points of lines that end at {from}", lines.corners.len());
        return Err(file.unwritable(found, "lines that take all points"));
    }
    if let Some(i) = lines.corners.iter().find(|&&i| i as usize >= places) {
        let right = format!("a number below {places}");
        return Err(file.unwritable(format!("a line goes through point {i}"), right));
    }
    if let Some(i) = lines.points.iter().position(|p| !p.is_finite()) {
        let found = format!("point {i} lies at {}", lines.points[i]);
        return Err(file.unwritable(found, "finite coordinates"));
    }
    let of_points = lines.point_data.iter().map(|f| (f, places));
    let of_lines = lines.line_data.iter().map(|f| (f, count));
    for (field, entries) in of_points.chain(of_lines) {
        let right = field.components.checked_mul(entries);
        if field.components == 0 || right != Some(field.values.len()) {
            let found = format!("field {} has {} numbers", field.name, field.values.len());
            let right = format!("{} for each of {entries}", field.components.max(1));
            return Err(file.unwritable(found, right));
        }
        if let Values::F64(values) = &field.values
            && let Some(k) = values.iter().position(|v| !v.is_finite())
        {
            let found = format!("{} in field {}", values[k], field.name);
            return Err(file.unwritable(found, "finite numbers"));
        }
    }
    Ok(())
}

/// A `.pvd` file: which files are shown when, (time in s, file). Files of the same time that follow each other are parts
/// that are shown together, such as rods and bonds.
pub fn collection(files: &[(f64, String)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    let mut part = 0;
    for (k, (time, file)) in files.iter().enumerate() {
        let together = k > 0 && files[k - 1].0 == *time;
        part = if together { part + 1 } else { 0 };
        text += &format!(
            "    <DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" file=\"{}\"/>\n",
            escaped(file)
        );
    }
    text + "  </Collection>\n</VTKFile>\n"
}
