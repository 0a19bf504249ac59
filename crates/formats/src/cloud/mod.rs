//! Point clouds: PLY without faces, XYZ, LAS and LAZ.

mod file;
mod las;
#[cfg(feature = "laz")]
mod laz;
mod xyz;

pub use file::CloudFile;

use crate::companions::Resolve;
use crate::detect::detect;
use crate::error::FormatError;
use crate::format::{CloudFormat, Format, InputFormat};
use crate::unit::LengthUnit;
use crate::{mesh, ply};
use glam::DVec3;
use greenstick_geometry::Scene;
use greenstick_geometry::text::one_line;

/// The content of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// A mesh.
    Mesh(Scene),
    /// Points without faces.
    Cloud(CloudFile),
}

/// Reads a file of meshes or of points. If the content clearly has another format than `format`, the content decides, and
/// a note says so. `name`, `unit` and `resolve` are as in [`crate::read`].
///
/// ```
/// use greenstick_formats::{CloudFormat, Content, InputFormat, read_content};
///
/// let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
/// let format = InputFormat::Cloud(CloudFormat::Xyz);
/// let content = read_content(format, b"0 0 0\n1 2 3\n", "scan.xyz", None, &none)?;
/// let Content::Cloud(file) = content else { panic!("expected points") };
/// assert_eq!(file.cloud.points.len(), 2);
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError`] if the bytes are not a valid file. No memory is allocated for a count that the bytes cannot hold.
pub fn read_content(
    format: InputFormat,
    bytes: &[u8],
    name: &str,
    unit: Option<LengthUnit>,
    resolve: Resolve,
) -> Result<Content, FormatError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(FormatError::Empty {
            file: name.to_owned(),
            format: format.name(),
        });
    }
    let actual = actual_format(format, bytes);
    let mut file = match actual {
        InputFormat::Mesh(Format::Ply) => match ply::read_points(bytes, name)? {
            Some(file) => file,
            None => return read_mesh(format, actual, bytes, name, unit, resolve),
        },
        InputFormat::Mesh(_) => return read_mesh(format, actual, bytes, name, unit, resolve),
        InputFormat::Cloud(CloudFormat::Xyz) => xyz::read(bytes, name)?,
        InputFormat::Cloud(_) => las::read(bytes, name)?,
    };
    if actual != format {
        file.notes.push(other_format(format, actual, name));
    }
    let unit = unit.unwrap_or_default();
    if unit != LengthUnit::Metre {
        let per_metre = unit.per_metre();
        file.cloud.points.iter_mut().for_each(|p| *p /= per_metre);
        if matches!(actual, InputFormat::Cloud(f) if f != CloudFormat::Xyz) {
            file.notes.push(format!(
                "{} is in metres by custom; the unit {unit} was applied as an additional scale.",
                actual.name()
            ));
        }
    }
    recentre(&mut file);
    for note in &mut file.notes {
        *note = one_line(note).into_owned();
    }
    Ok(Content::Cloud(file))
}

/// Reads a file that holds a mesh.
fn read_mesh(
    format: InputFormat,
    actual: InputFormat,
    bytes: &[u8],
    name: &str,
    unit: Option<LengthUnit>,
    resolve: Resolve,
) -> Result<Content, FormatError> {
    let InputFormat::Mesh(of_mesh) = actual else {
        return Err(FormatError::NoTriangles {
            file: name.to_owned(),
        });
    };
    let expected = match format {
        InputFormat::Mesh(format) => format,
        InputFormat::Cloud(_) => of_mesh,
    };
    let mut scene = mesh::read(expected, bytes, name, unit, resolve)?;
    if matches!(format, InputFormat::Cloud(_)) {
        scene.notes.push(other_format(format, actual, name));
    }
    Ok(Content::Mesh(scene))
}

/// The note for a file with the extension of another format.
fn other_format(named: InputFormat, actual: InputFormat, name: &str) -> String {
    format!(
        "{name} has the extension of {} but holds {}; it was read as {1}.",
        named.name(),
        actual.name()
    )
}

/// The format that the content proves, else that of the name.
fn actual_format(format: InputFormat, bytes: &[u8]) -> InputFormat {
    if bytes.starts_with(b"LASF") {
        InputFormat::Cloud(if las::is_compressed(bytes) {
            CloudFormat::Laz
        } else {
            CloudFormat::Las
        })
    } else {
        detect(bytes).map_or(format, InputFormat::Mesh)
    }
}

/// Coordinates that exceed the size of the cloud by this factor lose its details in single precision.
const MAX_RELATIVE_OFFSET: f64 = 100.0;

/// Subtracts whole metres from coordinates that are far from 0, as those of surveys are.
fn recentre(file: &mut CloudFile) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in file.cloud.points.iter().filter(|p| p.is_finite()) {
        (low, high) = (low.min(*p), high.max(*p));
    }
    let size = low.distance(high);
    let far = low.abs().max(high.abs()).max_element();
    if !size.is_finite() || far <= MAX_RELATIVE_OFFSET * size.max(1.0) {
        return;
    }
    let origin = DVec3::new(
        (0.5 * (low.x + high.x)).round(),
        (0.5 * (low.y + high.y)).round(),
        low.z.round(),
    );
    file.cloud.points.iter_mut().for_each(|p| *p -= origin);
    file.origin = origin;
    file.notes.push(format!(
        "coordinates reach {far:.0} m: {:.0}, {:.0}, {:.0} m were subtracted from them, here and in places given as points",
        origin.x, origin.y, origin.z
    ));
}
