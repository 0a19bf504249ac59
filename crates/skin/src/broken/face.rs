//! The broken face of a cut, ready to be drawn: positions, normals and texture coordinates.
//!
//! The wood inside has the texture coordinates of [`crate::texture`], in metres: end grain by its place in the section, side
//! grain by its ring coordinate and length.

use super::inner_wood::InnerWood;
use crate::source::Source;
use glam::DVec3;
use greenstick_fracture::cut::{CapFace, Cut, Host};
use greenstick_fracture::layout::wrap_angle;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, ParallelExtend, ParallelIterator,
};
use std::hint::select_unpredictable;

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
    /// Ring coordinate of each vertex.
    pub rings: Vec<f64>,
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

/// What the triangles of one run have at a vertex of the cut.
#[derive(Clone, Copy)]
struct Slot {
    /// Sum of their normals.
    normal: DVec3,
    /// One more than the number of the vertex made here last, on side and on end grain; 0 for none.
    made: [u32; 2],
}

/// What the triangles of a smooth surface have at a vertex of the cut.
#[derive(Clone, Copy)]
struct SmoothSlot {
    /// Sum of their normals.
    normal: DVec3,
    /// The cell of one of them.
    cell: u32,
    /// Whether any shows side grain, and whether any shows end grain.
    shows: [bool; 2],
}

/// A vertex of the cut. Its exact position is in [`Face::places`].
#[derive(Clone, Copy)]
struct Corner {
    /// Grain coordinates, m.
    grain: DVec3,
    /// Ring coordinate; NaN where it is not known.
    rho: f64,
    /// Angle about the pith, rad.
    phi: f64,
}

/// A vertex of the face.
#[derive(Clone, Copy, Default)]
struct MadeVertex {
    /// Twice its corner's number, and 1 more where it shows end grain.
    at: u32,
    cell: u32,
}

impl MadeVertex {
    fn new(at: usize, end: bool, cell: u32) -> Self {
        MadeVertex {
            at: at as u32 * 2 + u32::from(end),
            cell,
        }
    }

    fn corner(self) -> usize {
        (self.at / 2) as usize
    }

    fn shows_end_grain(self) -> bool {
        self.at % 2 == 1
    }
}

/// What a face is made from.
struct FaceBuilder<'a> {
    cut: &'a Cut,
    inner: &'a InnerWood<'a>,
    /// The vertices of the cut, those of the mesh last and only if the face uses them, and their positions.
    corners: Vec<Corner>,
    places: Vec<DVec3>,
}

/// Triangles of a face, their vertices numbered from 0 on.
#[derive(Default)]
struct FacePart {
    made: Vec<MadeVertex>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl FacePart {
    /// Room for `count` triangles.
    fn of(count: usize) -> Self {
        FacePart {
            // A triangle makes 3 vertices at most; the last place takes what is not needed.
            made: vec![MadeVertex::default(); 3 * count + 1],
            normals: Vec::with_capacity(2 * count),
            triangles: Vec::with_capacity(count),
        }
    }

    /// Appends the triangles of another part, whose vertices come after those of this one.
    fn append(&mut self, other: FacePart) {
        let first = self.made.len() as u32;
        self.made.extend_from_slice(&other.made);
        self.normals.extend_from_slice(&other.normals);
        let moved = |ids: &[u32; 3]| ids.map(|id| first + id);
        self.triangles
            .par_extend(other.triangles.par_iter().map(moved));
    }
}

/// Makes the broken face of a cut.
pub fn face(source: &Source, cut: &Cut, inner: &InnerWood) -> Face {
    let (places, corners) = corners(source, cut, inner);
    let count = cut.cap.len();
    let tops = cut.walls.first().map_or(count, |&w| w as usize);
    let builder = FaceBuilder {
        cut,
        inner,
        corners,
        places,
    };
    let make_tops = || match builder.has_one_run(tops) {
        true => builder.smooth_tops(tops),
        false => builder.tops(tops),
    };
    let (mut part, walls) = rayon::join(make_tops, || builder.walls(tops));
    part.append(walls);
    let mut face = Face {
        normals: part.normals,
        triangles: part.triangles,
        ..Face::default()
    };
    builder.place(&part.made, &mut face);
    face.places = builder.places;
    face
}

/// Returns the vertices of a cut and their positions: its own on the skin, those within the wood, and the mesh's if its
/// face uses them.
fn corners(source: &Source, cut: &Cut, inner: &InnerWood) -> (Vec<DVec3>, Vec<Corner>) {
    const UNKNOWN: (f64, f64) = (f64::NAN, f64::NAN);
    let corner = |grain: DVec3, (rho, phi): (f64, f64)| Corner { grain, rho, phi };
    let own = cut.vertices.len() + cut.inside.len();
    let mut places = Vec::with_capacity(own);
    places.extend(cut.vertices.iter().map(|v| on_skin(source, v.host)));
    places.par_extend((cut.inside.par_iter()).map(|&grain| source.chart.to_world(grain)));
    let mut corners = Vec::with_capacity(own);
    corners.extend(cut.vertices.iter().map(|v| corner(v.grain, UNKNOWN)));
    let within = cut.inside.par_iter().zip(&cut.nodes);
    corners.par_extend(within.map(|(&grain, &node)| {
        let address = inner.bundles.addresses.get(node as usize);
        corner(grain, address.map_or(UNKNOWN, |&a| a))
    }));
    // Vertices of the mesh itself are not expected here, but would follow the others.
    let used = cut.cap.as_flattened().iter();
    if used.fold(u32::MAX, |least, &id| least.min(id)) < cut.points as u32 {
        places.extend((0..cut.points as u32).map(|p| on_skin(source, Host::Point(p))));
        corners.extend(
            source.grain[..cut.points]
                .iter()
                .map(|&g| corner(g, UNKNOWN)),
        );
    }
    (places, corners)
}

impl FaceBuilder<'_> {
    #[inline]
    fn index(&self, id: u32) -> usize {
        match (id as usize).checked_sub(self.cut.points) {
            Some(i) => i,
            None => self.cut.vertices.len() + self.cut.inside.len() + id as usize,
        }
    }

    /// Whether the first `count` triangles are one smooth surface, without walls of cracks.
    fn has_one_run(&self, count: usize) -> bool {
        // Walls of cracks have cells beyond the bundles.
        let known = self.inner.bundles.bundles.len() as u32;
        let cells = self.cut.faces[..count].iter();
        self.inner.smooth && cells.fold(0, |most, of| most.max(of.cell)) < known
    }

    /// [`FaceBuilder::tops`] where all triangles are one run: a vertex of the cut has at most one vertex on end grain and
    /// one on side grain, which are numbered as those of the cut are.
    fn smooth_tops(&self, count: usize) -> FacePart {
        let FacePart {
            mut made,
            mut normals,
            mut triangles,
        } = FacePart::of(count);
        let none = SmoothSlot {
            normal: DVec3::ZERO,
            cell: 0,
            shows: [false; 2],
        };
        let mut slots = vec![none; self.corners.len()];
        let top = |(&ids, of): (&[u32; 3], &CapFace)| {
            let at = ids.map(|id| self.index(id));
            let (normal, end) = self.normal_and_end_grain(at);
            at.map(|at| {
                let slot = &mut slots[at];
                slot.normal += normal;
                slot.cell = of.cell;
                slot.shows[usize::from(end)] = true;
                MadeVertex::new(at, end, 0).at
            })
        };
        triangles.extend(self.cut.cap[..count].iter().zip(&self.cut.faces).map(top));
        let mut numbers = vec![0; 2 * slots.len()];
        let mut used = 0;
        for (at, slot) in slots.iter().enumerate() {
            for end in [false, true] {
                let vertex = MadeVertex::new(at, end, slot.cell);
                made[used] = vertex;
                numbers[vertex.at as usize] = used as u32;
                used += usize::from(slot.shows[usize::from(end)]);
            }
        }
        made.truncate(used);
        for corner in triangles.as_flattened_mut() {
            *corner = numbers[*corner as usize];
        }
        let normal = |vertex: &MadeVertex| slots[vertex.corner()].normal.normalize_or_zero();
        normals.extend(made.iter().map(normal).map(to_f32));
        FacePart {
            made,
            normals,
            triangles,
        }
    }

    /// Makes the first `count` triangles, the tops of cells. Those of one cell, and where the surface is smooth of all, are
    /// one run: a vertex of the cut has one normal there.
    fn tops(&self, count: usize) -> FacePart {
        let FacePart {
            mut made,
            mut normals,
            mut triangles,
        } = FacePart::of(count);
        let none = Slot {
            normal: DVec3::ZERO,
            made: [0; 2],
        };
        // The last one stays as it is.
        let mut slots = vec![none; self.corners.len() + 1];
        let zero = self.corners.len();
        // Walls of cracks have cells beyond the bundles; their edges stay sharp in a smooth face too.
        let known = self.inner.bundles.bundles.len() as u32;
        let (cut, smooth) = (self.cut, self.inner.smooth);
        let (mut used, mut first, mut last) = (0, 0, None);
        let top = |(&ids, of): (&[u32; 3], &CapFace)| {
            let cell = of.cell;
            let continues = |last: u32| last == cell || (smooth && cell < known && last < known);
            if !last.is_some_and(continues) {
                finish_run(&made[first..used], &slots, &mut normals);
                first = used;
            }
            last = Some(cell);
            let at = ids.map(|id| self.index(id));
            let (normal, end) = self.normal_and_end_grain(at);
            at.map(|at| {
                let slot = &slots[at];
                let fresh = slot.made[0].max(slot.made[1]) <= first as u32;
                // Whether a sum begins is not to be predicted, so nothing branches on it.
                let sum = slots[select_unpredictable(fresh, zero, at)].normal;
                let slot = &mut slots[at];
                slot.normal = sum + normal;
                let before = &mut slot.made[usize::from(end)];
                let vertex = MadeVertex::new(at, end, cell);
                let number = make_vertex((&mut made[..], &mut used), vertex, (*before, first));
                *before = number + 1;
                number
            })
        };
        triangles.extend(cut.cap[..count].iter().zip(&cut.faces).map(top));
        finish_run(&made[first..used], &slots, &mut normals);
        made.truncate(used);
        FacePart {
            made,
            normals,
            triangles,
        }
    }

    /// Normal of a top, as long as twice its area, and whether it shows end grain.
    #[inline(always)]
    fn normal_and_end_grain(&self, at: [usize; 3]) -> (DVec3, bool) {
        let [a, b, c] = at.map(|i| self.corners[i].grain);
        let across = (b - a).cross(c - a);
        let end = across.z * across.z > END_GRAIN * END_GRAIN * across.length_squared();
        let [a, b, c] = at.map(|i| self.places[i]);
        ((b - a).cross(c - a), end)
    }

    /// Makes the walls, whose triangles start at `first`: one of few triangles has one normal, one of many follows the bend
    /// of the stem.
    fn walls(&self, first: usize) -> FacePart {
        let cut = self.cut;
        let FacePart {
            mut made,
            mut normals,
            mut triangles,
        } = FacePart::of(cut.cap.len() - first);
        let ends = cut.walls.iter().skip(1).map(|&w| w as usize);
        let (mut from, mut used) = (first, 0);
        // One more than the number of the vertex made last at each corner.
        let mut last = vec![0; self.corners.len()];
        for to in ends.chain([cut.cap.len()]) {
            let (first, is_long) = (used, to - from > MAX_FLAT_WALL);
            let mut normal = DVec3::ZERO;
            for (&ids, of) in cut.cap[from..to].iter().zip(&cut.faces[from..to]) {
                let at = ids.map(|id| self.index(id));
                if is_long {
                    normals.resize(used, to_f32(normal));
                }
                if is_long || normal == DVec3::ZERO {
                    normal = self.wall_normal(at);
                }
                triangles.push(at.map(|at| {
                    let vertex = MadeVertex::new(at, false, of.cell);
                    let number = make_vertex((&mut made[..], &mut used), vertex, (last[at], first));
                    last[at] = number + 1;
                    number
                }));
            }
            normals.resize(used, to_f32(normal));
            from = to;
        }
        made.truncate(used);
        FacePart {
            made,
            normals,
            triangles,
        }
    }

    /// Unit normal of a wall's triangle.
    fn wall_normal(&self, at: [usize; 3]) -> DVec3 {
        let [a, b, c] = at.map(|i| self.places[i]);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Gives the vertices `made` their positions and texture coordinates.
    fn place(&self, made: &[MadeVertex], face: &mut Face) {
        let corners = &self.corners;
        let bundles = &self.inner.bundles.bundles;
        let (square, rings) = (&self.inner.square, &self.inner.stem.rings);
        let position = |made: &MadeVertex| to_f32(self.places[made.corner()]);
        face.positions = made.par_iter().map(position).collect();
        let inside = |made: &MadeVertex| {
            let corner = &corners[made.corner()];
            let across = corner.grain.truncate();
            let (rho, phi) = match corner.rho.is_nan() {
                true => rings.address(across),
                false => (corner.rho, corner.phi),
            };
            let coordinates = if made.shows_end_grain() {
                square.end_grain(across)
            } else {
                let bundle = bundles.get(made.cell as usize);
                let turned = bundle.map_or(0.0, |b| wrap_angle(phi - b.phi));
                square.side_grain(rho, turned, corner.grain.z)
            };
            (coordinates.as_vec2().to_array(), rho)
        };
        (face.coordinates, face.rings) = made.par_iter().map(inside).unzip();
        face.cells = made.par_iter().map(|made| made.cell).collect();
        let (points, own) = (
            self.cut.points as u32,
            (self.cut.vertices.len() + self.cut.inside.len()) as u32,
        );
        let id = |made: &MadeVertex| match made.at / 2 {
            at if at < own => at + points,
            at => at - own,
        };
        face.ids = made.par_iter().map(id).collect();
    }
}

/// Makes a vertex after the `used` ones in `made`, unless that of number `before` − 1, made last in its place, is not before
/// `first`, the first that may be used. Returns the vertex's number. Whether it is new is not to be predicted, so nothing
/// branches on it.
#[inline]
fn make_vertex(
    (made, used): (&mut [MadeVertex], &mut usize),
    vertex: MadeVertex,
    (before, first): (u32, usize),
) -> u32 {
    let (number, is_new) = (*used as u32, before <= first as u32);
    made[*used] = vertex;
    *used += usize::from(is_new);
    select_unpredictable(is_new, number, before.wrapping_sub(1))
}

/// Gives the vertices of a run their normals.
fn finish_run(run: &[MadeVertex], slots: &[Slot], normals: &mut Vec<[f32; 3]>) {
    let normal = |made: &MadeVertex| to_f32(slots[made.corner()].normal.normalize_or_zero());
    normals.extend(run.iter().map(normal));
}

fn to_f32(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
