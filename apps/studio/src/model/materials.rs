//! What is shown of the input's materials: their textures, and where they are clear.

use greenstick::formats::pixels::read_pixels;
use greenstick::geometry::{ImageSource, Material, Pixels, Scene, TextureReference};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The images of a scene that were decoded, by their numbers; none for those that cannot be.
pub type DecodedImages = BTreeMap<usize, Option<Arc<Pixels>>>;

/// The use of an image as a texture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Index among the images of its kind.
    pub image: usize,
    /// Scale and offset of its coordinates.
    pub map: [f32; 4],
    /// Turn of its coordinates, rad.
    pub turn: f32,
    /// By how much a relief tilts normals.
    pub strength: f32,
    /// How coordinates beyond 0 to 1 are read, across and down.
    pub wraps: [Wrap; 2],
}

/// How coordinates of a texture beyond 0 to 1 are read (glTF 2.0, §3.8.4.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// The image is repeated.
    Repeat,
    /// Its edge goes on.
    ClampToEdge,
    /// It is repeated, and every other one is mirrored.
    MirroredRepeat,
}

impl Wrap {
    /// All of them.
    pub const ALL: [Wrap; 3] = [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat];

    /// That of a sampler's code.
    fn of(code: Option<u32>) -> Self {
        match code {
            Some(33_071) => Wrap::ClampToEdge,
            Some(33_648) => Wrap::MirroredRepeat,
            _ => Wrap::Repeat,
        }
    }
}

/// What opacity means, as glTF 2.0 (§3.9.4) has it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Opacity {
    /// Nothing.
    Opaque,
    /// There is a hole where it is less than this.
    Masked(f32),
    /// How much is seen of a surface, and how little of what lies behind it.
    Blended,
}

impl Opacity {
    /// That of a material.
    pub fn of(material: &Material) -> Self {
        match &*material.alpha_mode {
            "MASK" => Opacity::Masked(material.alpha_cutoff),
            "BLEND" => Opacity::Blended,
            _ => Opacity::Opaque,
        }
    }
}

/// Images that are drawn, each once, by their numbers in the scene.
pub(super) struct Images<'a> {
    scene: &'a Scene,
    decoded: &'a mut DecodedImages,
    numbers: BTreeMap<usize, Option<usize>>,
    /// The images.
    pub drawn: Vec<Arc<Pixels>>,
}

impl<'a> Images<'a> {
    pub fn new(scene: &'a Scene, decoded: &'a mut DecodedImages) -> Self {
        Images {
            scene,
            decoded,
            numbers: BTreeMap::new(),
            drawn: Vec::new(),
        }
    }

    /// The texture that a material refers to; none where it has no image that can be decoded.
    pub fn texture(&mut self, reference: Option<&TextureReference>) -> Option<Texture> {
        let reference = reference?;
        let image = image_of(self.scene, reference)?;
        let (scene, decoded, drawn) = (self.scene, &mut *self.decoded, &mut self.drawn);
        let decode = || match &scene.images.get(image)?.source {
            ImageSource::Bytes(bytes) => Some(Arc::new(read_pixels(bytes).ok()?)),
            ImageSource::Reference(_) => None,
        };
        let found = *self.numbers.entry(image).or_insert_with(|| {
            let known = decoded.entry(image).or_insert_with(decode).as_ref()?;
            drawn.push(known.clone());
            Some(drawn.len() - 1)
        });
        let [_, _, across, down] = (scene.textures.get(reference.texture))?.sampler;
        let wraps = [across, down].map(Wrap::of);
        let (offset, turn, scale) = reference.transform.unwrap_or(([0.0; 2], 0.0, [1.0; 2]));
        Some(Texture {
            image: found?,
            map: [scale[0], scale[1], offset[0], offset[1]],
            turn,
            strength: reference.strength,
            wraps,
        })
    }
}

/// The image of a texture: its WebP if it has one, which those have that know the extension, else its usual one.
fn image_of(scene: &Scene, reference: &TextureReference) -> Option<usize> {
    let texture = scene.textures.get(reference.texture)?;
    let webp = texture.alternatives.iter();
    let webp = webp.filter(|(extension, _)| extension == "EXT_texture_webp");
    webp.map(|(_, image)| *image).next().or(texture.image)
}
