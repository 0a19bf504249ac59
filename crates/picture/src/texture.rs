//! Textures of materials, as glTF 2.0 (§3.8, §3.9) describes them: colour, roughness and normals, of which detail finer than a
//! pixel is averaged (mipmaps).

use crate::sampling::hash;
use crate::shader::{Appearance, Hit};
use glam::{DVec3, DVec4};
use greenstick_geometry::{Material, Pixels, Scene, TextureReference};
use std::collections::BTreeMap;

/// glTF's codes of samplers: how coordinates beyond 0 to 1 are read.
const CLAMP_TO_EDGE: u32 = 33_071;
const MIRRORED_REPEAT: u32 = 33_648;

/// What the random numbers of holes are for.
const HOLES: u32 = 0x484f_4c45;

/// How the values of a texture are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Coding {
    Srgb,
    Linear,
}

/// One of the halving sizes of an image: linear values, as parts of 65535.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    size: [usize; 2],
    values: Vec<[u16; 4]>,
}

/// A texture with the coordinates that it reads.
#[derive(Debug, Clone, PartialEq)]
struct Map {
    /// The whole image first, a single pixel last.
    levels: Vec<Level>,
    /// glTF's codes for the two coordinates.
    wraps: [u32; 2],
    attribute: String,
    transform: Option<([f32; 2], f32, [f32; 2])>,
    strength: f64,
}

/// The textures of a material, and what they are multiplied by.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedMaterial {
    color: Map,
    roughness: Option<Map>,
    normal: Option<Map>,
    factor: [f64; 4],
    roughness_factor: f64,
    opacity: Opacity,
}

/// What opacity means, as glTF 2.0 (§3.9.4) has it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Opacity {
    /// Nothing.
    Opaque,
    /// There is a hole where it is less than this.
    Masked(f64),
    /// The part of the rays that meet the surface. Each ray meets it or does not (stochastic transparency, Enderton et al. 2010), which
    /// the many rays of a pixel average.
    Blended,
}

impl Level {
    fn whole(pixels: &Pixels, coding: Coding) -> Level {
        let curve: Vec<u16> = (0..256)
            .map(|i| {
                let v = f64::from(i) / 255.0;
                let linear = match coding {
                    Coding::Linear => v,
                    Coding::Srgb if v <= 0.040_45 => v / 12.92,
                    Coding::Srgb => libm::pow((v + 0.055) / 1.055, 2.4),
                };
                (linear * 65_535.0 + 0.5) as u16
            })
            .collect();
        let value = |c: &[u8]| {
            let part = |i: usize| curve[usize::from(c[i])];
            [part(0), part(1), part(2), u16::from(c[3]) * 257]
        };
        Level {
            size: [pixels.width as usize, pixels.height as usize],
            values: pixels.rgba.chunks_exact(4).map(value).collect(),
        }
    }

    fn halved(&self) -> Level {
        let size = self.size.map(|n| n.div_ceil(2));
        let pair = |at: usize, axis: usize| [2 * at, (2 * at + 1).min(self.size[axis] - 1)];
        let value = |x: usize, y: usize| {
            let mut sum = [0u32; 4];
            for row in pair(y, 1) {
                for column in pair(x, 0) {
                    let v = self.values[row * self.size[0] + column];
                    (0..4).for_each(|c| sum[c] += u32::from(v[c]));
                }
            }
            sum.map(|v| ((v + 2) / 4) as u16)
        };
        let value = &value;
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| value(x, y)));
        Level {
            size,
            values: places.collect(),
        }
    }

    /// The value at a place in pixels, linear between the middles of pixels.
    fn at(&self, [x, y]: [f64; 2], wraps: [u32; 2]) -> DVec4 {
        let part = |place: f64, axis: usize| {
            let below = (place - 0.5).floor();
            let index = |i: f64| wrapped(i as i64, self.size[axis] as i64, wraps[axis]);
            (index(below), index(below + 1.0), place - 0.5 - below)
        };
        let (left, right, along) = part(x, 0);
        let (top, bottom, down) = part(y, 1);
        let value = |x: usize, y: usize| {
            DVec4::from_array(self.values[y * self.size[0] + x].map(f64::from)) / 65_535.0
        };
        let upper = value(left, top).lerp(value(right, top), along);
        let lower = value(left, bottom).lerp(value(right, bottom), along);
        upper.lerp(lower, down)
    }
}

/// The pixel of a row of `size` that a number beyond it stands for.
fn wrapped(i: i64, size: i64, wrap: u32) -> usize {
    let i = match wrap {
        CLAMP_TO_EDGE => i.clamp(0, size - 1),
        MIRRORED_REPEAT => {
            let turn = i.rem_euclid(2 * size);
            turn.min(2 * size - 1 - turn)
        }
        _ => i.rem_euclid(size),
    };
    i as usize
}

impl Map {
    /// The map of a texture, if its image is among `pixels` by its number.
    fn new(
        scene: &Scene,
        reference: Option<&TextureReference>,
        pixels: &BTreeMap<usize, Pixels>,
        coding: Coding,
    ) -> Option<Map> {
        let reference = reference?;
        let pixels = pixels.get(&image_of(scene, reference)?)?;
        let count = pixels.width as usize * pixels.height as usize;
        if count == 0 || pixels.rgba.len() != 4 * count {
            return None;
        }
        let mut levels = vec![Level::whole(pixels, coding)];
        while let Some(last) = levels.last()
            && last.size != [1, 1]
        {
            levels.push(last.halved());
        }
        let sampler = scene.textures[reference.texture].sampler;
        Some(Map {
            levels,
            wraps: [sampler[2], sampler[3]].map(|code| code.unwrap_or(0)),
            attribute: format!("TEXCOORD_{}", reference.coordinates),
            transform: reference.transform,
            strength: f64::from(reference.strength),
        })
    }

    /// The coordinates at a hit, and their gradients along the surface, per metre.
    fn coordinates(&self, hit: &Hit) -> Option<([f64; 2], [DVec3; 2])> {
        let [u, v, ..] = hit.attribute(&self.attribute)?;
        let [du, dv, _] = hit.gradients(&self.attribute)?;
        let Some((offset, turn, scale)) = self.transform else {
            return Some(([u, v], [du, dv]));
        };
        let (sine, cosine) = libm::sincos(f64::from(turn));
        let [sx, sy] = scale.map(f64::from);
        let [ox, oy] = offset.map(f64::from);
        // As KHR_texture_transform: scaled, turned, moved.
        let (u, v, du, dv) = (u * sx, v * sy, du * sx, dv * sy);
        Some((
            [cosine * u + sine * v + ox, cosine * v - sine * u + oy],
            [du * cosine + dv * sine, dv * cosine - du * sine],
        ))
    }

    /// The mean value over a pixel.
    fn value(&self, [u, v]: [f64; 2], [du, dv]: [DVec3; 2], footprint: f64) -> DVec4 {
        let [width, height] = self.levels[0].size.map(|n| n as f64);
        let covered = footprint * (du.length() * width).max(dv.length() * height);
        let last = (self.levels.len() - 1) as f64;
        let level = libm::log2(covered.max(1.0)).min(last);
        let at = |n: usize| {
            let level = &self.levels[n];
            let [width, height] = level.size.map(|n| n as f64);
            level.at([u * width, v * height], self.wraps)
        };
        let below = level as usize;
        let above = (below + 1).min(self.levels.len() - 1);
        at(below).lerp(at(above), level - below as f64)
    }

    fn read(&self, hit: &Hit) -> Option<DVec4> {
        let (at, gradients) = self.coordinates(hit)?;
        Some(self.value(at, gradients, hit.footprint))
    }
}

/// The image of a texture: its WebP if it has one, which those have that know the extension, else its usual one.
fn image_of(scene: &Scene, reference: &TextureReference) -> Option<usize> {
    let texture = scene.textures.get(reference.texture)?;
    let webp = texture.alternatives.iter();
    let webp = webp.filter(|(extension, _)| extension == "EXT_texture_webp");
    webp.map(|(_, image)| *image).next().or(texture.image)
}

impl TexturedMaterial {
    /// The numbers of the images that a picture of a material shows; none where its colour has no texture.
    pub fn images(scene: &Scene, material: &Material) -> Vec<usize> {
        if material.base_color_texture.is_none() {
            return Vec::new();
        }
        let references = [
            &material.base_color_texture,
            &material.metallic_roughness_texture,
            &material.normal_texture,
        ];
        (references.into_iter().flatten())
            .filter_map(|reference| image_of(scene, reference))
            .collect()
    }

    /// The textures of a material of a scene, whose images are among `pixels` by their numbers; `None` where that of its colour is not.
    pub fn new(
        scene: &Scene,
        material: &Material,
        pixels: &BTreeMap<usize, Pixels>,
    ) -> Option<TexturedMaterial> {
        let map = |reference: &Option<TextureReference>, coding| {
            Map::new(scene, reference.as_ref(), pixels, coding)
        };
        Some(TexturedMaterial {
            color: map(&material.base_color_texture, Coding::Srgb)?,
            roughness: map(&material.metallic_roughness_texture, Coding::Linear),
            normal: map(&material.normal_texture, Coding::Linear),
            factor: material.base_color.map(f64::from),
            roughness_factor: f64::from(material.roughness),
            opacity: match &*material.alpha_mode {
                "MASK" => Opacity::Masked(f64::from(material.alpha_cutoff)),
                "BLEND" => Opacity::Blended,
                _ => Opacity::Opaque,
            },
        })
    }

    /// Whether there may be holes.
    pub fn has_holes(&self) -> bool {
        self.opacity != Opacity::Opaque
    }

    /// Whether there is a hole at a hit.
    pub fn is_hole(&self, hit: &Hit) -> bool {
        let opacity = || Some(self.color.read(hit)?.w * self.factor[3]);
        match self.opacity {
            Opacity::Opaque => false,
            Opacity::Masked(cutoff) => opacity().is_some_and(|o| o < cutoff),
            Opacity::Blended => opacity().is_some_and(|o| o <= chance_at(hit.position)),
        }
    }

    /// The appearance at a hit; `None` where the mesh lacks the coordinates.
    pub fn shade(&self, hit: &Hit) -> Option<Appearance> {
        let value = self.color.read(hit)?.to_array();
        let roughness = self.roughness.as_ref().and_then(|map| map.read(hit));
        let normal = self.normal.as_ref().and_then(|map| {
            let (at, gradients) = map.coordinates(hit)?;
            let value = map.value(at, gradients, hit.footprint) * 2.0 - 1.0;
            tilted(hit.normal, gradients, value.truncate(), map.strength)
        });
        Some(Appearance {
            color: std::array::from_fn(|c| value[c] * self.factor[c]),
            roughness: self.roughness_factor * roughness.map_or(1.0, |value| value.y),
            normal: normal.unwrap_or(hit.normal),
            fibre: DVec3::ZERO,
        })
    }
}

/// A number from 0 to less than 1 for a position, as good as random from each to the next.
fn chance_at(position: DVec3) -> f64 {
    let bits = position.as_vec3().to_array().map(f32::to_bits);
    let mixed = bits.into_iter().fold(HOLES, hash);
    f64::from(mixed) / (f64::from(u32::MAX) + 1.0)
}

/// A normal tilted by one of a texture, whose x runs along u and whose y runs against v, which counts downwards.
fn tilted(normal: DVec3, [du, dv]: [DVec3; 2], from: DVec3, strength: f64) -> Option<DVec3> {
    // The direction in which u grows and v stays the same, and the other way round.
    let along = |a: DVec3, b: DVec3| {
        let flat = a - b * (a.dot(b) / b.length_squared());
        (flat - normal * normal.dot(flat)).try_normalize()
    };
    let (right, down) = (along(du, dv)?, along(dv, du)?);
    let tilt = right * (from.x * strength) - down * (from.y * strength) + normal * from.z;
    tilt.try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use greenstick_geometry::{Attribute, Mesh, Texture};

    /// A square of side 1 whose texture has 4 × 4 pixels: red grows to the right, green downwards; the last column is clear.
    fn square(coding_of_normal: Option<[u8; 3]>) -> (Mesh, Scene, BTreeMap<usize, Pixels>) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        // v counts downwards.
        let data = corners
            .iter()
            .flat_map(|c| [c[0] as f32, 1.0 - c[1] as f32]);
        mesh.attributes.insert(
            "TEXCOORD_0".to_owned(),
            Attribute {
                width: 2,
                data: data.collect(),
            },
        );
        let pixels = |value: &dyn Fn(u8, u8) -> [u8; 4]| Pixels {
            width: 4,
            height: 4,
            rgba: (0..16).flat_map(|i| value(i % 4, i / 4)).collect(),
        };
        let reference = |texture| TextureReference {
            texture,
            coordinates: 0,
            transform: None,
            strength: 1.0,
        };
        let texture = |image| Texture {
            image: Some(image),
            alternatives: Vec::new(),
            sampler: [None; 4],
        };
        let scene = Scene {
            materials: vec![Material {
                base_color_texture: Some(reference(0)),
                normal_texture: coding_of_normal.map(|_| reference(1)),
                alpha_mode: "MASK".to_owned(),
                ..Material::default()
            }],
            textures: vec![texture(0), texture(1)],
            ..Scene::default()
        };
        let color = pixels(&|x, y| [x * 85, y * 85, 0, if x == 3 { 0 } else { 255 }]);
        let [r, g, b] = coding_of_normal.unwrap_or_default();
        let normal = pixels(&|_, _| [r, g, b, 255]);
        (mesh, scene, BTreeMap::from([(0, color), (1, normal)]))
    }

    fn hit(mesh: &Mesh, x: f64, y: f64, footprint: f64) -> Hit<'_> {
        // In the first triangle, below the diagonal.
        let weights = [1.0 - x, x - y, y];
        let mut hit = Hit::new(mesh, &DAffine3::IDENTITY, 0, weights, DVec3::Z);
        hit.footprint = footprint;
        hit
    }

    #[test]
    fn colours_are_where_the_coordinates_say_and_far_away_their_mean() {
        let (mesh, scene, pixels) = square(None);
        let textured = TexturedMaterial::new(&scene, &scene.materials[0], &pixels).unwrap();
        // The middle of the third pixel of the lowest row: sRGB 170 and 255.
        let near = textured.shade(&hit(&mesh, 0.625, 0.125, 1e-9)).unwrap();
        assert!((near.color[0] - 0.402).abs() < 1e-3, "{:?}", near.color);
        assert!((near.color[1] - 1.0).abs() < 1e-3 && near.color[2] == 0.0);
        // The mean of the linear values of 0, 85, 170 and 255.
        let far = textured.shade(&hit(&mesh, 0.7, 0.1, 9.0)).unwrap();
        let mean = (0.0 + 0.0908 + 0.402 + 1.0) / 4.0;
        assert!((far.color[0] - mean).abs() < 1e-3, "{:?}", far.color);
        assert!(textured.is_hole(&hit(&mesh, 0.875, 0.1, 1e-9)));
        assert!(!textured.is_hole(&hit(&mesh, 0.5, 0.1, 1e-9)));
    }

    #[test]
    fn rays_go_through_what_is_blended_as_often_as_it_is_clear() {
        let (mesh, mut scene, pixels) = square(None);
        scene.materials[0].alpha_mode = "BLEND".to_owned();
        let holes = |scene: &Scene, column: f64| {
            let textured = TexturedMaterial::new(scene, &scene.materials[0], &pixels).unwrap();
            let rays = (0..2000).filter(|i| {
                let y = 0.09 * f64::from(*i) / 2000.0;
                textured.is_hole(&hit(&mesh, column, y, 1e-9))
            });
            rays.count()
        };
        // The last column is clear, the first are not.
        assert_eq!((holes(&scene, 0.4), holes(&scene, 0.875)), (0, 2000));
        scene.materials[0].base_color[3] = 0.3;
        let through = holes(&scene, 0.4);
        // 0.7 of 2000, within four standard deviations.
        assert!((1318..1482).contains(&through), "{through}");
    }

    #[test]
    fn green_of_a_normal_points_up_in_the_texture() {
        let (mesh, scene, pixels) = square(Some([128, 218, 218]));
        let textured = TexturedMaterial::new(&scene, &scene.materials[0], &pixels).unwrap();
        let normal = textured.shade(&hit(&mesh, 0.4, 0.2, 1e-9)).unwrap().normal;
        let expected = DVec3::new(0.0, 1.0, 1.0).normalize();
        assert!(normal.distance(expected) < 0.01, "{normal}");
    }
}
