//! The pieces of a cut as meshes: skin with its attributes carried over, broken faces with their own.

use super::face::Face;
use super::inner_wood::InnerWood;
use crate::source::Source;
use glam::DVec3;
use greenstick_fracture::cut::{Cut, Host, Side, Skin};
use greenstick_fracture::surface::NONE;
use greenstick_geometry::{Attribute, Mesh, mesh::NO_MATERIAL};
use greenstick_wood::tissue::Zone;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use std::collections::BTreeMap;

/// A vertex between those of the source mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchVertex {
    /// Position.
    pub position: DVec3,
    /// Source vertices.
    pub vertices: [u32; 3],
    /// Their weights.
    pub weights: [f32; 3],
}

/// The skin about a break. Vertices are numbered through: those of the source mesh first, then the patch's own.
#[derive(Debug, Clone, Default)]
pub struct Patch {
    /// Number of vertices of the source mesh.
    pub first: u32,
    /// Vertices made along the break.
    pub vertices: Vec<PatchVertex>,
    /// Attributes of `vertices`, those of the source mesh.
    pub attributes: BTreeMap<String, Attribute>,
    /// Triangles that are parts of cut ones, for the lower and the upper piece.
    pub parts: [Vec<[u32; 3]>; 2],
    /// The source triangle of each of `parts`.
    pub sources: [Vec<u32>; 2],
    /// Whole triangles of the source mesh for the lower and the upper piece whose rank ([`Sides`]) lies between those
    /// that are surely below and above.
    ///
    /// [`Sides`]: greenstick_fracture::cut::Sides
    pub whole: [Vec<[u32; 3]>; 2],
}

/// Makes the skin about the break; `skin` is the sorted skin that was cut.
pub fn patch(source: &Source, cut: &Cut, skin: &Skin, places: &[DVec3]) -> Patch {
    let mut patch = Patch {
        first: source.mesh.positions.len() as u32,
        ..Patch::default()
    };
    // The patch's vertices at each of the cut's on the skin: the latest, what each is made of, and the one before it.
    let mut latest = vec![NONE; cut.vertices.len()];
    let mut made: Vec<((u32, u32), u32)> = Vec::with_capacity(cut.vertices.len());
    // The source triangle that last used each of the cut's vertices on the skin, and the patch's vertex that it used.
    let mut used = vec![(NONE, NONE); cut.vertices.len()];
    patch.vertices.reserve(cut.vertices.len());
    for part in &cut.skin {
        let t = part.source;
        let vertices = source.mesh.triangles[t as usize];
        let points = vertices.map(|v| source.points[v as usize]);
        let corners = part.corners.map(|id| {
            let place = (id as usize).wrapping_sub(cut.points);
            // Parts of one triangle follow each other.
            if let Some(&(by, vertex)) = used.get(place)
                && by == t
            {
                return vertex;
            }
            let holds = |point: u32| {
                // The first that does.
                let at = if points[2] == point { 2 } else { 0 };
                let at = if points[1] == point { 1 } else { at };
                vertices[if points[0] == point { 0 } else { at }]
            };
            let (key, vertices, weights) = match cut.host(id) {
                Host::Point(p) => return holds(p),
                Host::Edge { ends, t } => {
                    let [a, b] = ends.map(holds);
                    ((a, b), [a, b, a], [1.0 - t, t, 0.0])
                }
                Host::Face { weights, .. } => ((NONE, t), vertices, weights),
                Host::Inside => ((NONE, t), vertices, [1.0, 0.0, 0.0]),
            };
            if latest.len() <= place {
                latest.resize(place + 1, NONE);
                used.resize(place + 1, (NONE, NONE));
            }
            let mut at = latest[place];
            while let Some(&(_, before)) = made.get(at as usize).filter(|m| m.0 != key) {
                at = before;
            }
            if at == NONE {
                at = made.len() as u32;
                made.push((key, latest[place]));
                latest[place] = at;
                patch.vertices.push(PatchVertex {
                    position: places[place],
                    vertices,
                    weights: weights.map(|w| w as f32),
                });
            }
            used[place] = (t, patch.first + at);
            patch.first + at
        });
        let side = usize::from(part.upper);
        patch.parts[side].push(corners);
        patch.sources[side].push(t);
    }
    patch.whole = whole_triangles(source, cut, skin);
    for (name, attribute) in &source.mesh.attributes {
        let vertices = patch.vertices.iter().map(|v| (v.vertices, v.weights));
        let data = interpolate(name, attribute, vertices);
        let width = attribute.width;
        patch
            .attributes
            .insert(name.clone(), Attribute { width, data });
    }
    patch
}

/// The whole triangles about the break, for the lower and the upper piece.
fn whole_triangles(source: &Source, cut: &Cut, skin: &Skin) -> [Vec<[u32; 3]>; 2] {
    let order = &skin.order[cut.sides.below..cut.sides.above];
    [Side::Lower, Side::Upper].map(|side| {
        // Which triangles are on a side is not to be predicted, so nothing branches on it.
        let mut list = vec![0; order.len()];
        let mut count = 0;
        for (&t, &at) in order.iter().zip(&cut.sides.between) {
            list[count] = t;
            count += usize::from(at == side);
        }
        let whole = list[..count].iter();
        whole.map(|&t| source.mesh.triangles[t as usize]).collect()
    })
}

/// One piece of a cut as a mesh of its own: its share of the skin, and the broken face. Shells that were not cut are not
/// in it.
pub fn piece(
    source: &Source,
    cut: &Cut,
    patch: &Patch,
    face: &Face,
    inner: &InnerWood,
    upper: bool,
) -> Mesh {
    let mut builder = SkinBuilder::new(source, patch);
    let side = if upper { Side::Upper } else { Side::Lower };
    // Split triangles whose parts are all on this side, or all on the other.
    let whole = source.splits.map(|splits| {
        let is_whole = |side| move |t: u32| cut.sides[t as usize] == side;
        let mut together = splits.put_together(source.mesh, is_whole(Side::Lower));
        together.extend(splits.put_together(source.mesh, is_whole(Side::Upper)));
        together
    });
    let whole = whole.unwrap_or_default();
    for t in 0..source.mesh.triangles.len() {
        if cut.sides[t] == side {
            let own = Some(source.mesh.triangles[t]);
            let Some(corners) = whole.get(&(t as u32)).copied().unwrap_or(own) else {
                continue;
            };
            let corners = corners.map(|v| builder.vertex(v));
            builder.triangle(corners, source.mesh.material(t));
        }
    }
    let half = usize::from(upper);
    for (part, &t) in patch.parts[half].iter().zip(&patch.sources[half]) {
        let corners = part.map(|v| builder.vertex(v));
        builder.triangle(corners, source.mesh.material(t as usize));
    }
    let inside = face_addresses(cut, face, inner);
    builder.finish((cut.points, &inside), face, inner, upper)
}

/// Where in the stem a vertex of a broken face lies, as pieces carry it in their attributes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceAddress {
    /// Ring coordinate, at most 1.
    pub ring: f32,
    /// Sector.
    pub sector: f32,
    /// Tissue.
    pub zone: Zone,
    /// Grain coordinates (x, y, s), m.
    pub grain: [f32; 3],
}

/// Returns where the vertices of a broken face lie.
pub(super) fn face_addresses(cut: &Cut, face: &Face, inner: &InnerWood) -> Vec<FaceAddress> {
    let address = |((&id, &cell), &rho): ((&u32, &u32), &f64)| {
        // Vertices of the broken face are the cut's own, never the mesh's.
        let grain = cut.grain(&[], id);
        let bundle = inner.bundles.bundles.get(cell as usize);
        FaceAddress {
            ring: rho.min(1.0) as f32,
            sector: bundle.map_or(0.0, |b| b.sector as f32),
            zone: inner.proportions.zone_at(rho, 0.0),
            grain: grain.as_vec3().to_array(),
        }
    };
    (face.ids.par_iter().zip(&face.cells).zip(&face.rings))
        .map(address)
        .collect()
}

/// An attribute that all pieces have: name, width, values on the broken face, and those on a skin that lacks it.
type Own<'a> = (&'a str, usize, &'a [f32], &'a dyn Fn() -> Vec<f32>);

/// Zone code of the skin.
const BARK: f32 = 4.0;

struct SkinBuilder<'a> {
    source: &'a Source<'a>,
    patch: &'a Patch,
    positions: Vec<DVec3>,
    /// Source vertices and weights of every vertex.
    weights: Vec<([u32; 3], [f32; 3])>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    /// For each vertex of the source mesh and of the patch its number here.
    known: Vec<u32>,
}

impl<'a> SkinBuilder<'a> {
    fn new(source: &'a Source<'a>, patch: &'a Patch) -> Self {
        SkinBuilder {
            source,
            patch,
            positions: Vec::new(),
            weights: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            known: vec![u32::MAX; patch.first as usize + patch.vertices.len()],
        }
    }

    fn triangle(&mut self, corners: [u32; 3], material: u32) {
        self.triangles.push(corners);
        self.materials.push(material);
    }

    fn vertex(&mut self, vertex: u32) -> u32 {
        if self.known[vertex as usize] == u32::MAX {
            self.known[vertex as usize] = self.positions.len() as u32;
            match vertex.checked_sub(self.patch.first) {
                None => {
                    self.positions
                        .push(self.source.mesh.positions[vertex as usize]);
                    self.weights.push(([vertex; 3], [1.0, 0.0, 0.0]));
                }
                Some(i) => {
                    let made = &self.patch.vertices[i as usize];
                    self.positions.push(made.position);
                    self.weights.push((made.vertices, made.weights));
                }
            }
        }
        self.known[vertex as usize]
    }

    /// The piece with its broken face, whose vertices have `inside`; `first` is the number of the first vertex made by the cut.
    fn finish(
        self,
        (first, inside): (usize, &[FaceAddress]),
        face: &Face,
        inner: &InnerWood,
        upper: bool,
    ) -> Mesh {
        let skin = self.positions.len();
        let total = skin + face.ids.len();
        let mut attributes: BTreeMap<String, Attribute> = BTreeMap::new();
        for (name, attribute) in &self.source.mesh.attributes {
            let mut data = interpolate(name, attribute, self.weights.iter().copied());
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
        let sign = if upper { -1.0 } else { 1.0 };
        let normals: Vec<f32> = face.normals.iter().flatten().map(|n| sign * n).collect();
        let coordinates = face.coordinates.as_flattened();
        let skin_normals = || {
            let normals = smooth_normals(&self.positions, &self.triangles);
            normals.into_flattened()
        };
        let column = |value: fn(&FaceAddress) -> f32| inside.iter().map(value).collect::<Vec<_>>();
        let (rings, sectors) = (column(|a| a.ring), column(|a| a.sector));
        let zones = column(|a| f32::from(a.zone.code()));
        let grain: Vec<f32> = inside.iter().flat_map(|a| a.grain).collect();
        let own: [Own; 6] = [
            ("NORMAL", 3, &normals, &skin_normals),
            ("TEXCOORD_0", 2, coordinates, &|| vec![0.0; skin * 2]),
            ("_RING", 1, &rings, &|| vec![1.0; skin]),
            ("_SECTOR", 1, &sectors, &|| vec![0.0; skin]),
            ("_ZONE", 1, &zones, &|| vec![BARK; skin]),
            ("_GRAIN", 3, &grain, &|| self.grain()),
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
        mesh.positions
            .extend(face.ids.iter().map(|&id| face.places[id as usize - first]));
        let shift = skin as u32;
        mesh.triangles.extend(face.triangles.iter().map(|t| {
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
            // Vertices without weight may lie off the limb and have no grain coordinates.
            let sum: DVec3 = (0..3).filter(|&i| i == 0 || w[i] != 0.0).map(at).sum();
            let sum = if sum.is_finite() { sum } else { DVec3::ZERO };
            data.extend(sum.as_vec3().to_array());
        }
        data
    }
}

/// Values of an attribute between vertices.
fn interpolate(
    name: &str,
    attribute: &Attribute,
    vertices: impl ExactSizeIterator<Item = ([u32; 3], [f32; 3])>,
) -> Vec<f32> {
    let width = attribute.width;
    let mut data = Vec::with_capacity(vertices.len() * width);
    for (vertices, weights) in vertices {
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

/// Returns area-weighted unit normals of vertices that came without; vertices at one position share them.
pub fn smooth_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
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
        .map(|&p| sums[p as usize].normalize_or_zero().as_vec3().to_array())
        .collect()
}

/// Whether any triangle of a mesh has no material.
pub fn lacks_material(mesh: &Mesh) -> bool {
    mesh.materials.is_empty() || mesh.materials.contains(&NO_MATERIAL)
}
