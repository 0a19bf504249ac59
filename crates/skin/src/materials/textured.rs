//! Materials with baked textures.

use crate::texture::WoodTextures;
use greenstick_geometry::{Image, ImageSource, Material, Scene, Texture, TextureReference};

/// Codes of glTF for textures that repeat and that end with their last texels.
pub(super) const REPEATING: u32 = 10497;
pub(super) const CLAMPED: u32 = 33071;

/// Returns a material with its textures, which it adds to a scene; `across` is the code of how they go on along u.
pub(super) fn textured(
    scene: &mut Scene,
    material: &str,
    baked: &WoodTextures,
    across: u32,
    transform: Option<([f32; 2], f32, [f32; 2])>,
) -> Material {
    let mut reference = |name: &str, bytes: &[u8]| {
        let image = Image {
            name: format!("{material}_{name}"),
            mime_type: "image/png".into(),
            source: ImageSource::Bytes(bytes.to_vec()),
        };
        scene.images.push(image);
        // Linear filtering with mipmaps.
        let sampler = [Some(9729), Some(9987), Some(across), Some(REPEATING)];
        scene.textures.push(Texture {
            image: Some(scene.images.len() - 1),
            alternatives: Vec::new(),
            sampler,
        });
        TextureReference {
            texture: scene.textures.len() - 1,
            coordinates: 0,
            transform,
            strength: 1.0,
        }
    };
    let (color, normal, roughness) = (
        reference("color", &baked.color),
        reference("normal", &baked.normal),
        reference("roughness", &baked.roughness),
    );
    Material {
        name: material.into(),
        base_color_texture: Some(color),
        normal_texture: Some(normal),
        metallic_roughness_texture: Some(roughness),
        ..Material::default()
    }
}
