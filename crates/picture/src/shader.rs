//! What a ray met, and what the surface looks like there.

use crate::Item;
use glam::{DVec3, DVec4};
use greenstick_geometry::{Material, Mesh};

/// Where a ray met a mesh.
pub struct Hit<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Number of the triangle in the mesh.
    pub triangle: usize,
    /// Weights of the triangle's corners, summing to 1.
    pub barycentric: [f64; 3],
    /// Place in the world, m.
    pub position: DVec3,
    /// Unit normal to shade with, on the viewer's side: interpolated from `NORMAL`, else the geometric one.
    pub normal: DVec3,
    /// Unit normal of the triangle, on the viewer's side.
    pub geometric_normal: DVec3,
    /// Size of a pixel at this place, m: detail finer than that should be averaged.
    pub footprint: f64,
    pub(crate) corners: [DVec3; 3],
}

impl<'a> Hit<'a> {
    /// The values of the named attribute at the triangle's corners, missing components 0.
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

    /// The named attribute interpolated at the hit, missing components 0; `None` where the mesh has no such attribute.
    pub fn attribute(&self, name: &str) -> Option<[f64; 4]> {
        let [a, b, c] = self.at_corners(name)?;
        let [u, v, w] = self.barycentric;
        Some((a * u + b * v + c * w).to_array())
    }

    /// How the first three components of the named attribute change along the surface, per metre in the world: the
    /// gradients lie in the triangle's plane. With them a shader turns the slope of a height that is a function of
    /// the attribute into a bumped normal ([`Hit::bumped`]).
    pub fn gradients(&self, name: &str) -> Option<[DVec3; 3]> {
        let [a, b, c] = self.at_corners(name)?;
        let [p, q, r] = self.corners;
        let (e, f) = (q - p, r - p);
        let n = e.cross(f);
        let square = n.length_squared();
        if square == 0.0 {
            return None;
        }
        // Dual basis of the edges in the plane.
        let (along_e, along_f) = (f.cross(n) / square, n.cross(e) / square);
        let (db, dc) = (b - a, c - a);
        Some([0, 1, 2].map(|i| along_e * db[i] + along_f * dc[i]))
    }

    /// The shading normal turned by a relief whose height (m) rises along the surface by `rise` (m per m).
    pub fn bumped(&self, rise: DVec3) -> DVec3 {
        let across = rise - self.normal * self.normal.dot(rise);
        (self.normal - across).normalize_or(self.normal)
    }

    /// The triangle's material, or `greenstick_geometry::mesh::NO_MATERIAL`.
    pub fn material(&self) -> u32 {
        self.mesh.material(self.triangle)
    }

    pub(crate) fn new(
        item: &Item<'a>,
        triangle: usize,
        barycentric: [f64; 3],
        toward_viewer: DVec3,
    ) -> Hit<'a> {
        let mesh = item.mesh;
        let corners = mesh
            .corners(triangle)
            .map(|p| item.transform.transform_point3(p));
        let [a, b, c] = corners;
        let [u, v, w] = barycentric;
        let flat = (b - a).cross(c - a).normalize_or(toward_viewer);
        let geometric = if flat.dot(toward_viewer) < 0.0 {
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
            let m = item.transform.matrix3;
            // Cofactors instead of the inverse transpose: the same direction, and no division by a zero determinant.
            let cofactors = [
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            ];
            let n = cofactors[0] * n[0] + cofactors[1] * n[1] + cofactors[2] * n[2];
            let n = n.normalize_or(geometric);
            // A mesh's normals say which side is out; seen from inside they point away from the viewer.
            hit.normal = if n.dot(geometric) < 0.0 { -n } else { n };
        }
        hit
    }
}

/// What a surface looks like at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// Linear diffuse colour, each 0 to 1.
    pub color: [f64; 3],
    /// Roughness as in glTF, 0 (mirror) to 1.
    pub roughness: f64,
    /// Unit normal, with the relief that is finer than the mesh.
    pub normal: DVec3,
}

/// Says what a surface looks like.
pub trait Shader {
    /// What the surface looks like where a ray met it.
    fn shade(&self, hit: &Hit) -> Appearance;
}

/// Plain colours: one for all, or the base colours of materials; multiplied by `COLOR_0` where the mesh has it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlainShader {
    /// Linear colour of triangles without a material.
    pub color: [f64; 3],
    /// Roughness of triangles without a material.
    pub roughness: f64,
    /// Linear colour and roughness by material number.
    pub materials: Vec<([f64; 3], f64)>,
}

impl PlainShader {
    /// One linear colour for all.
    pub fn uniform(color: [f64; 3]) -> Self {
        PlainShader {
            color,
            roughness: 0.7,
            materials: Vec::new(),
        }
    }

    /// The base colours and roughnesses of a scene's materials; light grey for triangles without one.
    pub fn of_materials(materials: &[Material]) -> Self {
        let plain = |m: &Material| {
            let [r, g, b, _] = m.base_color.map(f64::from);
            ([r, g, b], f64::from(m.roughness))
        };
        PlainShader {
            materials: materials.iter().map(plain).collect(),
            ..PlainShader::uniform([0.6; 3])
        }
    }
}

impl Shader for PlainShader {
    fn shade(&self, hit: &Hit) -> Appearance {
        let (mut color, roughness) = self
            .materials
            .get(hit.material() as usize)
            .copied()
            .unwrap_or((self.color, self.roughness));
        if let Some(vertex) = hit.attribute("COLOR_0") {
            (0..3).for_each(|c| color[c] *= vertex[c]);
        }
        Appearance {
            color,
            roughness,
            normal: hit.normal,
        }
    }
}
