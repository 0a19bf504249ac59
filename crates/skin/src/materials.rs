//! The materials of broken wood: the wood inside with its baked textures, and bark where the input has no material.

mod outside;
mod textured;

use crate::broken::lacks_material;
use crate::prepared::PreparedStem;
use crate::texture::{self, PlanedFaces, SectionSquare, TextureError, TexturedWood, WoodTextures};
use glam::DVec2;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Context, Material, Scene, Stage};
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::branch::{BARK_MATERIAL_NAME, bark_material};
use greenstick_wood::stem::{Stem, StemKind};
use outside::dress_outside;
use textured::{CLAMPED, textured};

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

/// Whether a material is our own bark, which is finer by its model than by its texture.
pub fn is_own_bark(scene: &Scene, material: &Material) -> bool {
    let texture = material.base_color_texture.as_ref();
    let texture = texture.and_then(|t| scene.textures.get(t.texture));
    let image = texture.and_then(|t| scene.images.get(t.image?));
    material.name == BARK_MATERIAL_NAME && image.is_none_or(|i| i.name.starts_with("bark_"))
}

/// Returns the number of the next material of a scene, once its triangles without one have bark.
pub fn next_material(scene: &Scene) -> u32 {
    let lacks_bark = scene.nodes.iter().any(|n| lacks_material(&n.mesh));
    scene.materials.len() as u32 + u32::from(lacks_bark)
}

/// Gives bark to the triangles of a scene that have no material. Returns the number of its material, if there are any.
pub fn add_missing_bark(scene: &mut Scene) -> Option<u32> {
    if !scene.nodes.iter().any(|n| lacks_material(&n.mesh)) {
        return None;
    }
    let bark = scene.materials.len() as u32;
    scene.materials.push(bark_material());
    scene.change_meshes(lacks_material, |mesh| {
        mesh.materials.resize(mesh.triangles.len(), NO_MATERIAL);
        let lacking = mesh.materials.iter_mut().filter(|m| **m == NO_MATERIAL);
        lacking.for_each(|m| *m = bark);
    });
    Some(bark)
}

/// Textures of a stem.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BakedWood {
    /// The wood inside.
    pub inside: WoodTextures,
    /// The outside, where the input has no material: bark around a round stem, planed wood around
    /// sawn wood, weathered wood around a pole.
    pub outside: Option<WoodTextures>,
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
        pith,
        section: &|p: DVec2| stem.rings.address(p + pith),
        point: &|rho, angle| stem.rings.point(rho, angle) - pith,
        appearance: &appearance.wood,
        rings: &*appearance.rings,
    };
    texture::bake(width, square, wood, context)
}

/// Everything that determines the textures of a stem: equal keys have equal textures.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureKey {
    stem: Stem,
    square: SectionSquare,
    appearance: StemAppearance,
    width: u32,
}

impl TextureKey {
    /// The key of textures that [`bake_stem`] would bake.
    pub fn new(prepared: &PreparedStem, appearance: &StemAppearance, width: u32) -> Self {
        TextureKey {
            stem: prepared.found.stem.clone(),
            square: prepared.square,
            appearance: appearance.clone(),
            width,
        }
    }
}

/// Quarters of the width of the textures inside that the bark has: its figure is coarser than that of wood.
const BARK_QUARTERS: u32 = 3;

/// Bakes the bark of a round stem for textures of the wood inside that are `width` pixels wide.
///
/// # Errors
/// As [`bake`].
pub(crate) fn bake_bark(
    stem: &Stem,
    appearance: &StemAppearance,
    width: u32,
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    let width = (width / 4 * BARK_QUARTERS)
        .next_multiple_of(2)
        .max(texture::MIN_WIDTH);
    texture::bake_bark(width, &appearance.bark, stem.radius, context)
}

/// Adds a material of bark with its textures, which repeat with every turn and circumference.
#[cfg(feature = "rods")]
pub(crate) fn add_bark(scene: &mut Scene, baked: &WoodTextures) {
    let material = outside::repeating(scene, BARK_MATERIAL_NAME, baked);
    scene.materials.push(material);
}

/// Bakes the textures of a prepared stem, those of the wood inside `width` pixels wide.
///
/// # Errors
/// As [`bake`].
pub fn bake_stem(
    prepared: &PreparedStem,
    appearance: &StemAppearance,
    width: u32,
    context: &Context,
) -> Result<BakedWood, TextureError> {
    let (stem, square) = (&prepared.found.stem, prepared.square);
    let stage = Stage::new("textures");
    let [inside, outside] = context.split([(stage, 2.0), (stage, 1.0)]);
    let baked = bake(stem, square, appearance, width, &inside)?;
    let pith = stem.rings.pith();
    let outside = match stem.kind {
        _ if !prepared.scene.nodes.iter().any(|n| lacks_material(&n.mesh)) => None,
        StemKind::Round => Some(bake_bark(stem, appearance, width, &outside)?),
        StemKind::Board | StemKind::Dowel | StemKind::Pole => {
            let weathered = stem.kind == StemKind::Pole;
            let wood = TexturedWood {
                pith,
                section: &|p: DVec2| stem.rings.address(p + pith),
                point: &|rho, angle| stem.rings.point(rho, angle) - pith,
                appearance: &appearance.wood,
                rings: &*appearance.rings,
            };
            Some(texture::bake_planed(
                width,
                &PlanedFaces::of_stem(stem, square),
                (wood, weathered),
                &outside,
            )?)
        }
    };
    Ok(BakedWood {
        inside: baked,
        outside,
    })
}

/// Adds the material of the wood inside a break, and dresses the outside that has `bark`, the material that
/// [`add_missing_bark`] gave to it: textures, coordinates on them, and sawn wood at the ends.
pub fn add_wood(
    scene: &mut Scene,
    bark: Option<u32>,
    prepared: &PreparedStem,
    baked: Option<&BakedWood>,
    appearance: &StemAppearance,
) {
    let Some(baked) = baked else {
        return add_plain_inner_wood(scene, appearance);
    };
    add_inner_wood(scene, prepared.square, &baked.inside);
    if let (Some(bark), Some(outside)) = (bark, &baked.outside) {
        dress_outside(scene, bark, prepared, outside);
    }
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
    // Clamped across, repeating along the grain.
    let transform = Some(([0.0, 0.0], 0.0, square.scale()));
    let material = textured(scene, INNER_WOOD_NAME, baked, CLAMPED, transform);
    scene.materials.push(material);
}
