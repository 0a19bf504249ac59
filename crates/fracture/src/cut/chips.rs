//! Chips: parts of one piece that a cut leaves hanging in the air, given to the other piece.
//!
//! Where the skin bulges or the surface runs out steeply, a sliver of one piece may be joined to it nowhere. It is
//! joined to the other piece by the face between them; that face is taken out and the chip changes sides.

use super::{Cut, Side, Solid, root};

impl Cut {
    /// Gives every part of a piece that is not joined to the rest of it to the other piece. Returns how many.
    pub fn absorb_chips(&mut self, solid: &Solid) -> usize {
        // One closed outline parts a stem in two and no more.
        if self.outlines <= 1 {
            return 0;
        }
        let mut moved = 0;
        for upper in [false, true] {
            moved += self.absorb(solid, upper);
        }
        moved
    }

    fn absorb(&mut self, solid: &Solid, upper: bool) -> usize {
        let side = if upper { Side::Upper } else { Side::Lower };
        let mut parent: Vec<u32> =
            (0..(self.points + self.vertices.len() + self.inside.len()) as u32).collect();
        let mut join = |t: [u32; 3]| {
            let a = root(&mut parent, t[0]);
            for other in [t[1], t[2]] {
                let b = root(&mut parent, other) as usize;
                parent[b] = a;
            }
        };
        let whole = |t: &&u32| self.sides[**t as usize] == side;
        solid
            .limb
            .iter()
            .filter(whole)
            .for_each(|&t| join(solid.triangles[t as usize]));
        self.skin
            .iter()
            .filter(|s| s.upper == upper)
            .for_each(|s| join(s.corners));
        self.cap.iter().for_each(|t| join(*t));
        let mut sizes = vec![0u64; parent.len()];
        // What reaches beyond all that the break touches is the piece itself, however small.
        const BEYOND: u64 = 1 << 40;
        for &t in solid.limb.iter().filter(whole) {
            let weight = if self.sides.is_beyond(t) { BEYOND } else { 1 };
            sizes[root(&mut parent, solid.triangles[t as usize][0]) as usize] += weight;
        }
        for s in self.skin.iter().filter(|s| s.upper == upper) {
            sizes[root(&mut parent, s.corners[0]) as usize] += 1;
        }
        let Some(main) = (0..sizes.len()).max_by_key(|&i| (sizes[i], std::cmp::Reverse(i))) else {
            return 0;
        };
        let chips = sizes
            .iter()
            .enumerate()
            .filter(|&(i, &n)| i != main && n > 0 && n < BEYOND)
            .count();
        if chips == 0 {
            return 0;
        }
        let mut is_chip = |v: u32| {
            let r = root(&mut parent, v) as usize;
            r != main && sizes[r] < BEYOND
        };
        for &t in solid.limb {
            if self.sides[t as usize] == side && is_chip(solid.triangles[t as usize][0]) {
                self.sides
                    .set(t, if upper { Side::Lower } else { Side::Upper });
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
