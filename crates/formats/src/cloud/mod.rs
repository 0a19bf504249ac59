//! Point clouds: PLY without faces, XYZ, LAS and LAZ.

mod las;
mod xyz;

use crate::{Format, FormatError, LengthUnit, Resolve, detect, ply};
use glam::DVec3;
use greenstick_geometry::{PointCloud, Scene};
use std::path::Path;

/// A file format that holds points and never faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CloudFormat {
    /// Lines of numbers: x y z, perhaps with normals and colours.
    Xyz,
    /// ASPRS LAS.
    Las,
    /// LAS compressed by LASzip.
    Laz,
}

impl CloudFormat {
    /// Every format, in the order in which to list them.
    pub const ALL: [CloudFormat; 3] = [CloudFormat::Xyz, CloudFormat::Las, CloudFormat::Laz];

    /// The file names' endings, without the dot.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            CloudFormat::Xyz => &["xyz", "txt", "asc", "pts"],
            CloudFormat::Las => &["las"],
            CloudFormat::Laz => &["laz"],
        }
    }

    /// The name to show.
    pub fn name(self) -> &'static str {
        match self {
            CloudFormat::Xyz => "XYZ",
            CloudFormat::Las => "LAS",
            CloudFormat::Laz => "LAZ",
        }
    }
}

/// Any format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InputFormat {
    /// Of meshes; PLY may hold a cloud all the same.
    Mesh(Format),
    /// Of clouds.
    Cloud(CloudFormat),
}

impl InputFormat {
    /// The format that the ending of `path` names, in either case.
    pub fn of_path(path: &Path) -> Option<InputFormat> {
        if let Some(format) = Format::of_path(path) {
            return Some(InputFormat::Mesh(format));
        }
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        CloudFormat::ALL
            .into_iter()
            .find(|f| f.endings().contains(&ending.as_str()))
            .map(InputFormat::Cloud)
    }

    /// The name to show.
    pub fn name(self) -> &'static str {
        match self {
            InputFormat::Mesh(format) => format.name(),
            InputFormat::Cloud(format) => format.name(),
        }
    }

    /// Whether the unit of length in it is left to the user. Surveys (LAS) are taken to be in metres.
    pub fn is_in_metres(self) -> bool {
        match self {
            InputFormat::Mesh(format) => format.is_in_metres(),
            InputFormat::Cloud(format) => format != CloudFormat::Xyz,
        }
    }
}

/// A cloud as it was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CloudFile {
    /// Its points, m. They may hold NaN where a scanner marks what it missed.
    pub cloud: PointCloud,
    /// What was taken off every coordinate because the file's are far from 0, m.
    pub origin: DVec3,
    /// How the file was understood and what was left out, a sentence each.
    pub notes: Vec<String>,
}

/// What a file turned out to hold.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Faces.
    Mesh(Scene),
    /// Points alone.
    Cloud(CloudFile),
}

/// Reads a file of meshes or of points. Where the content is plainly another format than `format`, the content decides
/// and a note says so. `name`, `unit` and `resolve` are those of [`crate::read`].
///
/// # Errors
/// [`FormatError`] where the bytes are no sound file; nothing is allocated on the word of a count that the bytes
/// cannot back.
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
            None => return mesh(format, actual, bytes, name, unit, resolve),
        },
        InputFormat::Mesh(_) => return mesh(format, actual, bytes, name, unit, resolve),
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
                "{} is in metres by custom; the unit {unit} was applied as a scale all the same.",
                actual.name()
            ));
        }
    }
    recentre(&mut file);
    Ok(Content::Cloud(file))
}

fn mesh(
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
    let mut scene = crate::read(expected, bytes, name, unit, resolve)?;
    if matches!(format, InputFormat::Cloud(_)) {
        scene.notes.push(other_format(format, actual, name));
    }
    Ok(Content::Mesh(scene))
}

fn other_format(named: InputFormat, actual: InputFormat, name: &str) -> String {
    format!(
        "{name} is named as {} but holds {}; it was read as that.",
        named.name(),
        actual.name()
    )
}

/// What the content proves, else what the name says.
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

/// Coordinates this many times as large as the cloud lose its detail when they are narrowed to 32 bits.
const FAR: f64 = 100.0;

/// Takes whole metres off coordinates that are far from 0, as those of surveys are.
fn recentre(file: &mut CloudFile) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in file.cloud.points.iter().filter(|p| p.is_finite()) {
        (low, high) = (low.min(*p), high.max(*p));
    }
    let size = low.distance(high);
    let far = low.abs().max(high.abs()).max_element();
    if !size.is_finite() || far <= FAR * size.max(1.0) {
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
        "coordinates reach {far:.0} m: {:.0}, {:.0}, {:.0} m were taken off them, here and in places given as points",
        origin.x, origin.y, origin.z
    ));
}
