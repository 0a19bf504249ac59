//! Image data: voxels with arrays, in slices that can be computed and compressed one by one.

use super::appended::{Appended, escape, field_data, file_start};
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::Metadata;

/// The type of the values of an array, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageNumber {
    /// Unsigned 8-bit integers.
    U8,
    /// Unsigned 16-bit integers.
    U16,
}

/// An array over all voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageArray {
    /// Name.
    pub name: String,
    /// Values for each voxel.
    pub components: usize,
    /// Type of the values.
    pub number: ImageNumber,
    /// The values of each slice, compressed by [`compress`](super::compress): all components of a voxel, then the next
    /// voxel along x, then the next row along y.
    pub slices: Vec<Vec<u8>>,
}

/// A box of voxels. Values belong to the voxels themselves (cells in VTK), not to their corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Number of voxels along x, y and z.
    pub counts: [usize; 3],
    /// Position of the corner of the first voxel in the world, m.
    pub origin: DVec3,
    /// Edge lengths of a voxel, m.
    pub spacing: [f64; 3],
    /// Directions of x, y and z in the world (unit vectors).
    pub directions: [DVec3; 3],
    /// The arrays.
    pub arrays: Vec<ImageArray>,
    /// Where it comes from.
    pub metadata: Metadata,
}

/// Writes a `.vti` file.
///
/// # Errors
/// [`FormatError::Unwritable`] if an array does not have one slice for each voxel along z, or a number is not finite.
pub fn write_image(image: &Image, name: &str) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    let [nx, ny, nz] = image.counts;
    let directions = image.directions.iter().flat_map(|d| d.to_array());
    if !image.origin.is_finite() || !directions.chain(image.spacing).all(f64::is_finite) {
        return Err(file.unwritable(
            "an image whose position or size is not finite",
            "finite numbers",
        ));
    }
    let mut appended = Appended::default();
    let mut text = file_start("ImageData", "1.0");
    let numbers = |list: &[f64]| {
        list.iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(" ")
    };
    // The directions are the columns of the matrix, which is written row by row.
    let [x, y, z] = image.directions;
    let matrix = [x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z];
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    text += &format!(
        "  <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{}\">\n{}    <Piece Extent=\"{extent}\">\n      <CellData Scalars=\"{}\">\n",
        numbers(&image.origin.to_array()),
        numbers(&image.spacing),
        numbers(&matrix),
        field_data(&image.metadata),
        image
            .arrays
            .first()
            .map_or(String::new(), |a| escape(&a.name)),
    );
    for array in &image.arrays {
        if array.slices.len() != nz {
            let found = format!("{} slices of {}", array.slices.len(), array.name);
            return Err(file.unwritable(found, format!("{nz}, one for each voxel along z")));
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
            escape(&array.name),
            array.components
        );
    }
    text += "      </CellData>\n    </Piece>\n  </ImageData>\n";
    Ok(Encoded {
        name: name.to_owned(),
        bytes: appended.finish(text),
    })
}
