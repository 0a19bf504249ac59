//! Cutting the skin of a stem along a break surface.
//!
//! Each triangle of the skin is projected onto the facets of the surface in the (x, y) plane of grain space. Which facets it
//! meets follows from exact orientation tests alone, so neighbouring triangles always agree, and a point cut on an
//! edge is made once and shared. Within a facet the skin lies above the surface (upper piece) or below it (lower
//! piece); the lines between are the outline that the broken faces must fill.

pub(super) mod clips;
mod join;
mod line;
pub(super) mod outline;

use super::error::CutError;
use super::parts::Host;
use crate::surface::NONE;
use clips::{Clips, Corner, Part, Slot, Support};
use join::{JoinMemory, Piece};
use outline::{EdgeCut, Overlay};

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

/// A corner of a clipped polygon, or a point where the surface cuts its boundary.
#[derive(Clone, Copy, Debug)]
struct RingCorner {
    id: u32,
    /// Whether it lies above the surface; none for a cut point.
    upper: Option<bool>,
    /// What the edge to the next corner lies on.
    support: Support,
    /// As in [`Placed`].
    agreed: bool,
}

/// Where the surface cuts an edge of a triangle's part.
#[derive(Clone, Copy, Debug)]
struct End {
    id: u32,
    support: Support,
}

/// The part of the outline over one facet, directed as the upper skin has it.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: End,
    to: End,
}

/// Memory that is reused from triangle to triangle.
#[derive(Debug, Default)]
pub(super) struct SplitMemory {
    pieces: Vec<Piece>,
    /// Height above the surface of every corner of the triangle's parts, m, and where each part lies.
    above: Vec<f64>,
    places: Vec<Place>,
    placed: Vec<Placed>,
    /// The boundary of a clipped polygon with the cut points put in, and where in it those are.
    ring: Vec<RingCorner>,
    turns: Vec<u32>,
    /// Edges of polygons along the layout's: (ends, edge).
    spans: Vec<(u32, u32, u32)>,
    /// The outline through a triangle over a surface without steps.
    line: Vec<Segment>,
    join: JoinMemory,
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
    let least = |a: f64, b: f64| if a < b { a } else { b };
    let greatest = |a: f64, b: f64| if a > b { a } else { b };
    let height = (w[0] * h[0] + w[1] * h[1] + w[2] * h[2]) / w[3];
    // Rounding must not lead past the corners, between which whole triangles are distinguished from cut ones.
    let height = greatest(height, least(least(h[0], h[1]), h[2]));
    least(height, greatest(greatest(h[0], h[1]), h[2]))
}

impl Overlay<'_> {
    /// Cuts triangle number `triangle` with the points `corners`; `parts` are its parts over the facets.
    pub fn split(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
        memory: &mut SplitMemory,
    ) -> Result<Place, CutError> {
        self.made.resize(clips.vertices.len(), NONE);
        match self.measure(clips, parts, memory) {
            Place::Split
                if !self.stepped
                    && self.split_along_line(triangle, corners, clips, parts, memory) =>
            {
                Ok(Place::Split)
            }
            Place::Split => self.split_parts(triangle, corners, clips, parts, memory),
            whole => Ok(whole),
        }
    }

    /// Heights of a triangle's parts above the surface, and where each part and all of them lie.
    fn measure(&self, clips: &Clips, parts: (u32, u32), memory: &mut SplitMemory) -> Place {
        memory.above.clear();
        memory.places.clear();
        let (mut below, mut above) = (false, false);
        for part in &clips.parts[parts.0 as usize..parts.1 as usize] {
            let heights = &self.surface.heights[part.facet as usize];
            let (mut low, mut high) = (false, false);
            for slot in &clips.slots[part.slots.0 as usize..part.slots.1 as usize] {
                let height = match slot.corner {
                    Corner::Point(_) => over(heights, &clips.weights[slot.vertex as usize]),
                    _ => {
                        let [a, b] = slot.ends.map(|k| heights[usize::from(k)]);
                        a + (b - a) * slot.fraction
                    }
                };
                let off = slot.length - height;
                let is_above = off > 0.0;
                (low, high) = (low | !is_above, high | is_above);
                memory.above.push(off);
            }
            (below, above) = (below | low, above | high);
            memory.places.push(match (low, high) {
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

    /// Splits a triangle that [`Overlay::measure`] found on both sides.
    fn split_parts(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
        memory: &mut SplitMemory,
    ) -> Result<Place, CutError> {
        memory.pieces.clear();
        memory.spans.clear();
        let first = clips.parts[parts.0 as usize].slots.0;
        for (i, part) in clips.parts[parts.0 as usize..parts.1 as usize]
            .iter()
            .enumerate()
        {
            match memory.places[i] {
                Place::Split => {
                    memory.placed.clear();
                    for s in part.slots.0..part.slots.1 {
                        let slot = clips.slots[s as usize];
                        memory.placed.push(Placed {
                            id: self.corner(corners, slot, clips),
                            above: memory.above[(s - first) as usize],
                            slot,
                            agreed: self.agreed(part.facet, slot),
                        });
                    }
                    self.divide(triangle, corners, part.facet, clips, memory)?;
                }
                whole => self.outline(corners, part, clips, (parts.0, whole), memory)?,
            }
        }
        self.expand(&memory.spans, &mut memory.pieces, &mut memory.join);
        self.join(triangle, corners, &mut memory.pieces, &mut memory.join)?;
        Ok(Place::Split)
    }

    /// Takes the edges of a part that lies all on one side, but for those to parts on the same side.
    fn outline(
        &mut self,
        corners: [u32; 3],
        part: &Part,
        clips: &Clips,
        (first, place): (u32, Place),
        memory: &mut SplitMemory,
    ) -> Result<(), CutError> {
        let layout = &self.surface.layout;
        let slots = &clips.slots[part.slots.0 as usize..part.slots.1 as usize];
        for (j, &slot) in slots.iter().enumerate() {
            let (edge, side) = match slot.support {
                Support::Skin(side) => (NONE, side),
                Support::Facet(k) => {
                    if self.agreed(part.facet, slot)
                        || slot.beyond != NONE
                            && memory.places[(slot.beyond - first) as usize] == place
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
            memory.pieces.push(Piece {
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
        memory: &mut SplitMemory,
    ) -> Result<(), CutError> {
        self.cut_ring(triangle, corners, facet, clips, memory);
        let sides = self.surface.layout.sides[facet as usize];
        add_ring_pieces(sides, memory);
        self.add_spans(sides, memory)?;
        self.add_cut_lines(facet, memory);
        Ok(())
    }

    /// Goes around a clipped polygon and puts in a corner wherever the surface cuts an edge.
    fn cut_ring(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        facet: u32,
        clips: &Clips,
        memory: &mut SplitMemory,
    ) {
        let SplitMemory {
            placed: polygon,
            ring,
            turns,
            ..
        } = memory;
        ring.clear();
        turns.clear();
        for j in 0..polygon.len() {
            let (a, b) = (polygon[j], polygon[(j + 1) % polygon.len()]);
            let corner = |id, upper| RingCorner {
                id,
                upper,
                support: a.slot.support,
                agreed: a.agreed,
            };
            ring.push(corner(a.id, Some(a.above > 0.0)));
            if (a.above > 0.0) != (b.above > 0.0) {
                turns.push(ring.len() as u32);
                let id = self.cut((triangle, corners), facet, a, b, clips);
                ring.push(corner(id, None));
            }
        }
    }

    /// Lists the polygon's edges along those of the layout, between which the neighbouring facet may have cut points.
    fn add_spans(&self, sides: [u32; 3], memory: &mut SplitMemory) -> Result<(), CutError> {
        let polygon = &memory.placed;
        for (j, a) in polygon.iter().enumerate() {
            let b = &polygon[(j + 1) % polygon.len()];
            let Support::Facet(k) = a.slot.support else {
                continue;
            };
            if a.agreed {
                continue;
            }
            let edge = sides[usize::from(k)];
            memory.spans.push((a.id.min(b.id), a.id.max(b.id), edge));
            let facets = &self.surface.layout.edges[edge as usize].facets;
            if facets.iter().any(|f| f.0 == NONE) {
                return Err(CutError::OffLayout {
                    at: self.grain(a.id),
                });
            }
        }
        Ok(())
    }

    /// Joins the cut points: every run of upper corners starts at one and ends at the next.
    fn add_cut_lines(&mut self, facet: u32, memory: &mut SplitMemory) {
        let (ring, turns) = (&memory.ring, &memory.turns);
        for (n, &i) in turns.iter().enumerate() {
            let i = i as usize;
            if ring[(i + 1) % ring.len()].upper == Some(true) {
                let (entry, exit) = (ring[i].id, ring[turns[(n + 1) % turns.len()] as usize].id);
                for (from, to, upper) in [(exit, entry, true), (entry, exit, false)] {
                    memory.pieces.push(Piece {
                        from,
                        to,
                        upper,
                        edge: NONE,
                        side: 3,
                    });
                }
                self.tops.push((facet, [exit, entry]));
            }
        }
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
            self.cuts.push(EdgeCut {
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
}

/// Adds the edges of a divided polygon's boundary to those of the lower and the upper piece; `sides` are the edges of the
/// layout along the facet's sides.
fn add_ring_pieces(sides: [u32; 3], memory: &mut SplitMemory) {
    let ring = &memory.ring;
    for (i, corner) in ring.iter().enumerate() {
        if corner.agreed {
            continue;
        }
        let next = ring[(i + 1) % ring.len()];
        let (edge, side) = match corner.support {
            Support::Skin(side) => (NONE, side),
            Support::Facet(k) => (sides[usize::from(k)], 3),
        };
        memory.pieces.push(Piece {
            from: corner.id,
            to: next.id,
            // A cut point belongs to the run that follows it.
            upper: corner.upper.or(next.upper).unwrap_or(false),
            edge,
            side,
        });
    }
}
