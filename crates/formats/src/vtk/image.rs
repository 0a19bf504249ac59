//! Image data: voxels with arrays, in slices that may be made and compressed one by one.

use super::{Appended, escaped, opening};
use crate::Encoded;
use crate::error::{FormatError, InFile};
use flate2::{Compression, write::ZlibEncoder};
use glam::DVec3;
use std::io::Write;

/// Type of an array's numbers, little endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageNumber {
    /// One byte.
    U8,
    /// Two bytes.
    U16,
}

/// An array over all voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageArray {
    /// Name.
    pub name: String,
    /// Numbers for each voxel.
    pub components: usize,
    /// Their type.
    pub number: ImageNumber,
    /// For each slice its numbers, those of a voxel together, x before y, through [`compress`].
    pub slices: Vec<Vec<u8>>,
}

/// A box of voxels. Numbers are those of the voxels themselves (VTK's cells), not of their corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Voxels along x, y and z.
    pub counts: [usize; 3],
    /// The corner of the first voxel in the world, m.
    pub origin: DVec3,
    /// Sides of a voxel, m.
    pub spacing: [f64; 3],
    /// Directions of x, y and z in the world (unit vectors).
    pub directions: [DVec3; 3],
    /// The arrays.
    pub arrays: Vec<ImageArray>,
}

/// How hard to press: more takes longer than it saves on runs of equal numbers.
const LEVEL: u32 = 2;

/// Bytes as a zlib stream.
pub fn compress(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    // Memory takes every byte.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// Writes a `.vti` file.
///
/// # Errors
/// [`FormatError::Unwritable`] where an array has not as many slices as there are voxels along z, or a measure is not
/// finite.
pub fn write_image(image: &Image, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    let [nx, ny, nz] = image.counts;
    let measures = image.directions.iter().flat_map(|d| d.to_array());
    if !image.origin.is_finite() || !measures.chain(image.spacing).all(f64::is_finite) {
        return Err(file.unwritable("an image without a place", "finite measures"));
    }
    let mut appended = Appended::default();
    let mut text = opening("ImageData", "1.0");
    let numbers = |list: &[f64]| {
        list.iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(" ")
    };
    // The directions are the columns of the matrix that is written by rows.
    let [x, y, z] = image.directions;
    let matrix = [x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z];
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    text += &format!(
        "  <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{}\">\n    <Piece Extent=\"{extent}\">\n      <CellData Scalars=\"{}\">\n",
        numbers(&image.origin.to_array()),
        numbers(&image.spacing),
        numbers(&matrix),
        image
            .arrays
            .first()
            .map_or(String::new(), |a| escaped(&a.name)),
    );
    for array in &image.arrays {
        if array.slices.len() != nz {
            let found = format!("{} slices of {}", array.slices.len(), array.name);
            return Err(
                file.unwritable(found, format!("{nz}, as many as there are voxels along z"))
            );
        }
        let (kind, size) = match array.number {
            ImageNumber::U8 => ("UInt8", 1),
            ImageNumber::U16 => ("UInt16", 2),
        };
        let slice = nx * ny * array.components * size;
        let offset = appended.push(
            array.slices.iter().map(Vec::as_slice).collect(),
            slice,
            slice,
        );
        text += &format!(
            "        <DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{offset}\"/>\n",
            escaped(&array.name),
            array.components
        );
    }
    text += "      </CellData>\n    </Piece>\n  </ImageData>\n";
    Ok(Encoded {
        name: name.to_owned(),
        bytes: appended.finish(text),
    })
}

/// Writes a `.vtm` file that lists others: (name of the part, its file).
pub fn write_multiblock(parts: &[(String, String)], name: &str) -> Encoded {
    let mut text = opening("vtkMultiBlockDataSet", "1.0");
    text += "  <vtkMultiBlockDataSet>\n";
    for (i, (part, file)) in parts.iter().enumerate() {
        text += &format!(
            "    <DataSet index=\"{i}\" name=\"{}\" file=\"{}\"/>\n",
            escaped(part),
            escaped(file)
        );
    }
    text += "  </vtkMultiBlockDataSet>\n</VTKFile>\n";
    Encoded {
        name: name.to_owned(),
        bytes: text.into_bytes(),
    }
}
