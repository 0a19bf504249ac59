//! Shaders of the materials of a file, and of uniform colours.

use crate::error::PictureError;
use crate::shader::{Appearance, Hit, Shader};
use crate::texture::TexturedMaterial;
use glam::DVec3;
use greenstick_geometry::{Image, ImageSource, Material, Pixels, Scene};
use std::collections::BTreeMap;

/// Uniform materials, or those of a file: base colours and textures, multiplied by vertex colours (`COLOR_0`).
#[derive(Debug, Clone, PartialEq)]
pub struct PlainShader {
    /// Material of triangles without one.
    pub default: PlainMaterial,
    /// Materials by their numbers.
    pub materials: Vec<PlainMaterial>,
    /// Textures of materials by their numbers, as far as there are any.
    pub textures: Vec<Option<TexturedMaterial>>,
}

/// A uniform material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlainMaterial {
    /// Linear colour.
    pub color: [f64; 3],
    /// Roughness as in glTF, from 0 (mirror) to 1.
    pub roughness: f64,
}

impl PlainShader {
    /// A single linear colour for all triangles.
    pub fn uniform(color: [f64; 3]) -> Self {
        PlainShader {
            default: PlainMaterial {
                color,
                roughness: 0.7,
            },
            materials: Vec::new(),
            textures: Vec::new(),
        }
    }

    /// The base colours and roughnesses of materials; light grey for triangles without a material.
    pub fn from_materials(materials: &[Material]) -> Self {
        let plain = |m: &Material| {
            let [r, g, b, _] = m.base_color.map(f64::from);
            PlainMaterial {
                color: [r, g, b],
                roughness: f64::from(m.roughness),
            }
        };
        PlainShader {
            materials: materials.iter().map(plain).collect(),
            ..PlainShader::uniform([0.6; 3])
        }
    }
}

impl PlainShader {
    /// The materials of a scene, of which those that `is_shown` names by number have the textures whose images are in the scene.
    /// `read` decodes an image; `None` means that nothing can.
    ///
    /// # Errors
    /// [`PictureError::Image`] where an image cannot be read.
    pub fn with_textures(
        scene: &Scene,
        is_shown: impl Fn(usize, &Material) -> bool,
        read: impl Fn(&[u8]) -> Result<Option<Pixels>, String>,
    ) -> Result<PlainShader, PictureError> {
        let mut pixels = BTreeMap::new();
        let is_shown = |(number, material): &(usize, &Material)| is_shown(*number, material);
        let shown = scene.materials.iter().enumerate().filter(is_shown);
        for image in shown.flat_map(|(_, material)| TexturedMaterial::images(scene, material)) {
            let Some(Image {
                name,
                source: ImageSource::Bytes(bytes),
                ..
            }) = scene.images.get(image)
            else {
                continue;
            };
            if pixels.contains_key(&image) {
                continue;
            }
            let decoded = read(bytes).map_err(|problem| PictureError::Image {
                image,
                name: name.clone(),
                problem,
            })?;
            decoded.and_then(|decoded| pixels.insert(image, decoded));
        }
        let textured = |pair: (usize, &Material)| {
            let (_, material) = Some(pair).filter(is_shown)?;
            TexturedMaterial::new(scene, material, &pixels)
        };
        Ok(PlainShader {
            textures: scene.materials.iter().enumerate().map(textured).collect(),
            ..PlainShader::from_materials(&scene.materials)
        })
    }

    /// Whether a material is shown with its textures.
    pub fn is_textured(&self, material: u32) -> bool {
        self.textured(material).is_some()
    }

    fn textured(&self, material: u32) -> Option<&TexturedMaterial> {
        self.textures.get(material as usize)?.as_ref()
    }
}

impl Shader for PlainShader {
    fn shade(&self, hit: &Hit) -> Appearance {
        let number = hit.material();
        let textured = self.textured(number).and_then(|t| t.shade(hit));
        let mut appearance = textured.unwrap_or_else(|| {
            let material = self.materials.get(number as usize);
            let PlainMaterial { color, roughness } = *material.unwrap_or(&self.default);
            Appearance {
                color,
                roughness,
                normal: hit.normal,
                fibre: DVec3::ZERO,
            }
        });
        if let Some(vertex) = hit.attribute("COLOR_0") {
            (0..3).for_each(|c| appearance.color[c] *= vertex[c]);
        }
        appearance
    }

    fn has_holes(&self) -> bool {
        (self.textures.iter().flatten()).any(TexturedMaterial::has_holes)
    }

    fn is_hole(&self, hit: &Hit) -> bool {
        (self.textured(hit.material())).is_some_and(|t| t.is_hole(hit))
    }
}
