//! The short way for a top that the outline crosses along one line, nearly all that it crosses.

use super::super::polygon;
use super::{Builder, INSIDE, LineMemory, OUTSIDE};

impl Builder<'_, '_> {
    /// Fills the part of a facet on the inner side of the `outline`, where that is one line from side to side. Returns
    /// `false`, with nothing done, where it is anything else.
    pub(super) fn fill_beside_line(
        &mut self,
        facet: u32,
        outline: &[(u32, (u32, u32))],
        memory: &mut LineMemory,
    ) -> bool {
        let LineMemory { ring, flat, filled } = memory;
        ring.clear();
        let next = |id: u32| {
            let i = outline.partition_point(|c| c.1.0 < id);
            outline.get(i).filter(|c| c.1.0 == id).map(|c| c.1.1)
        };
        let mut starts =
            (outline.iter().map(|c| c.1.0)).filter(|&a| outline.iter().all(|c| c.1.1 != a));
        let (Some(start), None) = (starts.next(), starts.next()) else {
            return false;
        };
        ring.push(start);
        let mut end = start;
        // In a solid whose edges belong to several triangles, the outline may run into a circle.
        while let Some(id) = next(end).filter(|_| ring.len() <= outline.len()) {
            ring.push(id);
            end = id;
        }
        if ring.len() != outline.len() + 1 {
            return false;
        }
        let (Some(from), Some(to)) = (
            self.only_on_side(facet, end),
            self.only_on_side(facet, start),
        ) else {
            return false;
        };
        let crossed = (0..3u8).filter(|&k| !self.is_whole_side(facet, k)).count();
        if from == to || crossed != 2 {
            return false;
        }
        let corners = self.corners(facet);
        let mut status = [OUTSIDE; 3];
        let mut at = from;
        while at != to {
            at = (at + 1) % 3;
            ring.push(corners[at]);
            status[at] = INSIDE;
        }
        filled.clear();
        if ring.len() == 3 {
            filled.push([0, 1, 2]);
        } else {
            flat.clear();
            flat.extend(ring.iter().map(|&id| self.grain(id).truncate()));
            // A loop that meets itself or runs the other way, by rounding, is left to the general way.
            if polygon::twice_area(flat) < 0.0 || self.triangulator.polygon(flat, filled).is_err() {
                return false;
            }
            polygon::part_slivers(flat, filled);
        }
        self.status[facet as usize] = status;
        let triangles = filled.iter().map(|t| (facet, t.map(|i| ring[i as usize])));
        self.crossed.extend(triangles);
        true
    }

    /// The side of a facet on which a vertex of the outline lies alone.
    fn only_on_side(&self, facet: u32, id: u32) -> Option<usize> {
        let layout = self.layout();
        (0..3u8).find_map(|k| {
            let e = layout.sides[facet as usize][usize::from(k)];
            if !self.touched[e as usize] {
                return None;
            }
            let which = u8::from(layout.edges[e as usize].facets[1] == (facet, k));
            let mut on_side = self.overlay.rail(e, which);
            let alone = on_side.next().is_some_and(|p| p.1 == id) && on_side.next().is_none();
            (alone && self.knot(e).is_none()).then_some(usize::from(k))
        })
    }

    /// Whether no vertex lies on a side of a facet but its ends.
    fn is_whole_side(&self, facet: u32, k: u8) -> bool {
        let layout = self.layout();
        let e = layout.sides[facet as usize][usize::from(k)];
        let which = u8::from(layout.edges[e as usize].facets[1] == (facet, k));
        self.knot(e).is_none()
            && (!self.touched[e as usize] || self.overlay.rail(e, which).next().is_none())
    }
}
