//! Cutting the skin of a stem along a break surface.
//!
//! Each triangle of the skin is laid over the facets of the surface in the (x, y) plane of grain space. Which facets it
//! meets follows from exact orientation tests alone, so neighbouring triangles always agree, and a point cut on an
//! edge is made once and shared. Within a facet the skin lies above the surface (upper piece) or below it (lower
//! piece); the lines between are the outline that the broken faces must fill.

pub(super) mod clips;
mod join;

use super::{CutError, CutVertex, Host, SkinTriangle};
use crate::surface::{FractureSurface, NONE};
use clips::{Clips, Corner, Part, Slot, Support};
use glam::DVec3;
use greenstick_geometry::triangulate::Triangulator;
use rustc_hash::FxHashMap;

/// A corner of the part of a triangle over a facet.
#[derive(Clone, Copy, Debug)]
struct Placed {
    id: u32,
    /// Height above the surface, m.
    above: f64,
    slot: Slot,
    /// Whether the facets of the edge to the next corner agree on it, so that no outline runs along it.
    agreed: bool,
}

/// A point where the surface cuts an edge of a clipped polygon.
#[derive(Clone, Copy, Debug)]
struct Cut {
    fraction: f64,
    id: u32,
    above: [u64; 2],
    /// The next one on the same edge, or [`NONE`].
    next: u32,
}

/// A directed edge of the lower or the upper part of a triangle.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: u32,
    to: u32,
    upper: bool,
    /// The edge of the layout it lies on, or [`NONE`].
    edge: u32,
    /// Side of the skin's triangle it lies on, or 3.
    side: u8,
}

/// Memory for one triangle after another.
#[derive(Debug, Default)]
struct Scratch {
    pieces: Vec<Piece>,
    /// Height above the surface of every corner of the triangle's parts, m, and where each part lies.
    above: Vec<f64>,
    places: Vec<Place>,
    placed: Vec<Placed>,
    ring: Vec<(u32, Option<bool>, Support, bool)>,
    turns: Vec<u32>,
    /// Edges of polygons along the layout's: (ends, edge).
    spans: Vec<(u32, u32, u32)>,
    join: join::Scratch,
}

/// The outline of the cut and everything found on the way. Vertex numbers below `points.len()` are the skin's points,
/// the others index `vertices`.
pub(super) struct Overlay<'a> {
    surface: &'a FractureSurface,
    /// Grain coordinates of the skin's points.
    points: &'a [DVec3],
    /// Vertices made by the cut.
    pub vertices: Vec<CutVertex>,
    /// Outline on the top of a facet, directed as the upper skin has it: (facet, [from, to]).
    pub tops: Vec<(u32, [u32; 2])>,
    /// Outline on the wall over an edge: (edge, [from, to]).
    pub walls: Vec<(u32, [u32; 2])>,
    /// Outline points on the top rim of a wall: (edge, which of its facets), fraction of the edge, vertex; see
    /// [`Overlay::sort`].
    pub rails: Vec<((u32, u8), f64, u32)>,
    /// Where the line along the grain over a node pierces the skin: node, length, vertex; see [`Overlay::sort`].
    pub uprights: Vec<(u32, f64, u32)>,
    /// New triangles of the skin.
    pub skin: Vec<SkinTriangle>,
    /// Number of each of [`Clips::vertices`] in this cut, or [`NONE`].
    made: Vec<u32>,
    /// First of `cuts` on the edge between two vertices.
    first_cuts: FxHashMap<(u32, u32), u32>,
    cuts: Vec<Cut>,
    scratch: Scratch,
    triangulator: Triangulator,
}

/// Which side of the surface a whole triangle lies on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    /// All below.
    Lower,
    /// All above.
    Upper,
    /// Cut; its parts are in [`Overlay::skin`].
    Split,
}

/// Height of a facet's plane where its corners have `weights`, the last of which is their sum.
fn over(heights: &[f64; 3], weights: &[f64; 4]) -> f64 {
    let (h, w) = (heights, weights);
    // Rounding must not lead past the corners, between which whole triangles are told from cut ones.
    ((w[0] * h[0] + w[1] * h[1] + w[2] * h[2]) / w[3])
        .max(h[0].min(h[1]).min(h[2]))
        .min(h[0].max(h[1]).max(h[2]))
}

impl<'a> Overlay<'a> {
    /// With room for about as many vertices as the break before had made.
    pub fn new(surface: &'a FractureSurface, points: &'a [DVec3], room: usize) -> Self {
        Overlay {
            surface,
            points,
            vertices: Vec::with_capacity(room),
            tops: Vec::with_capacity(room),
            walls: Vec::new(),
            rails: Vec::with_capacity(room),
            uprights: Vec::new(),
            skin: Vec::with_capacity(2 * room),
            made: Vec::new(),
            first_cuts: FxHashMap::with_capacity_and_hasher(room, Default::default()),
            cuts: Vec::with_capacity(room),
            scratch: Scratch::default(),
            triangulator: Triangulator::default(),
        }
    }

    /// Number of the skin's points.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Grain coordinates of a vertex.
    pub fn grain(&self, id: u32) -> DVec3 {
        match (id as usize).checked_sub(self.points.len()) {
            None => self.points[id as usize],
            Some(i) => self.vertices[i].grain,
        }
    }

    pub fn add(&mut self, grain: DVec3, host: Host) -> u32 {
        self.vertices.push(CutVertex { grain, host });
        (self.points.len() + self.vertices.len() - 1) as u32
    }

    /// Sorts what was found by where it lies; to be done before [`Overlay::rail`] and [`Overlay::upright`].
    pub fn sort(&mut self) {
        self.rails
            .sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        self.rails.dedup();
        self.uprights
            .sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }

    /// Outline points on the rim of a wall, by rising fraction.
    pub fn rail(&self, edge: u32, which: u8) -> impl DoubleEndedIterator<Item = (f64, u32)> {
        let from = self.rails.partition_point(|r| r.0 < (edge, which));
        let count = self.rails[from..].partition_point(|r| r.0 == (edge, which));
        self.rails[from..from + count].iter().map(|r| (r.1, r.2))
    }

    /// Where the line along the grain over a node pierces the skin, by rising length.
    pub fn upright(&self, node: u32) -> impl Iterator<Item = (f64, u32)> {
        let from = self.uprights.partition_point(|r| r.0 < node);
        let count = self.uprights[from..].partition_point(|r| r.0 == node);
        self.uprights[from..from + count].iter().map(|r| (r.1, r.2))
    }

    /// Cuts triangle number `triangle` with the points `corners`; `parts` are its parts over the facets.
    pub fn split(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
    ) -> Result<Place, CutError> {
        self.made.resize(clips.vertices.len(), NONE);
        let mut scratch = std::mem::take(&mut self.scratch);
        let place = match self.measure(corners, clips, parts, &mut scratch) {
            Place::Split => self.part(triangle, corners, clips, parts, &mut scratch),
            whole => Ok(whole),
        };
        self.scratch = scratch;
        place
    }

    /// Heights of a triangle's parts above the surface, and where each part and all of them lie.
    fn measure(
        &self,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
        scratch: &mut Scratch,
    ) -> Place {
        scratch.above.clear();
        scratch.places.clear();
        let (mut below, mut above) = (false, false);
        for part in &clips.parts[parts.0 as usize..parts.1 as usize] {
            let heights = &self.surface.heights[part.facet as usize];
            let (mut low, mut high) = (false, false);
            for slot in &clips.slots[part.slots.0 as usize..part.slots.1 as usize] {
                let (at, height) = match slot.corner {
                    Corner::Point(i) => (
                        self.points[corners[usize::from(i)] as usize].z,
                        over(heights, &clips.weights[slot.vertex as usize]),
                    ),
                    Corner::Crossing(_, k) => {
                        let [a, b] = self.surface.side_heights(part.facet, k);
                        let fixed = &clips.vertices[slot.vertex as usize];
                        (fixed.grain.z, a + (b - a) * fixed.fraction)
                    }
                    Corner::Node(k) => (
                        clips.vertices[slot.vertex as usize].grain.z,
                        heights[usize::from(k)],
                    ),
                };
                let off = at - height;
                if off > 0.0 {
                    high = true;
                } else {
                    low = true;
                }
                scratch.above.push(off);
            }
            (below, above) = (below | low, above | high);
            scratch.places.push(match (low, high) {
                (true, true) => Place::Split,
                (false, _) => Place::Upper,
                (true, false) => Place::Lower,
            });
        }
        match (below, above) {
            (true, true) => Place::Split,
            (false, _) => Place::Upper,
            (true, false) => Place::Lower,
        }
    }

    /// Parts a triangle that [`Overlay::measure`] found on both sides.
    fn part(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
        scratch: &mut Scratch,
    ) -> Result<Place, CutError> {
        scratch.pieces.clear();
        scratch.spans.clear();
        let first = clips.parts[parts.0 as usize].slots.0;
        for (i, part) in clips.parts[parts.0 as usize..parts.1 as usize]
            .iter()
            .enumerate()
        {
            match scratch.places[i] {
                Place::Split => {
                    scratch.placed.clear();
                    for s in part.slots.0..part.slots.1 {
                        let slot = clips.slots[s as usize];
                        scratch.placed.push(Placed {
                            id: self.corner(corners, slot, clips),
                            above: scratch.above[(s - first) as usize],
                            slot,
                            agreed: self.agreed(part.facet, slot),
                        });
                    }
                    self.divide(triangle, corners, part.facet, clips, scratch)?;
                }
                whole => self.outline(corners, part, clips, (parts.0, whole), scratch)?,
            }
        }
        self.expand(&scratch.spans, &mut scratch.pieces, &mut scratch.join);
        self.join(triangle, corners, &mut scratch.pieces, &mut scratch.join)?;
        Ok(Place::Split)
    }

    /// Takes the edges of a part that lies all on one side, but for those to parts on the same side.
    fn outline(
        &mut self,
        corners: [u32; 3],
        part: &Part,
        clips: &Clips,
        (first, place): (u32, Place),
        scratch: &mut Scratch,
    ) -> Result<(), CutError> {
        let layout = &self.surface.layout;
        let slots = &clips.slots[part.slots.0 as usize..part.slots.1 as usize];
        for (j, &slot) in slots.iter().enumerate() {
            let (edge, side) = match slot.support {
                Support::Skin(side) => (NONE, side),
                Support::Facet(k) => {
                    if self.agreed(part.facet, slot)
                        || slot.beyond != NONE
                            && scratch.places[(slot.beyond - first) as usize] == place
                    {
                        continue;
                    }
                    let edge = layout.sides[part.facet as usize][usize::from(k)];
                    if layout.edges[edge as usize].facets[1].0 == NONE
                        || layout.edges[edge as usize].facets[0].0 == NONE
                    {
                        let id = self.corner(corners, slot, clips);
                        return Err(CutError::OffLayout { at: self.grain(id) });
                    }
                    (edge, 3)
                }
            };
            let from = self.corner(corners, slot, clips);
            let to = self.corner(corners, slots[(j + 1) % slots.len()], clips);
            scratch.pieces.push(Piece {
                from,
                to,
                upper: place == Place::Upper,
                edge,
                side,
            });
        }
        Ok(())
    }

    /// Whether the facets on both sides of the edge from a corner have the same heights there, and the triangle has
    /// parts over both: what each of them has on the edge, the other has the other way round.
    fn agreed(&self, facet: u32, slot: Slot) -> bool {
        let Support::Facet(k) = slot.support else {
            return false;
        };
        let layout = &self.surface.layout;
        let edge = &layout.edges[layout.sides[facet as usize][usize::from(k)] as usize];
        let (other, side) = edge.facets[usize::from(edge.facets[0] == (facet, k))];
        slot.beyond != NONE
            && self.surface.side_heights(facet, k) == self.surface.side_heights(other, side)
    }

    /// The vertex at a corner of a part.
    fn corner(&mut self, corners: [u32; 3], slot: Slot, clips: &Clips) -> u32 {
        match slot.corner {
            Corner::Point(i) => corners[usize::from(i)],
            _ => self.fixed(slot.vertex, clips),
        }
    }

    /// The vertex in this cut of one of [`Clips::vertices`].
    fn fixed(&mut self, number: u32, clips: &Clips) -> u32 {
        let known = self.made[number as usize];
        if known != NONE {
            return known;
        }
        let fixed = &clips.vertices[number as usize];
        let id = self.add(fixed.grain, fixed.host);
        self.made[number as usize] = id;
        if fixed.node != NONE {
            self.uprights.push((fixed.node, fixed.grain.z, id));
        }
        id
    }

    /// Fraction along side `k`'s edge of a corner that lies on that side.
    fn fraction(&self, facet: u32, k: u8, slot: Slot, clips: &Clips) -> f64 {
        let layout = &self.surface.layout;
        let edge = layout.sides[facet as usize][usize::from(k)];
        match slot.corner {
            Corner::Crossing(..) => clips.vertices[slot.vertex as usize].fraction,
            Corner::Node(n) => {
                let node = layout.facets[facet as usize][usize::from(n)];
                f64::from(u8::from(layout.edges[edge as usize].nodes[1] == node))
            }
            Corner::Point(_) => 0.5,
        }
    }

    /// Divides a clipped polygon by the facet's plane into lower and upper pieces.
    fn divide(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        facet: u32,
        clips: &Clips,
        scratch: &mut Scratch,
    ) -> Result<(), CutError> {
        let surface = self.surface;
        let layout = &surface.layout;
        let Scratch {
            pieces,
            placed: polygon,
            ring,
            turns,
            spans,
            ..
        } = scratch;
        let count = polygon.len();
        // The polygon's boundary with the cut points put in: (vertex, in the upper part, support of the next edge).
        ring.clear();
        turns.clear();
        for j in 0..count {
            let (a, b) = (polygon[j], polygon[(j + 1) % count]);
            ring.push((a.id, Some(a.above > 0.0), a.slot.support, a.agreed));
            if (a.above > 0.0) != (b.above > 0.0) {
                turns.push(ring.len() as u32);
                let id = self.cut((triangle, corners), facet, a, b, clips);
                ring.push((id, None, a.slot.support, a.agreed));
            }
        }
        let is_upper = |i: usize| {
            // A cut point belongs to the run that follows it.
            ring[i]
                .1
                .unwrap_or_else(|| ring[(i + 1) % ring.len()].1.unwrap_or(false))
        };
        for i in 0..ring.len() {
            let (from, _, support, agreed) = ring[i];
            if agreed {
                continue;
            }
            let to = ring[(i + 1) % ring.len()].0;
            let (edge, side) = match support {
                Support::Skin(side) => (NONE, side),
                Support::Facet(k) => (layout.sides[facet as usize][usize::from(k)], 3),
            };
            pieces.push(Piece {
                from,
                to,
                upper: is_upper(i),
                edge,
                side,
            });
        }
        for a in polygon
            .iter()
            .enumerate()
            .map(|(j, a)| (a, &polygon[(j + 1) % count]))
        {
            if let Support::Facet(k) = a.0.slot.support {
                if a.0.agreed {
                    continue;
                }
                let edge = layout.sides[facet as usize][usize::from(k)];
                spans.push((a.0.id.min(a.1.id), a.0.id.max(a.1.id), edge));
                if layout.edges[edge as usize]
                    .facets
                    .iter()
                    .any(|f| f.0 == NONE)
                {
                    return Err(CutError::OffLayout {
                        at: self.grain(a.0.id),
                    });
                }
            }
        }
        // Every run of upper corners starts at one cut point and ends at the next; the cut joins them.
        for (n, &i) in turns.iter().enumerate() {
            let i = i as usize;
            if ring[(i + 1) % ring.len()].1 == Some(true) {
                let (entry, exit) = (ring[i].0, ring[turns[(n + 1) % turns.len()] as usize].0);
                pieces.push(Piece {
                    from: exit,
                    to: entry,
                    upper: true,
                    edge: NONE,
                    side: 3,
                });
                pieces.push(Piece {
                    from: entry,
                    to: exit,
                    upper: false,
                    edge: NONE,
                    side: 3,
                });
                self.tops.push((facet, [exit, entry]));
            }
        }
        Ok(())
    }

    /// The vertex where the surface cuts the polygon's edge a–b.
    fn cut(
        &mut self,
        (triangle, corners): (u32, [u32; 3]),
        facet: u32,
        a: Placed,
        b: Placed,
        clips: &Clips,
    ) -> u32 {
        let (p, q) = if a.id < b.id { (a, b) } else { (b, a) };
        let above = [p.above.to_bits(), q.above.to_bits()];
        let fraction = p.above / (p.above - q.above);
        let first = *self.first_cuts.entry((p.id, q.id)).or_insert(NONE);
        let (mut known, mut last) = (None, NONE);
        let mut at = first;
        while let Some(cut) = self.cuts.get(at as usize) {
            if cut.above == above {
                known = Some(*cut);
                break;
            }
            (last, at) = (at, cut.next);
        }
        let id = if let Some(cut) = known {
            cut.id
        } else {
            let grain = self.grain(p.id).lerp(self.grain(q.id), fraction);
            let host = match a.slot.support {
                Support::Skin(i) => {
                    let (x, y) = (corners[usize::from(i)], corners[(usize::from(i) + 1) % 3]);
                    let ends = [x.min(y), x.max(y)];
                    let along = |v: u32| match v {
                        _ if v == ends[0] => 0.0,
                        _ if v == ends[1] => 1.0,
                        _ => match self.vertices[v as usize - self.points.len()].host {
                            Host::Edge { t, .. } => t,
                            _ => 0.5,
                        },
                    };
                    let (u, v) = (along(p.id), along(q.id));
                    Host::Edge {
                        ends,
                        t: u + (v - u) * fraction,
                    }
                }
                Support::Facet(_) => {
                    let (u, v) = (self.weights(p.id, corners), self.weights(q.id, corners));
                    Host::Face {
                        triangle,
                        weights: [0, 1, 2].map(|i| u[i] + (v[i] - u[i]) * fraction),
                    }
                }
            };
            let id = self.add(grain, host);
            let number = self.cuts.len() as u32;
            self.cuts.push(Cut {
                fraction,
                id,
                above,
                next: NONE,
            });
            match self.cuts.get_mut(last as usize) {
                Some(last) => last.next = number,
                None => {
                    self.first_cuts.insert((p.id, q.id), number);
                }
            }
            id
        };
        if let Support::Facet(k) = a.slot.support {
            let layout = &self.surface.layout;
            let edge = layout.sides[facet as usize][usize::from(k)];
            let which = u8::from(layout.edges[edge as usize].facets[1] == (facet, k));
            let (u, v) = (
                self.fraction(facet, k, p.slot, clips),
                self.fraction(facet, k, q.slot, clips),
            );
            self.rails.push(((edge, which), u + (v - u) * fraction, id));
        }
        id
    }

    /// Barycentric weights of a vertex in the triangle with the points `corners`.
    pub fn weights(&self, id: u32, corners: [u32; 3]) -> [f64; 3] {
        let unit = |p: u32| [0, 1, 2].map(|i| f64::from(u8::from(corners[i] == p)));
        let Some(i) = (id as usize).checked_sub(self.points.len()) else {
            return unit(id);
        };
        match self.vertices[i].host {
            Host::Point(p) => unit(p),
            Host::Edge { ends, t } => {
                let (u, v) = (unit(ends[0]), unit(ends[1]));
                [0, 1, 2].map(|i| u[i] * (1.0 - t) + v[i] * t)
            }
            Host::Face { weights, .. } => weights,
            Host::Inside => [f64::NAN; 3],
        }
    }
}
