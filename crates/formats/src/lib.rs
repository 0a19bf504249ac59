//! Readers and writers of mesh files: bytes in, a [`Scene`] out, and back; readers of point clouds.
//!
//! No function here opens a file: companions (a `.bin`, a `.mtl`) come in through [`Resolve`] and go out as
//! [`Encoded`]. The same scene always gives the same bytes.
#![deny(missing_docs)]

mod assemble;
mod cloud;
mod error;
pub mod film;
mod gltf;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod table;
mod text;
pub mod usd;
pub mod vtk;

pub use cloud::{CloudFile, CloudFormat, Content, InputFormat, read_content};
pub use error::FormatError;
use greenstick_geometry::Scene;
use std::path::Path;
pub use table::{TableFormat, write_table};

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// glTF 2.0 with separate buffers.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// Wavefront OBJ with its MTL.
    Obj,
    /// Stanford polygons.
    Ply,
    /// Stereolithography triangles.
    Stl,
    /// Object file format of Geomview.
    Off,
}

impl Format {
    /// Every format, in the order in which to list them.
    pub const ALL: [Format; 6] = [
        Format::Glb,
        Format::Gltf,
        Format::Obj,
        Format::Ply,
        Format::Stl,
        Format::Off,
    ];

    /// The format that the ending of `path` names, in either case.
    pub fn of_path(path: &Path) -> Option<Format> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ALL.into_iter().find(|f| f.ending() == ending)
    }

    /// The file name's ending, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Gltf => "gltf",
            Format::Glb => "glb",
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Stl => "stl",
            Format::Off => "off",
        }
    }

    /// The name to show.
    pub fn name(self) -> &'static str {
        match self {
            Format::Gltf => "glTF",
            Format::Glb => "GLB",
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Off => "OFF",
        }
    }

    /// Whether lengths in it are metres by its standard; the others leave the unit to the user.
    pub fn is_in_metres(self) -> bool {
        matches!(self, Format::Gltf | Format::Glb)
    }
}

greenstick_schema::choices! {
    /// A unit of length in files that do not say it.
    pub enum LengthUnit {
        /// Millimetres.
        Millimetre = "mm",
        /// Centimetres.
        Centimetre = "cm",
        /// Metres.
        Metre = "m",
    }
}

impl Default for LengthUnit {
    fn default() -> Self {
        LengthUnit::Metre
    }
}

impl LengthUnit {
    /// Its length, m.
    pub fn metres(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 0.001,
            LengthUnit::Centimetre => 0.01,
            LengthUnit::Metre => 1.0,
        }
    }

    /// How many of it make a metre; exact, other than the quotient.
    fn per_metre(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1000.0,
            LengthUnit::Centimetre => 100.0,
            LengthUnit::Metre => 1.0,
        }
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// A unit of length other than those known.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no unit of length known here; expected mm, cm or m")]
pub struct UnknownUnit(pub String);

impl std::str::FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        match text {
            "mm" => Ok(LengthUnit::Millimetre),
            "cm" => Ok(LengthUnit::Centimetre),
            "m" => Ok(LengthUnit::Metre),
            _ => Err(UnknownUnit(text.to_owned())),
        }
    }
}

/// Fetches a file that the main one refers to (a `.bin`, a `.mtl`), by its reference relative to the main file. What
/// references are allowed (`../`, absolute ones) is for the caller to decide.
pub type Resolve<'a> = &'a dyn Fn(&str) -> std::io::Result<Vec<u8>>;

/// A file to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// File name without folders.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Reads a mesh file. Where the content is plainly another format than `format`, the content decides and a note says so.
///
/// `name` is the file's name for messages, `unit` what one unit of length stands for (metre where absent; glTF is in
/// metres, so that a unit for it is a scale on top, with a note). The unit goes to the nodes' transforms; the meshes
/// keep the numbers of the file.
///
/// # Errors
/// [`FormatError`] where the bytes are no sound mesh; nothing is allocated on the word of a count that the bytes
/// cannot back.
pub fn read(
    format: Format,
    bytes: &[u8],
    name: &str,
    unit: Option<LengthUnit>,
    resolve: Resolve,
) -> Result<Scene, FormatError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(FormatError::Empty {
            file: name.to_owned(),
            format: format.name(),
        });
    }
    let actual = detect(bytes).unwrap_or(format);
    let mut scene = match actual {
        Format::Gltf | Format::Glb => gltf::read(bytes, name, resolve)?,
        Format::Obj => obj::read(bytes, name, resolve)?,
        Format::Ply => ply::read(bytes, name)?,
        Format::Stl => stl::read(bytes, name)?,
        Format::Off => off::read(bytes, name)?,
    };
    if scene
        .nodes
        .iter()
        .all(|node| node.mesh.triangles.is_empty())
    {
        return Err(FormatError::NoTriangles {
            file: name.to_owned(),
        });
    }
    if actual != format {
        scene.notes.push(format!(
            "{name} is named as {} but holds {}; it was read as that.",
            format.name(),
            actual.name()
        ));
    }
    if let Some(unit) = unit.filter(|u| *u != LengthUnit::Metre) {
        let scale = glam::DAffine3::from_scale(glam::DVec3::splat(unit.metres()));
        for node in &mut scene.nodes {
            node.transform = scale * node.transform;
        }
        if actual.is_in_metres() {
            scene.notes.push(format!(
                "glTF is in metres by its standard; the unit {unit} was applied as a scale all the same."
            ));
        }
    }
    Ok(scene)
}

/// The format that the first bytes prove, if any.
fn detect(bytes: &[u8]) -> Option<Format> {
    let text = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    if bytes.starts_with(b"glTF") {
        Some(Format::Glb)
    } else if text.starts_with(b"{") && !stl::is_binary(bytes) {
        Some(Format::Gltf)
    } else if text.starts_with(b"ply\n") || text.starts_with(b"ply\r") {
        Some(Format::Ply)
    } else if stl::is_text(bytes) {
        Some(Format::Stl)
    } else if off::is_off(text) {
        Some(Format::Off)
    } else {
        None
    }
}

/// Writes a mesh file: the main file first, then its companions (`.bin`, `.mtl`, textures).
///
/// `name` is the main file's name (`broken.glb`), after which the companions are named. glTF is written in metres;
/// `unit` is the unit of length in the other formats.
///
/// # Errors
/// [`FormatError::Unwritable`] where the scene breaks its own rules (an index out of range, a coordinate that is not
/// finite), has no triangle, or is too large for the format.
pub fn write(
    format: Format,
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    assemble::check_scene(scene, name)?;
    match format {
        Format::Gltf => gltf::write(scene, name, false),
        Format::Glb => gltf::write(scene, name, true),
        Format::Obj => obj::write(scene, name, unit),
        Format::Ply => ply::write(scene, name, unit),
        Format::Stl => stl::write(scene, name, unit),
        Format::Off => off::write(scene, name, unit),
    }
}

/// `model` of `folder/model.glb`, with nothing in it that a file name or a URI could not take.
fn stem(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    if stem.is_empty() {
        "mesh".to_owned()
    } else {
        stem.to_owned()
    }
}
