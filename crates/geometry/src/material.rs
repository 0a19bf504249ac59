//! Surface materials in the metallic–roughness model of glTF 2.0 (§3.9), as read from a file.

use serde::{Deserialize, Serialize};

/// An image: its encoded bytes, or a reference to a file that may be absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Name, may be empty.
    pub name: String,
    /// Media type such as `image/png`; may be empty if only a path is known.
    pub mime_type: String,
    /// Where the pixels are.
    pub source: ImageSource,
}

/// Where an image's pixels are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ImageSource {
    /// A path or URI. Writers write it as it was read, whether or not the file exists.
    Reference(String),
    /// The encoded file.
    Bytes(Vec<u8>),
}

/// The pixels of an image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and opacity of each pixel, row by row from the top, as they are stored (sRGB for colours).
    pub rgba: Vec<u8>,
}

/// An image with a sampler.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Index into [`crate::Scene::images`]; `None` if only an extension names an image.
    pub image: Option<usize>,
    /// Texture extensions that name further images (`EXT_texture_webp`, `KHR_texture_basisu`): (extension, image).
    pub alternatives: Vec<(String, usize)>,
    /// glTF sampler codes: magnification, minification, wrap S, wrap T.
    pub sampler: [Option<u32>; 4],
}

/// The use of a texture by a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TextureReference {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// The `n` of the attribute `TEXCOORD_n` that it reads.
    pub coordinates: u32,
    /// `KHR_texture_transform`: offset, rotation (rad), scale.
    pub transform: Option<([f32; 2], f32, [f32; 2])>,
    /// Normal scale or occlusion strength.
    pub strength: f32,
}

/// A material in the metallic–roughness model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name, may be empty.
    pub name: String,
    /// Linear base colour and opacity, each 0 to 1.
    pub base_color: [f32; 4],
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Linear emitted colour.
    pub emissive: [f32; 3],
    /// Base colour texture (sRGB).
    pub base_color_texture: Option<TextureReference>,
    /// Roughness in green, metalness in blue.
    pub metallic_roughness_texture: Option<TextureReference>,
    /// Tangent-space normal texture.
    pub normal_texture: Option<TextureReference>,
    /// Occlusion in red.
    pub occlusion_texture: Option<TextureReference>,
    /// Emission texture (sRGB).
    pub emissive_texture: Option<TextureReference>,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// `OPAQUE`, `MASK` or `BLEND`.
    pub alpha_mode: String,
    /// Threshold of `MASK`.
    pub alpha_cutoff: f32,
    /// Material extensions and extras as JSON text: (name, JSON). Only glTF files hold them.
    pub extensions: Vec<(String, String)>,
}

impl Default for Material {
    fn default() -> Self {
        Material {
            name: String::new(),
            base_color: [1.0; 4],
            metallic: 0.0,
            roughness: 1.0,
            emissive: [0.0; 3],
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive_texture: None,
            double_sided: false,
            alpha_mode: "OPAQUE".to_owned(),
            alpha_cutoff: 0.5,
            extensions: Vec::new(),
        }
    }
}
