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
        self.absorb(solid, skin, false) + self.absorb(solid, skin, true)
    }

    /// Vertices up to number `count` as the broken face joins those of the skin, and for each region of the layout one
    /// of its vertices or [`NONE`]; vertices within regions are left out. `None` where the face is not known to be as
    /// it was cut.
    fn joined_near(&self, count: u32) -> Option<(Vec<u32>, Vec<u32>)> {
        let (joints, whole) = &self.joints;
        if *whole != self.cap.len() {
            return None;
        }
        let mut parent: Vec<u32> = (0..=count).collect();
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
        Some((parent, regions))
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

    /// Gives the parts of a piece that are not joined to the rest of it to the other one; how many.
    fn absorb(&mut self, solid: &Solid, skin: &Skin, upper: bool) -> usize {
        let count = (self.points + self.vertices.len() + self.inside.len()) as u32;
        let reaches = self.reaches(skin, upper);
        // What reaches beyond all that the break touches is the piece itself, however small: it all joins at the last.
        let near = self.joined_near(count).filter(|_| reaches);
        let near = near.and_then(|(mut parent, regions)| {
            let whole = self.join_skin(solid, skin, upper, &mut parent);
            let main = root(&mut parent, count);
            let mut known = regions.into_iter().filter(|&v| v != NONE);
            known
                .all(|v| root(&mut parent, v) == main)
                .then_some((parent, whole))
        });
        let by_joints = near.is_some();
        let (mut parent, whole) = near.unwrap_or_else(|| {
            let mut parent = self.joined(count);
            let whole = self.join_skin(solid, skin, upper, &mut parent);
            (parent, whole)
        });
        let parts = self.skin.iter().filter(|s| s.upper == upper);
        let corners = (whole.iter().map(|w| w.1[0])).chain(parts.map(|s| s.corners[0]));
        let mut roots: Vec<u32> = corners.map(|v| root(&mut parent, v)).collect();
        roots.sort_unstable();
        let all = || roots.chunk_by(|a, b| a == b);
        let main = if reaches {
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
        let mut dropped: Vec<u32> = if by_joints {
            let joints = self.joints.0.iter().map(|j| j.0);
            joints
                .filter(|&t| is_chip(self.cap[t as usize][0]))
                .collect()
        } else {
            let all = 0..self.cap.len() as u32;
            all.filter(|&t| is_chip(self.cap[t as usize][0])).collect()
        };
        dropped.sort_unstable();
        self.drop_faces(&dropped);
        if !by_joints {
            self.joints = (Vec::new(), usize::MAX);
        }
        chips
    }

    /// Takes triangles of the broken face out; their numbers ascend.
    fn drop_faces(&mut self, dropped: &[u32]) {
        let Some(&first) = dropped.first() else {
            return;
        };
        let mut passed = 0;
        for wall in &mut self.walls {
            passed += below(&dropped[passed..], *wall);
            *wall -= passed as u32;
        }
        passed = 0;
        self.joints.0.retain_mut(|joint| {
            passed += below(&dropped[passed..], joint.0);
            let stays = dropped.get(passed) != Some(&joint.0);
            joint.0 -= passed as u32;
            stays
        });
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
        self.joints.1 = to;
    }
}

/// How many of ascending numbers lie below another, looked for from the first on.
fn below(numbers: &[u32], number: u32) -> usize {
    numbers.iter().take_while(|&&n| n < number).count()
}
