//! The materials of broken wood: the wood inside with its baked textures, and bark where the input has no material.

use crate::broken::lacks_material;
use crate::texture::{self, SectionSquare, TextureError, TexturedWood, WoodTextures};
use glam::DVec2;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{
    Context, Image, ImageSource, Material, Scene, Texture, TextureReference,
};
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::branch::{BARK_MATERIAL_NAME, bark_material};
use greenstick_wood::stem::Stem;

/// Name of the material of the wood inside.
const INNER_WOOD_NAME: &str = "inner_wood";

/// Returns for each material of a scene whether it has no colour to show: our own bark, materials without a colour, and those
/// whose colour is in a texture.
pub fn without_color(scene: &Scene) -> Vec<bool> {
    let without = |m: &Material| {
        m.name == BARK_MATERIAL_NAME
            || m.base_color_texture.is_some()
            || m.base_color[..3] == [1.0; 3]
    };
    scene.materials.iter().map(without).collect()
}

/// Returns the number of the next material of a scene, once its triangles without one have bark.
pub fn next_material(scene: &Scene) -> u32 {
    let lacks_bark = scene.nodes.iter().any(|n| lacks_material(&n.mesh));
    scene.materials.len() as u32 + u32::from(lacks_bark)
}

/// Gives bark to the triangles of a scene that have no material.
pub fn add_missing_bark(scene: &mut Scene) {
    if !scene.nodes.iter().any(|n| lacks_material(&n.mesh)) {
        return;
    }
    let bark = scene.materials.len() as u32;
    scene.materials.push(bark_material());
    scene.change_meshes(lacks_material, |mesh| {
        mesh.materials.resize(mesh.triangles.len(), NO_MATERIAL);
        let lacking = mesh.materials.iter_mut().filter(|m| **m == NO_MATERIAL);
        lacking.for_each(|m| *m = bark);
    });
}

/// Bakes the textures of the wood inside a stem, `width` pixels wide.
///
/// # Errors
/// [`TextureError`] where the width or the square is out of range or the caller cancelled.
pub fn bake(
    stem: &Stem,
    square: SectionSquare,
    appearance: &StemAppearance,
    width: u32,
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    let pith = stem.rings.pith();
    let wood = TexturedWood {
        middle: square.middle - pith,
        section: &|p: DVec2| stem.rings.address(p + pith),
        appearance: &appearance.wood,
        rings: &*appearance.rings,
    };
    texture::bake(width, square.side, wood, context)
}

/// Adds a material of the wood inside without textures, in the colour of its sapwood.
pub fn add_plain_inner_wood(scene: &mut Scene, appearance: &StemAppearance) {
    let [r, g, b] = appearance.wood.sapwood_color.map(|c| c as f32);
    scene.materials.push(Material {
        name: INNER_WOOD_NAME.into(),
        base_color: [r, g, b, 1.0],
        ..Material::default()
    });
}

/// Adds the material of the wood inside with its textures, which cover `square`.
pub fn add_inner_wood(scene: &mut Scene, square: SectionSquare, baked: &WoodTextures) {
    let mut reference = |name: &str, bytes: &[u8]| {
        let image = Image {
            name: format!("inner_wood_{name}"),
            mime_type: "image/png".into(),
            source: ImageSource::Bytes(bytes.to_vec()),
        };
        scene.images.push(image);
        // Linear filtering with mipmaps; clamped across, repeating along the grain.
        let sampler = [Some(9729), Some(9987), Some(33071), Some(10497)];
        scene.textures.push(Texture {
            image: Some(scene.images.len() - 1),
            alternatives: Vec::new(),
            sampler,
        });
        let scale = [(0.5 / square.side) as f32, (1.0 / square.side) as f32];
        TextureReference {
            texture: scene.textures.len() - 1,
            coordinates: 0,
            transform: Some(([0.0, 0.0], 0.0, scale)),
            strength: 1.0,
        }
    };
    let (color, normal, roughness) = (
        reference("color", &baked.color),
        reference("normal", &baked.normal),
        reference("roughness", &baked.roughness),
    );
    scene.materials.push(Material {
        name: INNER_WOOD_NAME.into(),
        base_color_texture: Some(color),
        normal_texture: Some(normal),
        metallic_roughness_texture: Some(roughness),
        ..Material::default()
    });
}
