//! The formats of meshes and point clouds, and their names and extensions.

#[cfg(feature = "usd")]
use crate::usd::UsdFormat;
use std::path::Path;

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// glTF 2.0 with separate buffers.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// Wavefront OBJ with its MTL.
    Obj,
    /// Stanford polygon format.
    Ply,
    /// Stereolithography triangles.
    Stl,
    /// Geomview object file format.
    Off,
}

impl Format {
    /// All formats, in the order in which to list them.
    pub const ALL: [Format; 6] = [
        Format::Glb,
        Format::Gltf,
        Format::Obj,
        Format::Ply,
        Format::Stl,
        Format::Off,
    ];

    /// The format that the extension of `path` stands for, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ALL.into_iter().find(|f| f.extension() == extension)
    }

    /// The extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Gltf => "gltf",
            Format::Glb => "glb",
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Stl => "stl",
            Format::Off => "off",
        }
    }

    /// The name of the format.
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

    /// Whether its standard requires metres; the other formats leave the unit of length to the user.
    pub fn is_in_metres(self) -> bool {
        matches!(self, Format::Gltf | Format::Glb)
    }
}

/// A file format of points without faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CloudFormat {
    /// Lines of numbers: x, y and z, possibly with normals and colours.
    Xyz,
    /// ASPRS LAS.
    Las,
    /// LAS compressed by LASzip.
    Laz,
}

impl CloudFormat {
    /// All formats, in the order in which to list them.
    pub const ALL: [CloudFormat; 3] = [CloudFormat::Xyz, CloudFormat::Las, CloudFormat::Laz];

    /// The extensions of file names, without the dot.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            CloudFormat::Xyz => &["xyz", "txt", "asc", "pts"],
            CloudFormat::Las => &["las"],
            CloudFormat::Laz => &["laz"],
        }
    }

    /// The name of the format.
    pub fn name(self) -> &'static str {
        match self {
            CloudFormat::Xyz => "XYZ",
            CloudFormat::Las => "LAS",
            CloudFormat::Laz => "LAZ",
        }
    }
}

/// Width of textures that no file holds, pixels: the least that can be asked for.
const UNSEEN_TEXTURE_WIDTH: u32 = 8;

/// A file format that a scene can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OutputFormat {
    /// A format of meshes, which can be read, too.
    Mesh(Format),
    /// USD.
    #[cfg(feature = "usd")]
    Usd(UsdFormat),
}

impl OutputFormat {
    /// All formats, in the order in which to list them.
    pub fn all() -> Vec<OutputFormat> {
        let all = Format::ALL.into_iter().map(OutputFormat::Mesh);
        #[cfg(feature = "usd")]
        let all = all.chain(UsdFormat::ALL.into_iter().map(OutputFormat::Usd));
        all.collect()
    }

    /// The format that the extension of `path` stands for, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<OutputFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let mut all = OutputFormat::all().into_iter();
        all.find(|f| f.extension() == extension)
    }

    /// Whether files of the format have materials with textures.
    pub fn holds_textures(self) -> bool {
        match self {
            OutputFormat::Mesh(format) => {
                matches!(format, Format::Gltf | Format::Glb | Format::Obj)
            }
            #[cfg(feature = "usd")]
            OutputFormat::Usd(_) => true,
        }
    }

    /// The width of the textures to bake for the file `path`, if any, where so many pixels were `asked` for: some formats hold none, and
    /// pictures do without. The geometry of pieces is the same for all widths but 0.
    pub fn texture_width(path: Option<&Path>, asked: u32) -> u32 {
        let format = path.and_then(OutputFormat::from_path);
        match format.is_some_and(OutputFormat::holds_textures) {
            true => asked,
            false => asked.min(UNSEEN_TEXTURE_WIDTH),
        }
    }

    /// The extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            OutputFormat::Mesh(format) => format.extension(),
            #[cfg(feature = "usd")]
            OutputFormat::Usd(format) => format.extension(),
        }
    }
}

/// A file format that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InputFormat {
    /// A format of meshes; PLY may hold a cloud, too.
    Mesh(Format),
    /// A format of clouds.
    Cloud(CloudFormat),
}

impl InputFormat {
    /// The format that the extension of `path` stands for, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<InputFormat> {
        if let Some(format) = Format::from_path(path) {
            return Some(InputFormat::Mesh(format));
        }
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        CloudFormat::ALL
            .into_iter()
            .find(|f| f.extensions().contains(&extension.as_str()))
            .map(InputFormat::Cloud)
    }

    /// The name of the format.
    pub fn name(self) -> &'static str {
        match self {
            InputFormat::Mesh(format) => format.name(),
            InputFormat::Cloud(format) => format.name(),
        }
    }

    /// Whether z points up in it rather than y, by its standard or by custom.
    pub fn is_z_up(self) -> bool {
        !matches!(
            self,
            InputFormat::Mesh(Format::Gltf | Format::Glb | Format::Obj)
        )
    }

    /// Whether its lengths are metres, by its standard or, for the surveys in LAS files, by custom. The other formats leave
    /// the unit of length to the user.
    pub fn is_in_metres(self) -> bool {
        match self {
            InputFormat::Mesh(format) => format.is_in_metres(),
            InputFormat::Cloud(format) => format != CloudFormat::Xyz,
        }
    }
}
