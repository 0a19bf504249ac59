//! Chips: parts of one piece that a cut leaves hanging in the air, given to the other piece.
//!
//! Where the skin bulges or the surface runs out steeply, a sliver of one piece may not be joined to the rest of it. It is
//! joined to the other piece by the face between them; that face is removed and the chip changes sides.

use super::{Cut, FacetGrid, Side, Skin, Solid};
use crate::surface::NONE;
use greenstick_geometry::Unions;

/// A whole triangle of the limb about the break.
struct WholeTriangle {
    /// Its place in [`super::Sides::between`].
    place: usize,
    /// Its points.
    points: [u32; 3],
}

impl Cut {
    /// Gives every part of a piece that is not joined to the rest of it to the other piece. `skin` is the sorted skin of
    /// `solid` and `grid` that of the facets near it. Returns how many.
    pub fn absorb_chips(&mut self, solid: &Solid, skin: &Skin, grid: &FacetGrid) -> usize {
        // One closed outline splits a stem into two pieces and no more.
        if self.outlines <= 1 {
            return 0;
        }
        let joined = self.joined_by_face(grid);
        let chips = self.absorb(solid, skin, false, joined.clone());
        let joined = if chips == 0 {
            joined
        } else {
            self.joined_by_face(grid)
        };
        chips + self.absorb(solid, skin, true, joined)
    }

    /// Joins the vertices of the split triangles of a piece, and those from which whole triangles lead beyond the break to
    /// [`Cut::beyond`]. Returns whether that joins all of the piece: each part of it has split triangles on its
    /// border.
    fn join_split(&self, solid: &Solid, skin: &Skin, upper: bool, joined: &mut Unions) -> bool {
        let beyond = self.beyond();
        let parts = || self.skin.iter().filter(|s| s.upper == upper);
        for part in parts() {
            joined.join_triangle(part.corners);
        }
        for p in parts().flat_map(|s| s.corners) {
            if (p as usize) < self.points
                && joined.root(p) != joined.root(beyond)
                && self.leads_beyond(p, solid, skin, upper)
            {
                joined.join(p, beyond);
            }
        }
        let main = joined.root(beyond);
        parts().all(|part| joined.root(part.corners[0]) == main)
    }

    /// Whether whole triangles of a piece lead from a point of it away from the break and beyond all that the break
    /// touches.
    fn leads_beyond(&self, mut point: u32, solid: &Solid, skin: &Skin, upper: bool) -> bool {
        let side = if upper { Side::Upper } else { Side::Lower };
        let farthest = |p: u32| {
            let (first, last) = skin.about(p);
            // Greater is farther, on both sides.
            let rank = if upper { last } else { first };
            (first <= last).then_some((if upper { rank } else { !rank }, rank))
        };
        while let Some((distance, rank)) = farthest(point) {
            if self.is_beyond(skin, point, upper) {
                return true;
            }
            let place = rank as usize - self.sides.below;
            if self.sides.between.get(place) != Some(&side) {
                return false;
            }
            let corners = solid.triangles[skin.order[rank as usize] as usize];
            let next = corners.into_iter().max_by_key(|&p| farthest(p));
            match next.filter(|&p| farthest(p).is_some_and(|(d, _)| d > distance)) {
                Some(next) => point = next,
                None => return false,
            }
        }
        false
    }

    /// Whether a point belongs to skin that lies beyond all that the break touches.
    fn is_beyond(&self, skin: &Skin, point: u32, upper: bool) -> bool {
        let (first, last) = skin.about(point);
        first <= last
            && if upper {
                last as usize >= self.sides.above
            } else {
                (first as usize) < self.sides.below
            }
    }

    /// Whether a piece reaches beyond all that the break touches.
    fn reaches_beyond(&self, skin: &Skin, upper: bool) -> bool {
        if upper {
            self.sides.above < skin.order.len()
        } else {
            self.sides.below > 0
        }
    }

    /// Number that stands for all that lies beyond the break in [`Cut::joined_by_face`].
    fn beyond(&self) -> u32 {
        (self.points + self.vertices.len() + self.inside.len()) as u32
    }

    /// The vertices as the broken face joins them.
    fn joined_by_face(&self, grid: &FacetGrid) -> Unions {
        let mut joined = Unions::new(self.beyond() as usize + 1);
        // No skin lies over the facets of a region, so that the face joins all of them.
        let mut first_of = vec![NONE; grid.rims.len()];
        let first = (self.points + self.vertices.len()) as u32;
        for (vertex, &node) in (first..).zip(&self.nodes) {
            let region = grid.node_regions.get(node as usize);
            if let Some(known) = region.and_then(|&r| first_of.get_mut(r as usize)) {
                *known = vertex.min(*known);
                joined.attach(vertex, *known);
            }
        }
        for &corners in &self.cap {
            joined.join_triangle(corners);
        }
        joined
    }

    /// Joins the vertices of the whole triangles of a piece about the break, and those beyond the break to
    /// [`Cut::beyond`]; returns these triangles.
    fn join_whole(
        &self,
        solid: &Solid,
        skin: &Skin,
        upper: bool,
        joined: &mut Unions,
    ) -> Vec<WholeTriangle> {
        let side = if upper { Side::Upper } else { Side::Lower };
        let beyond = self.beyond();
        let (below, above) = (self.sides.below, self.sides.above);
        let whole: Vec<WholeTriangle> = (below..above)
            .filter(|&rank| self.sides.between[rank - below] == side && skin.is_limb(rank))
            .map(|rank| WholeTriangle {
                place: rank - below,
                points: solid.triangles[skin.order[rank] as usize],
            })
            .collect();
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        whole.iter().for_each(|w| joined.join_triangle(w.points));
        for p in (whole.iter().map(|w| w.points))
            .chain(parts.map(|s| s.corners))
            .flatten()
        {
            if (p as usize) < self.points && self.is_beyond(skin, p, upper) {
                joined.join(p, beyond);
            }
        }
        whole
    }

    /// Gives the parts of a piece that are not joined to the rest of it to the other one; returns how many. `joined` are
    /// the vertices as the broken face joins them.
    fn absorb(&mut self, solid: &Solid, skin: &Skin, upper: bool, mut joined: Unions) -> usize {
        let reaches_beyond = self.reaches_beyond(skin, upper);
        if self.join_split(solid, skin, upper, &mut joined) && reaches_beyond {
            return 0;
        }
        let whole = self.join_whole(solid, skin, upper, &mut joined);
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        let corners = (whole.iter().map(|w| w.points[0])).chain(parts.map(|s| s.corners[0]));
        let mut roots: Vec<u32> = corners.map(|v| joined.root(v)).collect();
        roots.sort_unstable();
        let all = || roots.chunk_by(|a, b| a == b);
        // What reaches beyond all that the break touches is the piece itself, however small.
        let main = if reaches_beyond {
            joined.root(self.beyond())
        } else {
            let largest = all().max_by_key(|part| (part.len(), std::cmp::Reverse(part[0])));
            largest.map_or(0, |part| part[0])
        };
        let chips = all().filter(|part| part[0] != main).count();
        if chips == 0 {
            return 0;
        }
        let mut is_chip = |v: u32| joined.root(v) != main;
        let other = if upper { Side::Lower } else { Side::Upper };
        for triangle in &whole {
            if is_chip(triangle.points[0]) {
                self.sides.between[triangle.place] = other;
            }
        }
        for s in self.skin.iter_mut().filter(|s| s.upper == upper) {
            if is_chip(s.corners[0]) {
                s.upper = !upper;
            }
        }
        let all = 0..self.cap.len() as u32;
        let dropped: Vec<u32> = all.filter(|&t| is_chip(self.cap[t as usize][0])).collect();
        self.drop_faces(&dropped);
        chips
    }

    /// Removes triangles of the broken face; their numbers ascend.
    fn drop_faces(&mut self, dropped: &[u32]) {
        let Some(&first) = dropped.first() else {
            return;
        };
        let mut passed = 0;
        for wall in &mut self.walls {
            passed += count_below(&dropped[passed..], *wall);
            *wall -= passed as u32;
        }
        let mut to = first as usize;
        let ends = dropped.iter().skip(1).map(|&d| d as usize);
        for (&from, end) in dropped.iter().zip(ends.chain([self.cap.len()])) {
            let moved = from as usize + 1..end;
            self.cap.copy_within(moved.clone(), to);
            self.faces.copy_within(moved.clone(), to);
            to += moved.len();
        }
        self.cap.truncate(to);
        self.faces.truncate(to);
    }
}

/// How many of ascending numbers lie below another, counted from the first on.
fn count_below(numbers: &[u32], number: u32) -> usize {
    numbers.iter().take_while(|&&n| n < number).count()
}
