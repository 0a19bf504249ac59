//! The mesh of one piece: positions, normals, tangents, texture coordinates, materials and the wood's address.

use super::bark::{Bark, BarkSample};
use super::materials::Materials;
use super::open_faces::{FaceKind, OpenFaces, Triangle, Vertex};
use super::weight_history::WeightHistory;
use super::wood::Wood;
use glam::{DVec2, DVec3};
use greenstick_fracture::layout::wrap_angle;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Binding, EarlierBindings, Mesh, SkinnedMesh};
use rustc_hash::FxHashMap;

/// Cosine of the angle between a face's normal and the grain above which it shows end grain.
const END_GRAIN: f64 = 0.5;

/// Identifies a vertex of a mesh: a vertex of the skin on faces that are smooth together and show the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct VertexKey {
    vertex: u32,
    smoothing_group: u32,
    end_grain: bool,
    /// Bits of the texture coordinates of bark.
    coordinates: [u64; 2],
}

/// All faces of the outside are smooth together, and so are those of the bundle's ends; broken ends are by their flanks.
const BARK_GROUP: u32 = u32::MAX;
const END_GROUP: u32 = u32::MAX - 1;

/// A mesh while triangles are added to it.
struct MeshBuilder<'a> {
    wood: &'a Wood<'a>,
    faces: &'a OpenFaces,
    earlier_weights: &'a WeightHistory,
    materials: &'a Materials<'a>,
    bark: Option<Bark<'a>>,
    vertex_of: FxHashMap<VertexKey, u32>,
    mesh: Mesh,
    binding: Binding,
    earlier: EarlierBindings,
    /// Sum of the normals of each vertex's faces, by area.
    normals: Vec<DVec3>,
    coordinates: Vec<f32>,
    rings: Vec<f32>,
    zones: Vec<f32>,
    grain: Vec<f32>,
    colors: Vec<f32>,
}

/// Makes the mesh of the piece that `triangles` bound.
pub(super) fn piece_mesh(
    wood: &Wood,
    faces: &OpenFaces,
    earlier_weights: &WeightHistory,
    triangles: &[u32],
    materials: &Materials,
) -> SkinnedMesh {
    let mut builder = MeshBuilder {
        wood,
        faces,
        earlier_weights,
        materials,
        bark: Bark::from_wood(wood),
        vertex_of: FxHashMap::default(),
        mesh: Mesh::default(),
        binding: Binding::default(),
        earlier: EarlierBindings::default(),
        normals: Vec::new(),
        coordinates: Vec::new(),
        rings: Vec::new(),
        zones: Vec::new(),
        grain: Vec::new(),
        colors: Vec::new(),
    };
    for &t in triangles {
        builder.add_triangle(&faces.triangles[t as usize]);
    }
    builder.finish()
}

impl MeshBuilder<'_> {
    fn add_triangle(&mut self, triangle: &Triangle) {
        let corners = triangle.corners.map(|v| &self.faces.vertices[v as usize]);
        let [a, b, c] = corners.map(|v| v.rest);
        let normal = (b - a).cross(c - a);
        let is_bark = triangle.kind == FaceKind::Bark;
        let smoothing_group = match triangle.kind {
            FaceKind::Bark => BARK_GROUP,
            FaceKind::End => END_GROUP,
            FaceKind::Side(number) => 2 * number,
            FaceKind::BrokenEnd(number) => 2 * number + 1,
        };
        let bark = self.bark.as_ref().filter(|_| is_bark);
        let sampled = bark.and_then(|bark| bark.sample_face([a, b, c]));
        let grain = corners.map(|v| v.grain);
        let (coordinates, end_grain) =
            texture_coordinates(self.wood, self.materials, grain, is_bark);
        let numbers = [0, 1, 2].map(|k| {
            let sample = sampled.map(|(_, samples)| samples[k]);
            let uv = sample.map_or(coordinates[k], |s| s.coordinates);
            let key = VertexKey {
                vertex: triangle.corners[k],
                smoothing_group,
                end_grain,
                coordinates: if is_bark {
                    uv.to_array().map(f64::to_bits)
                } else {
                    [0; 2]
                },
            };
            let number = match self.vertex_of.get(&key) {
                Some(&number) => number,
                None => {
                    let number = self.add_vertex(key.vertex, corners[k], uv, sample);
                    self.vertex_of.insert(key, number);
                    number
                }
            };
            self.normals[number as usize] += normal;
            number
        });
        self.mesh.triangles.push(numbers);
        self.mesh.materials.push(match sampled {
            Some((material, _)) if material != NO_MATERIAL => {
                self.materials.bark_mesh_offset + material
            }
            _ if is_bark => self.materials.bark,
            _ => self.materials.inner,
        });
    }

    /// Adds vertex number `skin_vertex` of the skin to the mesh.
    fn add_vertex(
        &mut self,
        skin_vertex: u32,
        vertex: &Vertex,
        uv: DVec2,
        sample: Option<BarkSample>,
    ) -> u32 {
        let number = self.mesh.positions.len() as u32;
        let (rho, _) = self.wood.stem.rings.address(vertex.grain.truncate());
        self.mesh.positions.push(vertex.rest);
        self.binding.push(vertex.weights.iter().copied());
        let versions = self.earlier_weights.of_vertex.get(skin_vertex as usize);
        for version in versions.into_iter().flatten() {
            let rest = if version.is_closed {
                vertex.closed_rest
            } else {
                vertex.rest
            };
            let weights = version.weights.iter().copied();
            self.earlier.push(number, version.until, rest, weights);
        }
        self.normals.push(DVec3::ZERO);
        self.coordinates.extend(uv.as_vec2().to_array());
        self.rings.push(rho as f32);
        self.zones.push(f32::from((self.materials.zone)(rho)));
        self.grain.extend(vertex.grain.as_vec3().to_array());
        let color = sample.and_then(|s| s.color);
        self.colors.extend(color.unwrap_or([1.0; 4]));
        number
    }

    /// Completes the mesh with its attributes.
    fn finish(mut self) -> SkinnedMesh {
        let normals = self.normals.iter();
        let normals: Vec<DVec3> = normals.map(|n| n.normalize_or(DVec3::Z)).collect();
        let tangents = tangents(&self.mesh, &normals, &self.coordinates);
        let normals = (normals.iter())
            .flat_map(|n| n.as_vec3().to_array())
            .collect();
        let mut attributes = vec![
            ("NORMAL", 3, normals),
            ("TANGENT", 4, tangents),
            ("TEXCOORD_0", 2, self.coordinates),
            ("_RING", 1, self.rings),
            ("_ZONE", 1, self.zones),
            ("_GRAIN", 3, self.grain),
        ];
        if self.bark.is_some_and(|bark| bark.has_colors()) {
            attributes.push(("COLOR_0", 4, self.colors));
        }
        for (name, width, data) in attributes {
            let attribute = Attribute { width, data };
            self.mesh.attributes.insert(name.into(), attribute);
        }
        SkinnedMesh {
            mesh: self.mesh,
            binding: self.binding,
            earlier: self.earlier,
            ..SkinnedMesh::default()
        }
    }
}

/// Returns the texture coordinates of a face's corners, and whether the face shows end grain.
fn texture_coordinates(
    wood: &Wood,
    materials: &Materials,
    grain: [DVec3; 3],
    is_bark: bool,
) -> ([DVec2; 3], bool) {
    // All corners of a face read the texture on one side of the seam behind the pith.
    let middle = (grain[0] + grain[1] + grain[2]) / 3.0;
    if is_bark {
        return (grain.map(|g| bark_coordinates(wood, g, middle)), false);
    }
    let normal = (grain[1] - grain[0]).cross(grain[2] - grain[0]);
    let end_grain = normal.z * normal.z > END_GRAIN * END_GRAIN * normal.length_squared();
    let (square, rings) = (materials.square, &wood.stem.rings);
    let about = rings.address(middle.truncate()).1;
    let coordinates = grain.map(|g| {
        if end_grain {
            square.end_grain(g.truncate())
        } else {
            let (rho, angle) = rings.address(g.truncate());
            square.side_grain(rho, wrap_angle(angle - about), g.z)
        }
    });
    (coordinates, end_grain)
}

/// Returns the tangents of all vertices by the convention of glTF 2.0 (§3.7.2.1): along the first texture coordinate, with
/// the sign of the direction of the second.
fn tangents(mesh: &Mesh, normals: &[DVec3], coordinates: &[f32]) -> Vec<f32> {
    let mut sums = vec![[DVec3::ZERO; 2]; normals.len()];
    let at = |v: u32| {
        let k = 2 * v as usize;
        DVec2::new(coordinates[k].into(), coordinates[k + 1].into())
    };
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let [p, q, r] = mesh.corners(t);
        let (e, f) = (q - p, r - p);
        let (u, v) = (at(b) - at(a), at(c) - at(a));
        let sign = u.perp_dot(v).signum();
        for corner in [a, b, c] {
            let sum = &mut sums[corner as usize];
            sum[0] += (e * v.y - f * u.y) * sign;
            sum[1] += (f * u.x - e * v.x) * sign;
        }
    }
    (sums.iter().zip(normals))
        .flat_map(|(&[along, other], &n)| {
            let t = along.reject_from_normalized(n);
            let t = t
                .try_normalize()
                .unwrap_or_else(|| n.any_orthonormal_vector());
            let sign = if n.cross(t).dot(other) < 0.0 {
                -1.0
            } else {
                1.0
            };
            let [x, y, z] = t.as_vec3().to_array();
            [x, y, z, sign]
        })
        .collect()
}

/// Returns the texture coordinates of bark: turns about the pith, and the length along the axis in circumferences.
fn bark_coordinates(wood: &Wood, grain: DVec3, middle: DVec3) -> DVec2 {
    let pith = wood.stem.rings.pith();
    let angle = |p: DVec3| libm::atan2(p.y - pith.y, p.x - pith.x);
    let turn = std::f64::consts::TAU;
    let (own, face) = (angle(grain), angle(middle));
    let near = face + (own - face + 1.5 * turn).rem_euclid(turn) - 0.5 * turn;
    DVec2::new(near / turn, grain.z / (turn * wood.stem.radius))
}
