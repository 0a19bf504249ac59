//! Chips: parts of one piece that a cut leaves hanging in the air, given to the other piece.
//!
//! Where the skin bulges or the surface runs out steeply, a sliver of one piece may not be joined to the rest of it. It is
//! joined to the other piece by the face between them; that face is removed and the chip changes sides.

use super::{Cut, Side, Skin, Solid, root};
use crate::surface::NONE;

/// A whole triangle of the limb about the break.
struct WholeTriangle {
    /// Its place in [`super::Sides::between`].
    place: usize,
    /// Its points.
    points: [u32; 3],
}

impl Cut {
    /// Gives every part of a piece that is not joined to the rest of it to the other piece. `skin` is the sorted skin of
    /// `solid`. Returns how many.
    pub fn absorb_chips(&mut self, solid: &Solid, skin: &Skin) -> usize {
        // One closed outline parts a stem in two and no more.
        if self.outlines <= 1 {
            return 0;
        }
        let mut chips = 0;
        for upper in [false, true] {
            if !self.is_surely_joined(solid, skin, upper) {
                chips += self.absorb(solid, skin, upper);
            }
        }
        chips
    }

    /// Whether all of a piece is joined to what lies beyond the break, as far as a short look can tell: from every closed
    /// line of the outline the skin leads there over whole triangles that lie farther and farther from the break. Each
    /// part of a piece has such a line on its border.
    fn is_surely_joined(&self, solid: &Solid, skin: &Skin, upper: bool) -> bool {
        if !self.reaches_beyond(skin, upper) {
            return false;
        }
        let mut joined = vec![false; self.outlines];
        let mut open = self.outlines;
        for part in self.skin.iter().filter(|s| s.upper == upper) {
            let line = part.corners.iter().find_map(|&c| {
                let vertex = (c as usize).checked_sub(self.points)?;
                let line = *self.outline_of.get(vertex)?;
                (line != NONE && !joined[line as usize]).then_some(line as usize)
            });
            let Some(line) = line else { continue };
            let mut points = part.corners.iter().filter(|&&c| (c as usize) < self.points);
            if points.any(|&p| self.leads_beyond(p, solid, skin, upper)) {
                joined[line] = true;
                open -= 1;
                if open == 0 {
                    return true;
                }
            }
        }
        false
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

    /// Vertices up to number `count` as the broken face joins them.
    fn joined_by_face(&self, count: u32) -> Vec<u32> {
        let mut parent: Vec<u32> = (0..=count).collect();
        for &[a, b, c] in &self.cap {
            // Triangles of a cell and walls follow each other with vertices that are mostly joined already.
            let mut first = parent[a as usize];
            if parent[b as usize] == first && parent[c as usize] == first {
                continue;
            }
            first = root(&mut parent, a);
            for other in [b, c] {
                let other = root(&mut parent, other) as usize;
                parent[other] = first;
            }
        }
        parent
    }

    /// Joins the vertices of a piece's skin, and those beyond the break to the last of `parent`; returns the whole
    /// triangles of the limb about the break in it.
    fn join_skin(
        &self,
        solid: &Solid,
        skin: &Skin,
        upper: bool,
        parent: &mut [u32],
    ) -> Vec<WholeTriangle> {
        let side = if upper { Side::Upper } else { Side::Lower };
        let count = parent.len() as u32 - 1;
        let mut join = |t: [u32; 3]| {
            let a = root(parent, t[0]);
            for other in [t[1], t[2]] {
                let b = root(parent, other) as usize;
                parent[b] = a;
            }
        };
        let (below, above) = (self.sides.below, self.sides.above);
        let whole: Vec<WholeTriangle> = (below..above)
            .filter(|&rank| self.sides.between[rank - below] == side && skin.is_limb(rank))
            .map(|rank| WholeTriangle {
                place: rank - below,
                points: solid.triangles[skin.order[rank] as usize],
            })
            .collect();
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        for corners in (whole.iter().map(|w| w.points)).chain(parts.map(|s| s.corners)) {
            join(corners);
            for p in corners {
                if (p as usize) < self.points && self.is_beyond(skin, p, upper) {
                    join([p, count, count]);
                }
            }
        }
        whole
    }

    /// Gives the parts of a piece that are not joined to the rest of it to the other one; returns how many.
    fn absorb(&mut self, solid: &Solid, skin: &Skin, upper: bool) -> usize {
        let count = (self.points + self.vertices.len() + self.inside.len()) as u32;
        let mut parent = self.joined_by_face(count);
        let whole = self.join_skin(solid, skin, upper, &mut parent);
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        let corners = (whole.iter().map(|w| w.points[0])).chain(parts.map(|s| s.corners[0]));
        let mut roots: Vec<u32> = corners.map(|v| root(&mut parent, v)).collect();
        roots.sort_unstable();
        let all = || roots.chunk_by(|a, b| a == b);
        // What reaches beyond all that the break touches is the piece itself, however small.
        let main = if self.reaches_beyond(skin, upper) {
            root(&mut parent, count)
        } else {
            let largest = all().max_by_key(|part| (part.len(), std::cmp::Reverse(part[0])));
            largest.map_or(0, |part| part[0])
        };
        let chips = all().filter(|part| part[0] != main).count();
        if chips == 0 {
            return 0;
        }
        let mut is_chip = |v: u32| root(&mut parent, v) != main;
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
