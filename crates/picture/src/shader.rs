//! Intersections of rays with surfaces, and the appearance of surfaces.

use crate::error::PictureError;
use crate::texture::TexturedMaterial;
use glam::{DAffine3, DVec3, DVec4};
use greenstick_geometry::{Image, ImageSource, Material, Mesh, Pixels, Scene};
use std::collections::BTreeMap;

/// The intersection of a ray with a mesh.
pub struct Hit<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Number of the triangle in the mesh.
    pub triangle: usize,
    /// Weights of the corners of the triangle; they add up to 1.
    pub barycentric: [f64; 3],
    /// Position in the world, m.
    pub position: DVec3,
    /// Unit normal for shading, on the side of the viewer: interpolated from `NORMAL`, else the geometric normal.
    pub normal: DVec3,
    /// Unit normal of the triangle, on the side of the viewer.
    pub geometric_normal: DVec3,
    /// Size of a pixel at this position, m. Finer detail should be averaged.
    pub footprint: f64,
    /// Corners of the triangle in the world, m.
    pub(crate) corners: [DVec3; 3],
}

impl<'a> Hit<'a> {
    /// The values of an attribute at the corners of the triangle; missing components are 0.
    fn at_corners(&self, name: &str) -> Option<[DVec4; 3]> {
        let attribute = self.mesh.attributes.get(name)?;
        let mut values = [DVec4::ZERO; 3];
        for (value, &vertex) in values.iter_mut().zip(&self.mesh.triangles[self.triangle]) {
            let start = vertex as usize * attribute.width;
            let found = attribute.data.get(start..start + attribute.width)?;
            for (c, &f) in found.iter().take(4).enumerate() {
                value[c] = f64::from(f);
            }
        }
        Some(values)
    }

    /// Interpolates an attribute at the intersection; missing components are 0. Returns `None` if the mesh does not have it.
    pub fn attribute(&self, name: &str) -> Option<[f64; 4]> {
        let [a, b, c] = self.at_corners(name)?;
        let [u, v, w] = self.barycentric;
        Some((a * u + b * v + c * w).to_array())
    }

    /// Computes the gradients of the first three components of an attribute along the surface, per metre in the world.
    /// They lie in the plane of the triangle. A shader uses them to turn the slope of a height that depends on the
    /// attribute into a normal ([`Hit::bumped_normal`]).
    pub fn gradients(&self, name: &str) -> Option<[DVec3; 3]> {
        let [a, b, c] = self.at_corners(name)?;
        let [p, q, r] = self.corners;
        let (e, f) = (q - p, r - p);
        let n = e.cross(f);
        let square = n.length_squared();
        if square == 0.0 {
            return None;
        }
        // The dual basis of two edges in the plane.
        let (along_e, along_f) = (f.cross(n) / square, n.cross(e) / square);
        let (db, dc) = (b - a, c - a);
        Some([0, 1, 2].map(|i| along_e * db[i] + along_f * dc[i]))
    }

    /// The shading normal tilted by a relief whose height has the gradient `slope` (m per m).
    pub fn bumped_normal(&self, slope: DVec3) -> DVec3 {
        let tangential = slope - self.normal * self.normal.dot(slope);
        (self.normal - tangential).normalize_or(self.normal)
    }

    /// The material of the triangle, or [`NO_MATERIAL`](greenstick_geometry::mesh::NO_MATERIAL).
    pub fn material(&self) -> u32 {
        self.mesh.material(self.triangle)
    }

    /// The intersection with a triangle of a mesh with the given transform.
    pub(crate) fn new(
        mesh: &'a Mesh,
        transform: &DAffine3,
        triangle: usize,
        barycentric: [f64; 3],
        to_viewer: DVec3,
    ) -> Hit<'a> {
        let corners = mesh
            .corners(triangle)
            .map(|p| transform.transform_point3(p));
        let [a, b, c] = corners;
        let [u, v, w] = barycentric;
        let flat = (b - a).cross(c - a).normalize_or(to_viewer);
        let geometric = if flat.dot(to_viewer) < 0.0 {
            -flat
        } else {
            flat
        };
        let mut hit = Hit {
            mesh,
            triangle,
            barycentric,
            position: a * u + b * v + c * w,
            normal: geometric,
            geometric_normal: geometric,
            footprint: 0.0,
            corners,
        };
        if let Some(n) = hit.attribute("NORMAL") {
            let m = transform.matrix3;
            // The cofactor matrix has the direction of the inverse transpose without division by the determinant.
            let cofactors = [
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            ];
            let n = cofactors[0] * n[0] + cofactors[1] * n[1] + cofactors[2] * n[2];
            let n = n.normalize_or(geometric);
            // Seen from the inside, normals point away from the viewer.
            hit.normal = if n.dot(geometric) < 0.0 { -n } else { n };
        }
        hit
    }
}

/// The appearance of a surface at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// Linear diffuse colour, components from 0 to 1.
    pub color: [f64; 3],
    /// Roughness as in glTF, from 0 (mirror) to 1.
    pub roughness: f64,
    /// Unit normal, including relief finer than the mesh.
    pub normal: DVec3,
}

/// Provides the appearance of surfaces.
pub trait Shader {
    /// Returns the appearance of the surface at an intersection.
    fn shade(&self, hit: &Hit) -> Appearance;

    /// Whether some surface has holes that its triangles do not show; only then [`Shader::is_hole`] is asked.
    fn has_holes(&self) -> bool {
        false
    }

    /// Whether there is nothing at an intersection, so that rays go on.
    fn is_hole(&self, _hit: &Hit) -> bool {
        false
    }
}

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
