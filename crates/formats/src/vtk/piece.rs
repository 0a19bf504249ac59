//! What polylines and unstructured grids have in common: one piece with points, data of points and cells, and cells as lists of
//! corners.

use super::appended::{Appended, CompressedArray, add_array, bytes_of, field_data, file_start};
use super::fields::{Field, check_fields, compress_fields};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::{Metadata, Values};

/// The one piece of a file.
pub(super) struct Piece<'a> {
    /// The kind of data set, which is its element.
    pub kind: &'static str,
    /// Numbers of cells, as attributes.
    pub counts: String,
    /// Points, m.
    pub points: &'a [DVec3],
    /// Data of the points.
    pub point_data: &'a [Field],
    /// Data of the cells.
    pub cell_data: &'a [Field],
    /// The element of the cells, and its arrays.
    pub cells: (&'static str, Vec<CellArray>),
    /// Where it comes from.
    pub metadata: Option<&'a Metadata>,
}

/// An array that describes cells.
pub(super) struct CellArray {
    attributes: String,
    array: CompressedArray,
}

impl CellArray {
    /// Numbers, as 64-bit integers.
    pub fn integers(name: &str, list: impl Iterator<Item = u32>) -> Self {
        let bytes: Vec<u8> = list.flat_map(|i| i64::from(i).to_le_bytes()).collect();
        CellArray {
            attributes: format!("type=\"Int64\" Name=\"{name}\""),
            array: CompressedArray::new(&bytes),
        }
    }

    /// Bytes.
    pub fn bytes(name: &str, bytes: &[u8]) -> Self {
        CellArray {
            attributes: format!("type=\"UInt8\" Name=\"{name}\""),
            array: CompressedArray::new(bytes),
        }
    }
}

impl Piece<'_> {
    /// Refuses points that are not finite, and fields with a wrong number of values.
    pub fn check(&self, cells: usize, file: InFile) -> Result<(), FormatError> {
        if let Some(i) = self.points.iter().position(|p| !p.is_finite()) {
            let found = format!("point {i} lies at {}", self.points[i]);
            return Err(file.unwritable(found, "finite coordinates"));
        }
        check_fields(self.point_data, self.points.len(), file)?;
        check_fields(self.cell_data, cells, file)
    }

    /// Writes the file.
    pub fn write(&self, name: &str) -> Encoded {
        let coordinates = Values::F64(self.points.iter().flat_map(|p| p.to_array()).collect());
        let coordinates = CompressedArray::new(&bytes_of(&coordinates).1);
        let point_data = compress_fields(self.point_data);
        let cell_data = compress_fields(self.cell_data);
        let mut appended = Appended::default();
        let mut text = file_start(self.kind, "1.0");
        text += &format!(
            "  <{}>\n{}    <Piece NumberOfPoints=\"{}\" {}>\n",
            self.kind,
            self.metadata.map_or(String::new(), field_data),
            self.points.len(),
            self.counts
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
        let (element, arrays) = &self.cells;
        text += &format!("      </Points>\n      <{element}>\n");
        for CellArray { attributes, array } in arrays {
            add_array(&mut text, &mut appended, attributes, array);
        }
        text += &format!("      </{element}>\n    </Piece>\n  </{}>\n", self.kind);
        Encoded {
            name: name.to_owned(),
            bytes: appended.finish(text),
        }
    }
}
