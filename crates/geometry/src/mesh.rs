//! The triangle mesh that everything else is written for.
//!
//! Vertices carry attributes, so a seam (two normals at one point) has two vertices at one position, as in glTF.
//! Topology is therefore asked of *points* ([`Mesh::points`]): vertices at bitwise equal positions are one point.

use glam::{DAffine3, DVec3};
use std::collections::{BTreeMap, HashMap};

/// A per-vertex attribute: `width` numbers for each vertex, in vertex order.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// Numbers per vertex, 1 to 4 (16 for matrices).
    pub width: usize,
    /// `width` × number of vertices values.
    pub data: Vec<f32>,
}

impl Attribute {
    /// The values of vertex `i`.
    pub fn at(&self, i: usize) -> &[f32] {
        &self.data[i * self.width..(i + 1) * self.width]
    }
}

/// A triangle mesh with per-vertex attributes and per-triangle materials.
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
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|i| self.positions[i as usize])
    }

    /// Material of triangle `t`, or [`NO_MATERIAL`].
    pub fn material(&self, t: usize) -> u32 {
        self.materials.get(t).copied().unwrap_or(NO_MATERIAL)
    }

    /// The triangles `which` with the vertices that they use, both in their order.
    pub fn submesh(&self, which: impl Iterator<Item = usize>) -> Mesh {
        let mut new = vec![u32::MAX; self.positions.len()];
        let mut used = Vec::new();
        let mut part = Mesh::default();
        for t in which {
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

    /// For each vertex the number of its point; vertices at bitwise equal positions (0 and −0 count as equal) share
    /// one. Returns the numbers, counted from 0 in order of first appearance, and how many there are.
    pub fn points(&self) -> (Vec<u32>, usize) {
        let mut seen: HashMap<[u64; 3], u32> = HashMap::with_capacity(self.positions.len());
        let numbers = self
            .positions
            .iter()
            .map(|p| {
                let next = seen.len() as u32;
                *seen
                    .entry((*p + DVec3::ZERO).to_array().map(f64::to_bits))
                    .or_insert(next)
            })
            .collect();
        (numbers, seen.len())
    }

    /// Signed volume by the divergence theorem, positive for a closed mesh oriented outwards. For an open mesh the
    /// value depends on the origin and means nothing.
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

    /// A copy with every position mapped; directions (`NORMAL`, `TANGENT`) turn with it, and triangles are turned over
    /// where the map mirrors.
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
            // The fourth number of a tangent is the hand of the texture's axes.
            if let Some(tangents) = mesh.attributes.get_mut("TANGENT").filter(|t| t.width == 4) {
                let hands = tangents.data.iter_mut().skip(3).step_by(4);
                hands.for_each(|w| *w = -*w);
            }
        }
        mesh
    }
}
