//! Triangle meshes.
//!
//! Vertices carry attributes, so a seam (two normals at one point) has two vertices at one position, as in glTF.
//! Topology is therefore defined on *points* ([`Mesh::points`]): vertices at bitwise equal positions are one point.

use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;

/// A per-vertex attribute: `width` numbers for each vertex, in the order of vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// Numbers per vertex, 1 to 4 (16 for matrices).
    pub width: usize,
    /// Values, `width` for each vertex.
    pub data: Vec<f32>,
}

impl Attribute {
    /// The values of vertex `i`.
    pub fn at(&self, i: usize) -> &[f32] {
        &self.data[i * self.width..(i + 1) * self.width]
    }
}

/// A triangle mesh with per-vertex attributes and per-triangle materials.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use greenstick_geometry::Mesh;
///
/// let triangle = Mesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
///     triangles: vec![[0, 1, 2]],
///     ..Mesh::default()
/// };
/// let doubled = triangle.transformed(&DAffine3::from_scale(DVec3::splat(2.0)));
/// assert_eq!((triangle.area(), doubled.area()), (0.5, 2.0));
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Attributes under their glTF names: `NORMAL`, `TANGENT`, `TEXCOORD_0`, `COLOR_0`, `_RING` …
    pub attributes: BTreeMap<String, Attribute>,
    /// Material of each triangle, an index into [`crate::Scene::materials`]; empty where there is none at all,
    /// `u32::MAX` for a triangle without one.
    pub materials: Vec<u32>,
}

/// "No material" in [`Mesh::materials`].
pub const NO_MATERIAL: u32 = u32::MAX;

impl Mesh {
    /// Corner positions of triangle `t`.
    #[inline]
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|i| self.positions[i as usize])
    }

    /// Material of triangle `t`, or [`NO_MATERIAL`].
    #[inline]
    pub fn material(&self, t: usize) -> u32 {
        self.materials.get(t).copied().unwrap_or(NO_MATERIAL)
    }

    /// Returns the given triangles with the vertices that they use, both in their order.
    pub fn submesh(&self, triangles: impl Iterator<Item = usize>) -> Mesh {
        let mut new = vec![u32::MAX; self.positions.len()];
        let mut used = Vec::new();
        let mut part = Mesh::default();
        for t in triangles {
            let corners = self.triangles[t].map(|v| {
                if new[v as usize] == u32::MAX {
                    new[v as usize] = used.len() as u32;
                    used.push(v as usize);
                }
                new[v as usize]
            });
            part.triangles.push(corners);
            if !self.materials.is_empty() {
                part.materials.push(self.materials[t]);
            }
        }
        part.positions = used.iter().map(|&v| self.positions[v]).collect();
        for (name, attribute) in &self.attributes {
            let values = used.iter().flat_map(|&v| attribute.at(v));
            let attribute = Attribute {
                width: attribute.width,
                data: values.copied().collect(),
            };
            part.attributes.insert(name.clone(), attribute);
        }
        part
    }

    /// Adds a vertex at `position` with the attributes that lie the fraction `t` of the way from vertex `v` to vertex `w`. Returns its
    /// index.
    pub fn push_vertex_between(&mut self, (v, w): (u32, u32), t: f64, position: DVec3) -> u32 {
        for (name, Attribute { width, data }) in &mut self.attributes {
            let (v, w) = (v as usize * *width, w as usize * *width);
            let first = data.len();
            for k in 0..*width {
                let (a, b) = (f64::from(data[v + k]), f64::from(data[w + k]));
                data.push((a + (b - a) * t) as f32);
            }
            if matches!(name.as_str(), "NORMAL" | "TANGENT") && *width >= 3 {
                let added = &mut data[first..];
                let n = DVec3::new(added[0].into(), added[1].into(), added[2].into());
                let unit = n.normalize_or_zero().as_vec3().to_array();
                added[..3].copy_from_slice(&unit);
                if let Some(handedness) = added.get_mut(3) {
                    *handedness = handedness.signum();
                }
            }
        }
        self.positions.push(position);
        self.positions.len() as u32 - 1
    }

    /// Numbers the points of the mesh. Vertices at bitwise equal positions (0 and −0 count as equal) share a point.
    /// Returns the point of each vertex, counted from 0 in order of first appearance, and the number of points.
    pub fn points(&self) -> (Vec<u32>, usize) {
        crate::components::number_points(&self.positions)
    }

    /// Signed volume by the divergence theorem, positive for a closed mesh oriented outwards. For an open mesh the
    /// value depends on the origin and is meaningless.
    pub fn volume(&self) -> f64 {
        let Some(&origin) = self.positions.first() else {
            return 0.0;
        };
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - origin);
                a.dot(b.cross(c))
            })
            .sum::<f64>()
            / 6.0
    }

    /// Sum of the triangles' areas.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                (b - a).cross(c - a).length()
            })
            .sum::<f64>()
            / 2.0
    }

    /// Smallest and largest coordinates; `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(low, high), &p| (low.min(p), high.max(p))),
        )
    }

    /// Returns a copy with every position mapped. Directions (`NORMAL`, `TANGENT`) are mapped accordingly, and triangles are
    /// reversed if the map is a reflection.
    pub fn transformed(&self, map: &DAffine3) -> Mesh {
        let mut mesh = self.clone();
        for p in &mut mesh.positions {
            *p = map.transform_point3(*p);
        }
        let normal_map = map.matrix3.inverse().transpose();
        for (name, matrix) in [("NORMAL", normal_map), ("TANGENT", map.matrix3)] {
            if let Some(attribute) = mesh.attributes.get_mut(name) {
                for v in attribute.data.chunks_exact_mut(attribute.width) {
                    let n = matrix * DVec3::new(v[0].into(), v[1].into(), v[2].into());
                    v[..3].copy_from_slice(&n.normalize_or_zero().as_vec3().to_array());
                }
            }
        }
        if map.matrix3.determinant() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            // The fourth component of a tangent is the handedness of the tangent basis.
            if let Some(tangents) = mesh.attributes.get_mut("TANGENT").filter(|t| t.width == 4) {
                let signs = tangents.data.iter_mut().skip(3).step_by(4);
                signs.for_each(|w| *w = -*w);
            }
        }
        mesh
    }
}
