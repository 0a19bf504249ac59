//! The USD file formats.

use std::path::Path;

/// A USD file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UsdFormat {
    /// Text.
    Usda,
    /// Binary.
    Usdc,
    /// An archive of a binary layer and its textures.
    Usdz,
}

impl UsdFormat {
    /// All formats.
    pub const ALL: [UsdFormat; 3] = [UsdFormat::Usda, UsdFormat::Usdc, UsdFormat::Usdz];

    /// The format that the extension of `path` stands for, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<UsdFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        UsdFormat::ALL
            .into_iter()
            .find(|f| f.extension() == extension)
    }

    /// The extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            UsdFormat::Usda => "usda",
            UsdFormat::Usdc => "usdc",
            UsdFormat::Usdz => "usdz",
        }
    }
}
