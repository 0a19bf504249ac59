//! Intersections of rays with surfaces, and the appearance of surfaces.

use glam::{DAffine3, DVec3, DVec4};
use greenstick_geometry::Mesh;

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
    /// Direction of the fibres of wood, of any length, which give it a sheen and let light through where it is thin; zero without.
    pub fibre: DVec3,
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
