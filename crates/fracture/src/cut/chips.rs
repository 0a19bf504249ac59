//! Chips: parts of one piece that a cut leaves hanging in the air, given to the other piece.
//!
//! Where the skin bulges or the surface runs out steeply, a sliver of one piece may be joined to it nowhere. It is
//! joined to the other piece by the face between them; that face is taken out and the chip changes sides.

use super::{Cut, Side, Skin, Solid, root};
use crate::surface::NONE;

impl Cut {
    /// Gives every part of a piece that is not joined to the rest of it to the other piece. Returns how many.
    pub fn absorb_chips(&mut self, solid: &Solid) -> usize {
        if self.outlines <= 1 {
            return 0;
        }
        // The order of the skin does not depend on the reach of breaks.
        self.absorb_chips_again(solid, &Skin::new(solid, (0.0, 0.0)))
    }

    /// [`Cut::absorb_chips`] with the sorted `skin` of `solid`.
    pub fn absorb_chips_again(&mut self, solid: &Solid, skin: &Skin) -> usize {
        // One closed outline parts a stem in two and no more.
        if self.outlines <= 1 {
            return 0;
        }
        let count = (self.points + self.vertices.len() + self.inside.len()) as u32;
        if let Some(parent) = self.joined_near(count)
            && !self.hangs(solid, skin, false, parent.clone())
            && !self.hangs(solid, skin, true, parent)
        {
            return 0;
        }
        // What reaches beyond all that the break touches is the piece itself, however small: it all joins at the last.
        let mut parent = self.joined(count);
        let lower = self.absorb(solid, skin, false, parent.clone());
        if lower > 0 {
            parent = self.joined(count);
        }
        lower + self.absorb(solid, skin, true, parent)
    }

    /// Vertices up to number `count` as the broken face joins those of the skin; vertices that cannot matter to these
    /// are left out. `None` where the face has been changed since the cut.
    fn joined_near(&self, count: u32) -> Option<Vec<u32>> {
        let (joints, whole) = &self.joints;
        if *whole != self.cap.len() {
            return None;
        }
        let mut parent: Vec<u32> = (0..=count).collect();
        // A vertex of each region met so far.
        let mut regions: Vec<u32> = Vec::new();
        for &(t, region) in joints {
            let [a, b, c] = self.cap[t as usize];
            let mut also = a;
            if region != NONE {
                if regions.len() <= region as usize {
                    regions.resize(region as usize + 1, NONE);
                }
                let known = &mut regions[region as usize];
                if *known == NONE {
                    *known = a;
                }
                also = *known;
            }
            let first = root(&mut parent, a);
            for other in [b, c, also] {
                let other = root(&mut parent, other) as usize;
                parent[other] = first;
            }
        }
        Some(parent)
    }

    /// Vertices up to number `count` as the broken face joins them.
    fn joined(&self, count: u32) -> Vec<u32> {
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

    /// Whether part of a piece may be joined to the rest of it nowhere, given how the broken face joins vertices.
    fn hangs(&self, solid: &Solid, skin: &Skin, upper: bool, mut parent: Vec<u32>) -> bool {
        if !self.reaches(skin, upper) {
            return true;
        }
        let count = parent.len() as u32 - 1;
        let whole = self.join_skin(solid, skin, upper, &mut parent);
        let main = root(&mut parent, count);
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        (whole.iter().map(|w| w.1[0]))
            .chain(parts.map(|s| s.corners[0]))
            .any(|v| root(&mut parent, v) != main)
    }

    /// Whether a piece reaches beyond all that the break touches.
    fn reaches(&self, skin: &Skin, upper: bool) -> bool {
        if upper {
            self.sides.above < skin.order.len()
        } else {
            self.sides.below > 0
        }
    }

    /// Joins the vertices of a piece's skin; gives the whole triangles of the limb about the break in it, as place in
    /// [`super::Sides::between`] and points.
    fn join_skin(
        &self,
        solid: &Solid,
        skin: &Skin,
        upper: bool,
        parent: &mut [u32],
    ) -> Vec<(usize, [u32; 3])> {
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
        let beyond = |p: u32| {
            let (first, last) = skin.about(p);
            first <= last
                && if upper {
                    last as usize >= above
                } else {
                    (first as usize) < below
                }
        };
        // Triangles of the limb about the break on this side.
        let whole: Vec<(usize, [u32; 3])> = (below..above)
            .filter(|&rank| self.sides.between[rank - below] == side && skin.is_limb(rank))
            .map(|rank| (rank - below, solid.triangles[skin.order[rank] as usize]))
            .collect();
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        for corners in whole.iter().map(|w| w.1).chain(parts.map(|s| s.corners)) {
            join(corners);
            for p in corners {
                if (p as usize) < self.points && beyond(p) {
                    join([p, count, count]);
                }
            }
        }
        whole
    }

    fn absorb(&mut self, solid: &Solid, skin: &Skin, upper: bool, mut parent: Vec<u32>) -> usize {
        let count = parent.len() as u32 - 1;
        let whole = self.join_skin(solid, skin, upper, &mut parent);
        let mut sizes = vec![0u32; parent.len()];
        for &(_, t) in &whole {
            sizes[root(&mut parent, t[0]) as usize] += 1;
        }
        for s in self.skin.iter().filter(|s| s.upper == upper) {
            sizes[root(&mut parent, s.corners[0]) as usize] += 1;
        }
        let main = if self.reaches(skin, upper) {
            root(&mut parent, count) as usize
        } else {
            let largest = (0..sizes.len()).max_by_key(|&i| (sizes[i], std::cmp::Reverse(i)));
            largest.unwrap_or(0)
        };
        let chips = sizes
            .iter()
            .enumerate()
            .filter(|&(i, &n)| i != main && n > 0)
            .count();
        if chips == 0 {
            return 0;
        }
        let mut is_chip = |v: u32| root(&mut parent, v) as usize != main;
        let other = if upper { Side::Lower } else { Side::Upper };
        for &(i, t) in &whole {
            if is_chip(t[0]) {
                self.sides.between[i] = other;
            }
        }
        for s in self.skin.iter_mut().filter(|s| s.upper == upper) {
            if is_chip(s.corners[0]) {
                s.upper = !upper;
            }
        }
        let kept: Vec<bool> = self.cap.iter().map(|t| !is_chip(t[0])).collect();
        let mut before = vec![0u32];
        for k in &kept {
            before.push(before[before.len() - 1] + u32::from(*k));
        }
        self.walls.iter_mut().for_each(|w| *w = before[*w as usize]);
        let mut keep = kept.iter();
        self.cap.retain(|_| *keep.next().unwrap_or(&true));
        let mut keep = kept.iter();
        self.faces.retain(|_| *keep.next().unwrap_or(&true));
        chips
    }
}
