//! The broken face of a cut, ready to be drawn: positions, normals and texture coordinates.
//!
//! The wood inside has texture coordinates in metres. End grain reads (x, y) of the section, shifted so that the
//! section's middle is the middle of a square of side W; side grain reads W + distance from the pith across and the
//! length along the grain. A texture of two squares side by side, end grain on the left and side grain on the right,
//! therefore serves both, with the scale (1/2W, 1/W).

use crate::pieces::{InnerWood, Source};
use glam::{DVec2, DVec3};
use greenstick_fracture::cut::{Cut, Host};
use greenstick_fracture::layout::wrap;
use greenstick_fracture::surface::NONE;

/// Cosine of the angle between a face's normal and the grain above which it shows end grain.
const END_GRAIN: f64 = 0.5;
/// How fast side grain drifts across the texture along a ring, so that tangential faces are not one flat colour.
const DRIFT: f64 = 0.12;
/// Walls of no more triangles than this have one normal; longer ones follow the bend of the stem.
const FLAT: usize = 8;

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

/// Where vertex `id` of a cut on the skin lies.
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

/// Normals of one vertex of one bundle's top, and the mesh vertices made for it on side and on end grain.
#[derive(Clone, Copy)]
struct Slot {
    normal: DVec3,
    made: [u32; 2],
}

struct Maker<'a> {
    cut: &'a Cut,
    source: &'a Source<'a>,
    inner: &'a InnerWood<'a>,
    face: Face,
    /// Low corner of the texture's square.
    corner: DVec2,
    pith: DVec2,
    /// For each vertex of the cut the last run of triangles that used it, and its number there.
    runs: Vec<(u32, u32)>,
}

/// Makes the broken face of a cut.
pub fn face(source: &Source, cut: &Cut, inner: &InnerWood) -> Face {
    let mut places = Vec::with_capacity(cut.vertices.len() + cut.inside.len());
    places.extend(cut.vertices.iter().map(|v| on_skin(source, v.host)));
    places.extend(cut.inside.iter().map(|&g| source.chart.to_world(g)));
    // Vertices of the mesh itself are not expected here, but have their place behind the others.
    let least = cut.cap.iter().flatten().copied().min().unwrap_or(0) as usize;
    if least < cut.points {
        places.extend((0..cut.points as u32).map(|p| on_skin(source, Host::Point(p))));
    }
    let corners = cut.cap.len();
    let tops = cut.walls.first().map_or(corners, |&w| w as usize);
    let room = if inner.smooth {
        places.len()
    } else {
        3 * corners
    };
    let mut maker = Maker {
        cut,
        source,
        inner,
        runs: vec![(0, 0); places.len()],
        face: Face {
            positions: Vec::with_capacity(room),
            normals: Vec::with_capacity(room),
            coordinates: Vec::with_capacity(room),
            triangles: Vec::with_capacity(corners),
            ids: Vec::with_capacity(room),
            cells: Vec::with_capacity(room),
            places,
        },
        corner: inner.square.0 - inner.square.1 / 2.0,
        pith: inner.stem.rings.pith(),
    };
    let run = maker.tops(tops);
    maker.walls(tops, run);
    maker.face
}

impl Maker<'_> {
    fn index(&self, id: u32) -> usize {
        match (id as usize).checked_sub(self.cut.points) {
            Some(i) => i,
            None => self.cut.vertices.len() + self.cut.inside.len() + id as usize,
        }
    }

    fn grain(&self, index: usize) -> DVec3 {
        let skin = self.cut.vertices.len();
        match index.checked_sub(skin) {
            None => self.cut.vertices[index].grain,
            Some(i) => match self.cut.inside.get(i) {
                Some(&g) => g,
                None => self.source.grain[i - self.cut.inside.len()],
            },
        }
    }

    /// Makes the first `count` triangles, the tops of cells. Returns the number of the last run.
    fn tops(&mut self, count: usize) -> u32 {
        let known = self.inner.bundles.bundles.len() as u32;
        if self.inner.smooth && self.cut.faces[..count].iter().all(|f| f.cell < known) {
            self.smooth_tops(count);
            return 1;
        }
        self.parted_tops(count)
    }

    /// [`Maker::tops`] where all of them are one run, so that every vertex of the cut has one normal.
    fn smooth_tops(&mut self, count: usize) {
        let none = Slot {
            normal: DVec3::ZERO,
            made: [NONE; 2],
        };
        let mut slots = vec![none; self.face.places.len()];
        let mut slot_of: Vec<u32> = Vec::with_capacity(slots.len());
        for t in 0..count {
            let ids = self.cut.cap[t];
            let at = ids.map(|id| self.index(id));
            let (normal, grain, end) = self.lie(at);
            let cell = self.cut.faces[t].cell;
            let corners = [0, 1, 2].map(|k| {
                let slot = &mut slots[at[k]];
                slot.normal += normal;
                let made = &mut slot.made[usize::from(end)];
                if *made == NONE {
                    *made = self.face.ids.len() as u32;
                    slot_of.push(at[k] as u32);
                    self.push(ids[k], at[k], grain[k], cell, end);
                }
                *made
            });
            self.face.triangles.push(corners);
        }
        let normal = |&s: &u32| to_f32(slots[s as usize].normal.normalize_or_zero());
        self.face.normals.extend(slot_of.iter().map(normal));
    }

    /// Normal of a top, as long as twice its area, the grain coordinates of its corners, and whether it shows end grain.
    fn lie(&self, at: [usize; 3]) -> (DVec3, [DVec3; 3], bool) {
        let [a, b, c] = at.map(|i| self.face.places[i]);
        let grain = at.map(|i| self.grain(i));
        let across = (grain[1] - grain[0]).cross(grain[2] - grain[0]);
        let end = across.z * across.z > END_GRAIN * END_GRAIN * across.length_squared();
        ((b - a).cross(c - a), grain, end)
    }

    /// [`Maker::tops`] where cells part them into runs.
    fn parted_tops(&mut self, count: usize) -> u32 {
        let mut slots: Vec<Slot> = Vec::with_capacity(self.runs.len());
        let mut slot_of: Vec<u32> = Vec::with_capacity(self.runs.len());
        let (mut run, mut cell) = (0, NONE);
        for t in 0..count {
            let face = self.cut.faces[t];
            // Walls of cracks have cells beyond the bundles; their edges stay sharp in a smooth face too.
            let known = self.inner.bundles.bundles.len() as u32;
            let smooth = self.inner.smooth && face.cell < known && cell < known;
            if run == 0 || (!smooth && face.cell != cell) {
                run += 1;
            }
            cell = face.cell;
            let ids = self.cut.cap[t];
            let at = ids.map(|id| self.index(id));
            let (normal, grain, end) = self.lie(at);
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
                entry.made[usize::from(end)] = self.face.ids.len() as u32;
                slot_of.push(slot);
                self.push(ids[k], at[k], grain[k], face.cell, end)
            });
            self.face.triangles.push(corners);
        }
        self.face.normals.extend(
            slot_of
                .iter()
                .map(|&s| to_f32(slots[s as usize].normal.normalize_or_zero())),
        );
        run
    }

    /// Makes the walls, whose triangles start at `first`.
    fn walls(&mut self, first: usize, mut run: u32) {
        let ends = self.cut.walls.iter().skip(1).map(|&w| w as usize);
        let ends = ends.chain([self.cut.cap.len()]);
        let mut from = first;
        for to in ends {
            run += 1;
            let mut normal = DVec3::ZERO;
            for t in from..to {
                let ids = self.cut.cap[t];
                let at = ids.map(|id| self.index(id));
                if normal == DVec3::ZERO || to - from > FLAT {
                    let [a, b, c] = at.map(|i| self.face.places[i]);
                    normal = (b - a).cross(c - a).normalize_or_zero();
                }
                let corners = [0, 1, 2].map(|k| {
                    let known = self.runs[at[k]];
                    if known.0 == run {
                        return known.1;
                    }
                    self.runs[at[k]] = (run, self.face.ids.len() as u32);
                    self.face.normals.push(to_f32(normal));
                    let grain = self.grain(at[k]);
                    self.push(ids[k], at[k], grain, self.cut.faces[t].cell, false)
                });
                self.face.triangles.push(corners);
            }
            from = to;
        }
    }

    /// Makes a vertex, without its normal.
    fn push(&mut self, id: u32, index: usize, grain: DVec3, cell: u32, end: bool) -> u32 {
        let across = grain.truncate();
        let coordinates = if end {
            across - self.corner
        } else {
            let phi = self.angle(index, across);
            let middle = self.inner.bundles.bundles.get(cell as usize);
            let phi = middle.map_or(phi, |m| m.phi + wrap(phi - m.phi));
            let r = across.distance(self.pith);
            DVec2::new(self.inner.square.1 + r * (1.0 + DRIFT * phi), grain.z)
        };
        let face = &mut self.face;
        face.positions.push(to_f32(face.places[index]));
        face.coordinates.push(coordinates.as_vec2().to_array());
        face.ids.push(id);
        face.cells.push(cell);
        face.ids.len() as u32 - 1
    }

    /// Angle about the pith, rad.
    fn angle(&self, index: usize, across: DVec2) -> f64 {
        let inside = index.checked_sub(self.cut.vertices.len());
        let node = inside.and_then(|i| self.cut.nodes.get(i));
        match node.and_then(|&n| self.inner.bundles.addresses.get(n as usize)) {
            Some(address) => address.1,
            None => libm::atan2(across.y - self.pith.y, across.x - self.pith.x),
        }
    }
}

fn to_f32(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
