//! The pieces of a cut as meshes: skin with its attributes carried over, broken faces with their own.
//!
//! The wood inside has texture coordinates in metres. End grain reads (x, y) of the section, shifted so that the
//! section's middle is the middle of a square of side W; side grain reads W + distance from the pith across and the
//! length along the grain. A texture of two squares side by side, end grain on the left and side grain on the right,
//! therefore serves both, with the scale (1/2W, 1/W).

use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::cut::{Cut, Host, Side};
use greenstick_fracture::layout::{Bundles, wrap};
use greenstick_geometry::{Attribute, Mesh, mesh::NO_MATERIAL};
use greenstick_wood::stem::Stem;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// The mesh that was cut.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The mesh, in its node's coordinates.
    pub mesh: &'a Mesh,
    /// The node's coordinates to the world.
    pub transform: &'a DAffine3,
    /// Point number of each vertex.
    pub points: &'a [u32],
    /// Grain coordinates of each point, NaN off the limb.
    pub grain: &'a [DVec3],
}

/// What the broken face shows.
#[derive(Clone, Copy)]
pub struct InnerWood<'a> {
    /// The stem that was cut.
    pub stem: &'a Stem,
    /// Its fibre bundles.
    pub bundles: &'a Bundles,
    /// Code of the tissue zone at a ring coordinate.
    pub zone: &'a dyn Fn(f64) -> u8,
    /// Material of the broken face.
    pub material: u32,
    /// Middle of the section (grain x, y) and side W of the square that the texture covers, m.
    pub square: (DVec2, f64),
    /// Whether the surface is smooth across cells.
    pub smooth: bool,
}

/// The broken face with its attributes, oriented for the lower piece. Positions are in the node's coordinates.
#[derive(Debug, Clone, Default)]
pub struct CapMesh {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    normals: Vec<f32>,
    coordinates: Vec<f32>,
    rings: Vec<f32>,
    sectors: Vec<f32>,
    zones: Vec<f32>,
    grain: Vec<f32>,
}

/// Cosine of the angle between a face's normal and the grain above which it shows end grain.
const END_GRAIN: f64 = 0.5;
/// How fast side grain drifts across the texture along a ring, so that tangential faces are not one flat colour.
const DRIFT: f64 = 0.12;

/// Where each vertex of a cut lies, in the node's coordinates.
pub fn positions(source: &Source, cut: &Cut, stem: &Stem) -> Vec<DVec3> {
    let mut at_point = vec![DVec3::NAN; cut.points];
    for (vertex, &point) in source.points.iter().enumerate() {
        at_point[point as usize] = source.mesh.positions[vertex];
    }
    let back = source.transform.inverse();
    let corner =
        |t: u32, k: usize| source.mesh.positions[source.mesh.triangles[t as usize][k] as usize];
    let made: Vec<DVec3> = cut
        .vertices
        .iter()
        .map(|v| match v.host {
            Host::Point(p) => at_point[p as usize],
            Host::Edge { ends: [a, b], t } => at_point[a as usize].lerp(at_point[b as usize], t),
            Host::Face {
                triangle,
                weights: w,
            } => {
                corner(triangle, 0) * w[0] + corner(triangle, 1) * w[1] + corner(triangle, 2) * w[2]
            }
            Host::Inside => back.transform_point3(stem.grain.to_world(v.grain)),
        })
        .collect();
    at_point.extend(made);
    at_point
}

/// The broken face of a cut; `positions` as from [`positions`].
pub fn cap(source: &Source, cut: &Cut, positions: &[DVec3], inner: &InnerWood) -> CapMesh {
    let mut cap = CapMesh::default();
    let grain_of = |id: u32| cut.grain(source.grain, id);
    let smooth_normals = smooth_normals(cut, positions, inner);
    let layout = &inner.bundles.layout;
    // One mesh vertex for every use of a cut's vertex that differs in normal or texture.
    let mut known: FxHashMap<(u32, u64), u32> = FxHashMap::default();
    known.reserve(cut.vertices.len() * 2);
    debug_assert_eq!(layout.cells.len(), layout.facets.len());
    for (triangle, face) in cut.cap.iter().zip(&cut.faces) {
        let [a, b, c] = triangle.map(|id| positions[id as usize]);
        let flat = (b - a).cross(c - a).normalize_or_zero();
        let [ga, gb, gc] = triangle.map(grain_of);
        let grain_normal = (gb - ga).cross(gc - ga).normalize_or_zero();
        let end = face.top && grain_normal.z.abs() > END_GRAIN;
        let bundle = inner.bundles.bundles.get(face.cell as usize);
        // Walls of cracks have cells beyond the bundles; their edges stay sharp in a smooth face too.
        let smooth = inner.smooth && bundle.is_some();
        let group = match (face.top, smooth) {
            (true, true) => 0,
            (true, false) => u64::from(face.cell) + 1,
            // Walls of one bundle are told apart by their direction in sixteen parts.
            (false, _) => {
                let turn =
                    libm::atan2(grain_normal.y, grain_normal.x) / std::f64::consts::TAU + 0.5;
                1 << 40 | u64::from(face.cell) << 6 | (turn * 16.0) as u64
            }
        };
        let key_part = group << 1 | u64::from(end);
        let corners = triangle.map(|id| {
            *known.entry((id, key_part)).or_insert_with(|| {
                let normal = if face.top {
                    smooth_normals.get(&(id, group)).copied().unwrap_or(flat)
                } else {
                    flat
                };
                cap.push(
                    positions[id as usize],
                    grain_of(id),
                    normal,
                    end,
                    bundle.map(|b| (b.phi, b.sector)),
                    inner,
                )
            })
        });
        cap.triangles.push(corners);
    }
    cap
}

/// Mean normals of the tops at each vertex of each group.
fn smooth_normals(
    cut: &Cut,
    positions: &[DVec3],
    inner: &InnerWood,
) -> FxHashMap<(u32, u64), DVec3> {
    let mut sums: FxHashMap<(u32, u64), DVec3> = FxHashMap::default();
    for (triangle, face) in cut.cap.iter().zip(&cut.faces).filter(|(_, f)| f.top) {
        let [a, b, c] = triangle.map(|id| positions[id as usize]);
        let normal = (b - a).cross(c - a);
        let bundle = (face.cell as usize) < inner.bundles.bundles.len();
        let group = if inner.smooth && bundle {
            0
        } else {
            u64::from(face.cell) + 1
        };
        for &id in triangle {
            *sums.entry((id, group)).or_default() += normal;
        }
    }
    sums.values_mut().for_each(|n| *n = n.normalize_or_zero());
    sums
}

impl CapMesh {
    fn push(
        &mut self,
        position: DVec3,
        grain: DVec3,
        normal: DVec3,
        end: bool,
        bundle: Option<(f64, u32)>,
        inner: &InnerWood,
    ) -> u32 {
        let across = grain.truncate();
        let (rho, phi) = inner.stem.rings.address(across);
        let (middle, sector) = bundle.unwrap_or((phi, 0));
        let (corner, width) = (inner.square.0 - inner.square.1 / 2.0, inner.square.1);
        let coordinates = if end {
            across - corner
        } else {
            let r = across.distance(inner.stem.rings.pith());
            let phi = middle + wrap(phi - middle);
            DVec2::new(width + r * (1.0 + DRIFT * phi), grain.z)
        };
        self.positions.push(position);
        self.normals.extend(normal.as_vec3().to_array());
        self.coordinates.extend(coordinates.as_vec2().to_array());
        self.rings.push(rho.min(1.0) as f32);
        self.sectors.push(sector as f32);
        self.zones.push(f32::from((inner.zone)(rho)));
        self.grain.extend(grain.as_vec3().to_array());
        self.positions.len() as u32 - 1
    }
}

/// One piece of a cut: its share of the skin, and the broken face. Shells that were not cut are not in it.
pub fn piece(
    source: &Source,
    cut: &Cut,
    positions: &[DVec3],
    cap: &CapMesh,
    inner: &InnerWood,
    upper: bool,
) -> Mesh {
    let mut builder = SkinBuilder::new(source, cut, positions);
    let side = if upper { Side::Upper } else { Side::Lower };
    for (t, &s) in cut.sides.iter().enumerate() {
        if s == side {
            let corners = source.mesh.triangles[t].map(|v| builder.whole(v));
            builder.triangle(corners, source.mesh.material(t));
        }
    }
    for part in cut.skin.iter().filter(|p| p.upper == upper) {
        let corners = part.corners.map(|id| builder.cut_vertex(part.source, id));
        builder.triangle(corners, source.mesh.material(part.source as usize));
    }
    builder.finish(cap, inner, upper)
}

/// Zone code of the skin.
const BARK: f32 = 4.0;

struct SkinBuilder<'a> {
    source: &'a Source<'a>,
    cut: &'a Cut,
    at: &'a [DVec3],
    positions: Vec<DVec3>,
    /// Source vertices and weights of every vertex.
    weights: Vec<([u32; 3], [f32; 3])>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    whole: Vec<u32>,
    parts: FxHashMap<(u32, u32, u32), u32>,
}

impl<'a> SkinBuilder<'a> {
    fn new(source: &'a Source<'a>, cut: &'a Cut, at: &'a [DVec3]) -> Self {
        SkinBuilder {
            source,
            cut,
            at,
            positions: Vec::new(),
            weights: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            whole: vec![u32::MAX; source.mesh.positions.len()],
            parts: FxHashMap::default(),
        }
    }

    fn triangle(&mut self, corners: [u32; 3], material: u32) {
        self.triangles.push(corners);
        self.materials.push(material);
    }

    fn push(&mut self, position: DVec3, vertices: [u32; 3], weights: [f64; 3]) -> u32 {
        self.positions.push(position);
        self.weights.push((vertices, weights.map(|w| w as f32)));
        self.positions.len() as u32 - 1
    }

    fn whole(&mut self, vertex: u32) -> u32 {
        if self.whole[vertex as usize] == u32::MAX {
            let p = self.source.mesh.positions[vertex as usize];
            self.whole[vertex as usize] = self.push(p, [vertex; 3], [1.0, 0.0, 0.0]);
        }
        self.whole[vertex as usize]
    }

    /// Vertex `id` of the cut as a corner of a part of triangle `t`.
    fn cut_vertex(&mut self, t: u32, id: u32) -> u32 {
        let vertices = self.source.mesh.triangles[t as usize];
        let holds = |point: u32| {
            vertices
                .iter()
                .copied()
                .find(|&v| self.source.points[v as usize] == point)
                .unwrap_or(vertices[0])
        };
        let position = self.at[id as usize];
        match self.cut.host(id) {
            Host::Point(p) => self.whole(holds(p)),
            Host::Edge { ends, t } => {
                let [a, b] = ends.map(holds);
                if let Some(&known) = self.parts.get(&(id, a, b)) {
                    return known;
                }
                let made = self.push(position, [a, b, a], [1.0 - t, t, 0.0]);
                self.parts.insert((id, a, b), made);
                made
            }
            Host::Face { weights, .. } => {
                if let Some(&known) = self.parts.get(&(id, u32::MAX, t)) {
                    return known;
                }
                let made = self.push(position, vertices, weights);
                self.parts.insert((id, u32::MAX, t), made);
                made
            }
            Host::Inside => self.push(position, vertices, [1.0, 0.0, 0.0]),
        }
    }

    fn finish(self, cap: &CapMesh, inner: &InnerWood, upper: bool) -> Mesh {
        let skin = self.positions.len();
        let total = skin + cap.positions.len();
        let mut attributes: BTreeMap<String, Attribute> = BTreeMap::new();
        for (name, attribute) in &self.source.mesh.attributes {
            let mut data = self.interpolate(name, attribute);
            // What the wood inside has no value for: white for colours, nothing for the rest.
            let fill = if name.starts_with("COLOR_") { 1.0 } else { 0.0 };
            data.resize(total * attribute.width, fill);
            attributes.insert(
                name.clone(),
                Attribute {
                    width: attribute.width,
                    data,
                },
            );
        }
        let normals: Vec<f32> = if upper {
            cap.normals.iter().map(|n| -n).collect()
        } else {
            cap.normals.clone()
        };
        let skin_normals = || skin_normals(&self.positions, &self.triangles);
        let own: [(&str, usize, &[f32], &dyn Fn() -> Vec<f32>); 6] = [
            ("NORMAL", 3, &normals, &skin_normals),
            ("TEXCOORD_0", 2, &cap.coordinates, &|| vec![0.0; skin * 2]),
            ("_RING", 1, &cap.rings, &|| vec![1.0; skin]),
            ("_SECTOR", 1, &cap.sectors, &|| vec![0.0; skin]),
            ("_ZONE", 1, &cap.zones, &|| vec![BARK; skin]),
            ("_GRAIN", 3, &cap.grain, &|| self.grain()),
        ];
        for (name, width, values, missing) in own {
            let entry = attributes.entry(name.to_owned()).or_insert_with(|| {
                let mut data = missing();
                data.resize(total * width, 0.0);
                Attribute { width, data }
            });
            if entry.width == width {
                entry.data[skin * width..].copy_from_slice(values);
            }
        }
        let mut mesh = Mesh {
            positions: self.positions,
            triangles: self.triangles,
            attributes,
            materials: self.materials,
        };
        mesh.positions.extend(&cap.positions);
        let shift = skin as u32;
        mesh.triangles.extend(cap.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| v + shift);
            if upper { [a, c, b] } else { [a, b, c] }
        }));
        mesh.materials.resize(mesh.triangles.len(), inner.material);
        mesh
    }

    /// Grain coordinates of the skin's vertices, zero off the limb.
    fn grain(&self) -> Vec<f32> {
        let mut data = Vec::with_capacity(self.positions.len() * 3);
        for (vertices, w) in &self.weights {
            let at = |i: usize| {
                self.source.grain[self.source.points[vertices[i] as usize] as usize]
                    * f64::from(w[i])
            };
            let mut sum = at(0);
            for i in 1..3 {
                if w[i] != 0.0 {
                    sum += at(i);
                }
            }
            let sum = if sum.is_finite() { sum } else { DVec3::ZERO };
            data.extend(sum.as_vec3().to_array());
        }
        data
    }

    fn interpolate(&self, name: &str, attribute: &Attribute) -> Vec<f32> {
        let width = attribute.width;
        let mut data = Vec::with_capacity(self.weights.len() * width);
        for (vertices, weights) in &self.weights {
            if weights[0] == 1.0 {
                data.extend_from_slice(attribute.at(vertices[0] as usize));
                continue;
            }
            let first = data.len();
            data.extend((0..width).map(|c| {
                (0..3)
                    .map(|i| attribute.at(vertices[i] as usize)[c] * weights[i])
                    .sum::<f32>()
            }));
            if name == "NORMAL" || name == "TANGENT" {
                let v = &mut data[first..first + 3.min(width)];
                let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
                if length > 0.0 {
                    v.iter_mut().for_each(|x| *x /= length);
                }
                if width == 4 {
                    data[first + 3] = attribute.at(vertices[0] as usize)[3];
                }
            }
        }
        data
    }
}

/// Area-weighted vertex normals of a skin that came without; vertices at one position share them.
fn skin_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mesh = Mesh {
        positions: positions.to_vec(),
        ..Mesh::default()
    };
    let (points, count) = mesh.points();
    let mut sums = vec![DVec3::ZERO; count];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let n = (b - a).cross(c - a);
        t.iter()
            .for_each(|&v| sums[points[v as usize] as usize] += n);
    }
    points
        .iter()
        .flat_map(|&p| sums[p as usize].normalize_or_zero().as_vec3().to_array())
        .collect()
}

/// Whether any triangle of a mesh has no material.
pub fn lacks_material(mesh: &Mesh) -> bool {
    mesh.materials.is_empty() || mesh.materials.contains(&NO_MATERIAL)
}
