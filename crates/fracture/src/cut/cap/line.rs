//! The short way for a top that the outline crosses along one line, nearly all that it crosses.

use super::super::polygon;
use super::{Builder, INSIDE, OUTSIDE, TopMemory};

/// What lies on a side of a facet between its ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum OnSide {
    Nothing,
    /// One vertex of the outline.
    One(u32),
    /// Several, or where the rims of a wall cross.
    Several,
}

impl Builder<'_, '_> {
    /// Fills the part of a facet on the inner side of the `outline`, where that is one line from side to side. Returns
    /// `false`, with nothing done, where it is anything else.
    pub(super) fn fill_beside_line(
        &mut self,
        facet: u32,
        outline: &[(u32, (u32, u32))],
        memory: &mut TopMemory,
    ) -> bool {
        let TopMemory {
            ring, flat, filled, ..
        } = memory;
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
        let on_sides = [0, 1, 2].map(|k| self.on_side(facet, k));
        let alone = |id: u32| on_sides.iter().position(|&on| on == OnSide::One(id));
        let (Some(from), Some(to)) = (alone(end), alone(start)) else {
            return false;
        };
        let whole = on_sides.iter().filter(|&&on| on == OnSide::Nothing);
        if from == to || whole.count() != 1 {
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

    /// What lies on a side of a facet between its ends.
    fn on_side(&self, facet: u32, k: u8) -> OnSide {
        let layout = self.layout();
        let e = layout.sides[facet as usize][usize::from(k)];
        if self.knot(e).is_some() {
            return OnSide::Several;
        }
        if !self.touched[e as usize] {
            return OnSide::Nothing;
        }
        let which = u8::from(layout.edges[e as usize].facets[1] == (facet, k));
        let mut rail = self.overlay.rail(e, which);
        match (rail.next(), rail.next()) {
            (None, _) => OnSide::Nothing,
            (Some((_, id)), None) => OnSide::One(id),
            _ => OnSide::Several,
        }
    }
}
