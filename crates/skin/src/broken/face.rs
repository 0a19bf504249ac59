//! The broken face of a cut, ready to be drawn: positions, normals and texture coordinates.
//!
//! The wood inside has the texture coordinates of [`crate::texture`], in metres: end grain by its place in the section, side
//! grain by its ring coordinate and length.

use super::inner_wood::InnerWood;
use crate::source::Source;
use glam::DVec3;
use greenstick_fracture::cut::{Cut, Host};
use greenstick_fracture::layout::wrap_angle;
use greenstick_fracture::surface::NONE;
use std::ops::Range;

/// Cosine of the angle between a face's normal and the grain above which it shows end grain.
const END_GRAIN: f64 = 0.5;
/// Walls of no more triangles than this have one normal; longer ones follow the bend of the stem.
const MAX_FLAT_WALL: usize = 8;

/// The broken face, oriented for the lower piece; the upper piece has it turned over, its normals reversed.
/// Positions are in the node's coordinates.
#[derive(Debug, Clone, Default)]
pub struct Face {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, m.
    pub coordinates: Vec<[f32; 2]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex of the cut that each vertex lies at.
    pub ids: Vec<u32>,
    /// Cell (fibre bundle) of each vertex.
    pub cells: Vec<u32>,
    /// Exact position of each vertex that the cut made, from its first on.
    pub places: Vec<DVec3>,
}

/// Returns the position of a vertex of a cut on the skin.
fn on_skin(source: &Source, host: Host) -> DVec3 {
    let point = |p: u32| source.mesh.positions[source.vertices[p as usize] as usize];
    match host {
        Host::Point(p) => point(p),
        Host::Edge { ends: [a, b], t } => point(a).lerp(point(b), t),
        Host::Face {
            triangle,
            weights: w,
        } => {
            let [a, b, c] = source.mesh.corners(triangle as usize);
            a * w[0] + b * w[1] + c * w[2]
        }
        Host::Inside => DVec3::NAN,
    }
}

/// The normal of one vertex of one bundle's top, and the mesh vertices made for it on side and on end grain.
#[derive(Clone, Copy)]
struct Slot {
    normal: DVec3,
    made: [u32; 2],
}

/// A vertex of the cut, in one cache line: triangles read their corners in no particular order.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Corner {
    /// Exact position.
    place: DVec3,
    /// Grain coordinates, m.
    grain: DVec3,
    /// Ring coordinate; NaN until it is needed.
    rho: f64,
    /// Angle about the pith, rad.
    phi: f64,
}

/// A face while it is made.
struct FaceBuilder<'a> {
    cut: &'a Cut,
    inner: &'a InnerWood<'a>,
    face: Face,
    /// The vertices of the cut, those of the mesh last and only if the face uses them.
    corners: Vec<Corner>,
    /// The corner of each vertex of the face made so far, and whether it shows end grain.
    made_at: Vec<(u32, bool)>,
    /// For each vertex of the cut the last run of triangles that used it, and its number there.
    runs: Vec<(u32, u32)>,
}

/// Makes the broken face of a cut.
pub fn face(source: &Source, cut: &Cut, inner: &InnerWood) -> Face {
    let corners = corners(source, cut, inner);
    let count = cut.cap.len();
    let tops = cut.walls.first().map_or(count, |&w| w as usize);
    let capacity = if inner.smooth {
        corners.len()
    } else {
        3 * count
    };
    let mut builder = FaceBuilder {
        cut,
        inner,
        runs: Vec::new(),
        face: Face {
            normals: Vec::with_capacity(capacity),
            triangles: Vec::with_capacity(count),
            cells: Vec::with_capacity(capacity),
            places: corners.iter().map(|c| c.place).collect(),
            ..Face::default()
        },
        corners,
        made_at: Vec::with_capacity(capacity),
    };
    let run = builder.tops(tops);
    builder.walls(tops, run);
    builder.place();
    builder.face
}

/// Returns the vertices of a cut: its own on the skin, those within the wood, and the mesh's if its face uses them.
fn corners(source: &Source, cut: &Cut, inner: &InnerWood) -> Vec<Corner> {
    const UNKNOWN: (f64, f64) = (f64::NAN, f64::NAN);
    let corner = |place: DVec3, grain: DVec3, (rho, phi): (f64, f64)| Corner {
        place,
        grain,
        rho,
        phi,
    };
    let mut corners = Vec::with_capacity(cut.vertices.len() + cut.inside.len());
    let on_skin = |host| on_skin(source, host);
    corners.extend((cut.vertices.iter()).map(|v| corner(on_skin(v.host), v.grain, UNKNOWN)));
    corners.extend(cut.inside.iter().zip(&cut.nodes).map(|(&grain, &node)| {
        let address = inner.bundles.addresses.get(node as usize);
        let address = address.map_or(UNKNOWN, |&a| a);
        corner(source.chart.to_world(grain), grain, address)
    }));
    // Vertices of the mesh itself are not expected here, but would follow the others.
    let least = cut.cap.iter().flatten().copied().min().unwrap_or(0) as usize;
    if least < cut.points {
        let points = (0..).zip(&source.grain[..cut.points]);
        corners.extend(points.map(|(p, &g)| corner(on_skin(Host::Point(p)), g, UNKNOWN)));
    }
    corners
}

impl FaceBuilder<'_> {
    fn index(&self, id: u32) -> usize {
        match (id as usize).checked_sub(self.cut.points) {
            Some(i) => i,
            None => self.cut.vertices.len() + self.cut.inside.len() + id as usize,
        }
    }

    /// Makes the first `count` triangles, the tops of cells. Returns the number of the last run.
    fn tops(&mut self, count: usize) -> u32 {
        let known = self.inner.bundles.bundles.len() as u32;
        if self.inner.smooth && self.cut.faces[..count].iter().all(|f| f.cell < known) {
            self.smooth_tops(count);
            return 1;
        }
        self.split_tops(count)
    }

    /// [`FaceBuilder::tops`] where all of them are one run, so that every vertex of the cut has one normal.
    fn smooth_tops(&mut self, count: usize) {
        let none = Slot {
            normal: DVec3::ZERO,
            made: [NONE; 2],
        };
        let mut slots = vec![none; self.corners.len()];
        let mut slot_of: Vec<u32> = Vec::with_capacity(slots.len());
        for t in 0..count {
            let ids = self.cut.cap[t];
            let at = ids.map(|id| self.index(id));
            let (normal, end) = self.normal_and_end_grain(at);
            let cell = self.cut.faces[t].cell;
            let corners = [0, 1, 2].map(|k| {
                let slot = &mut slots[at[k]];
                slot.normal += normal;
                let made = &mut slot.made[usize::from(end)];
                if *made == NONE {
                    slot_of.push(at[k] as u32);
                    *made = self.push(at[k], cell, end);
                }
                *made
            });
            self.face.triangles.push(corners);
        }
        let normal = |&s: &u32| to_f32(slots[s as usize].normal.normalize_or_zero());
        self.face.normals.extend(slot_of.iter().map(normal));
    }

    /// Normal of a top, as long as twice its area, and whether it shows end grain.
    #[inline]
    fn normal_and_end_grain(&self, at: [usize; 3]) -> (DVec3, bool) {
        let [a, b, c] = at.map(|i| &self.corners[i]);
        let across = (b.grain - a.grain).cross(c.grain - a.grain);
        let end = across.z * across.z > END_GRAIN * END_GRAIN * across.length_squared();
        ((b.place - a.place).cross(c.place - a.place), end)
    }

    /// [`FaceBuilder::tops`] where cells split them into runs.
    fn split_tops(&mut self, count: usize) -> u32 {
        self.runs = vec![(0, 0); self.corners.len()];
        // Those of one run.
        let mut slots: Vec<Slot> = Vec::new();
        let mut slot_of: Vec<u32> = Vec::new();
        let normal = |slots: &[Slot], s: u32| to_f32(slots[s as usize].normal.normalize_or_zero());
        let (mut run, mut cell) = (0, NONE);
        for t in 0..count {
            let face = self.cut.faces[t];
            // Walls of cracks have cells beyond the bundles; their edges stay sharp in a smooth face too.
            let known = self.inner.bundles.bundles.len() as u32;
            let smooth = self.inner.smooth && face.cell < known && cell < known;
            if run == 0 || (!smooth && face.cell != cell) {
                run += 1;
                let normals = slot_of.drain(..).map(|s| normal(&slots, s));
                self.face.normals.extend(normals);
                slots.clear();
            }
            cell = face.cell;
            let ids = self.cut.cap[t];
            let at = ids.map(|id| self.index(id));
            let (normal, end) = self.normal_and_end_grain(at);
            let corners = [0, 1, 2].map(|k| {
                let known = self.runs[at[k]];
                let slot = if known.0 == run {
                    known.1
                } else {
                    self.runs[at[k]] = (run, slots.len() as u32);
                    slots.push(Slot {
                        normal: DVec3::ZERO,
                        made: [NONE; 2],
                    });
                    slots.len() as u32 - 1
                };
                let entry = &mut slots[slot as usize];
                entry.normal += normal;
                let made = entry.made[usize::from(end)];
                if made != NONE {
                    return made;
                }
                slot_of.push(slot);
                let made = self.push(at[k], face.cell, end);
                entry.made[usize::from(end)] = made;
                made
            });
            self.face.triangles.push(corners);
        }
        let normals = slot_of.drain(..).map(|s| normal(&slots, s));
        self.face.normals.extend(normals);
        run
    }

    /// Makes the walls, whose triangles start at `first`.
    fn walls(&mut self, first: usize, mut run: u32) {
        let ends = self.cut.walls.iter().skip(1).map(|&w| w as usize);
        let ends = ends.chain([self.cut.cap.len()]);
        let mut from = first;
        for to in ends {
            if to - from <= MAX_FLAT_WALL {
                self.flat_wall(from..to);
            } else {
                run += 1;
                self.long_wall(from..to, run);
            }
            from = to;
        }
    }

    /// Makes a wall of few triangles, which has one normal.
    fn flat_wall(&mut self, triangles: Range<usize>) {
        let first = self.made_at.len();
        let mut normal = DVec3::ZERO;
        // Corners of the triangle before, with their vertices. Which of them comes again is not to be predicted, so
        // nothing branches on it.
        let (mut last, mut made) = ([NONE; 3], [NONE; 3]);
        for t in triangles {
            let at = self.cut.cap[t].map(|id| self.index(id) as u32);
            if normal == DVec3::ZERO {
                normal = self.wall_normal(at);
            }
            let cell = self.cut.faces[t].cell;
            let corners = at.map(|at| {
                let [a, b, c] = [0, 1, 2].map(|k| if last[k] == at { made[k] } else { NONE });
                match a & b & c {
                    NONE => self.flat_wall_vertex(at, cell, first),
                    known => known,
                }
            });
            self.face.triangles.push(corners);
            (last, made) = (at, corners);
        }
        let normals = std::iter::repeat_n(to_f32(normal), self.made_at.len() - first);
        self.face.normals.extend(normals);
    }

    /// The vertex at a corner of a flat wall, whose vertices begin at `first`; it is not one of the last triangle's.
    fn flat_wall_vertex(&mut self, at: u32, cell: u32, first: usize) -> u32 {
        let known = self.made_at[first..].iter().position(|m| m.0 == at);
        known.map_or_else(
            || self.push(at as usize, cell, false),
            |i| (first + i) as u32,
        )
    }

    /// Makes a wall of many triangles, which follows the bend of the stem.
    fn long_wall(&mut self, triangles: Range<usize>, run: u32) {
        self.runs.resize(self.corners.len(), (0, 0));
        for t in triangles {
            let at = self.cut.cap[t].map(|id| self.index(id) as u32);
            let normal = self.wall_normal(at);
            let cell = self.cut.faces[t].cell;
            let corners = at.map(|at| {
                if self.runs[at as usize].0 != run {
                    self.runs[at as usize] = (run, self.made_at.len() as u32);
                    self.face.normals.push(to_f32(normal));
                    self.push(at as usize, cell, false);
                }
                self.runs[at as usize].1
            });
            self.face.triangles.push(corners);
        }
    }

    /// Unit normal of a wall's triangle.
    fn wall_normal(&self, at: [u32; 3]) -> DVec3 {
        let [a, b, c] = at.map(|i| self.corners[i as usize].place);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Makes a vertex at corner number `at`, without its normal, position and texture coordinates.
    #[inline]
    fn push(&mut self, at: usize, cell: u32, end: bool) -> u32 {
        let number = self.made_at.len() as u32;
        self.made_at.push((at as u32, end));
        self.face.cells.push(cell);
        number
    }

    /// Gives all vertices their positions and texture coordinates.
    fn place(&mut self) {
        let (corners, face) = (&mut self.corners, &mut self.face);
        let bundles = &self.inner.bundles.bundles;
        let (square, rings) = (&self.inner.square, &self.inner.stem.rings);
        let position = |&(at, _): &(u32, bool)| to_f32(corners[at as usize].place);
        face.positions = self.made_at.iter().map(position).collect();
        let coordinates = |(&(at, end), &cell): (&(u32, bool), &u32)| {
            let corner = &mut corners[at as usize];
            let across = corner.grain.truncate();
            let coordinates = if end {
                square.end_grain(across)
            } else {
                if corner.rho.is_nan() {
                    (corner.rho, corner.phi) = rings.address(across);
                }
                let bundle = bundles.get(cell as usize);
                let turned = bundle.map_or(0.0, |b| wrap_angle(corner.phi - b.phi));
                square.side_grain(corner.rho, turned, corner.grain.z)
            };
            coordinates.as_vec2().to_array()
        };
        face.coordinates = self
            .made_at
            .iter()
            .zip(&face.cells)
            .map(coordinates)
            .collect();
        let (points, own) = (
            self.cut.points as u32,
            (self.cut.vertices.len() + self.cut.inside.len()) as u32,
        );
        let id = |&(at, _): &(u32, bool)| if at < own { at + points } else { at - own };
        face.ids = self.made_at.iter().map(id).collect();
    }
}

fn to_f32(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
