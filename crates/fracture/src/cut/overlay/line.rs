//! Cutting a triangle of the skin over a surface without steps.
//!
//! There the outline crosses nearly every triangle along one line, from side to side. It is followed from facet to facet,
//! and the triangle's corners left and right of it complete the two loops: no edge within the triangle is ever made.

use super::clips::{Clips, Corner, Slot, Support};
use super::outline::Overlay;
use super::{End, Place, Placed, Segment, SplitMemory};
use crate::surface::NONE;

impl Overlay<'_> {
    /// Splits a triangle that the surface cuts along one line. Returns `false` where it cuts otherwise; nothing but
    /// vertices has been made then.
    pub(super) fn split_along_line(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        clips: &Clips,
        parts: (u32, u32),
        memory: &mut SplitMemory,
    ) -> bool {
        let tops = self.tops.len();
        let skin = self.skin.len();
        let done = match self.cut_parts((triangle, corners), clips, parts, memory) {
            Some(upper) => self.fill_beside_line((triangle, corners), upper, memory),
            None => false,
        };
        if !done {
            self.tops.truncate(tops);
            self.skin.truncate(skin);
        }
        done
    }

    /// Lists the outline's segments over the facets. Returns for each corner whether it lies above the surface.
    fn cut_parts(
        &mut self,
        (triangle, corners): (u32, [u32; 3]),
        clips: &Clips,
        parts: (u32, u32),
        memory: &mut SplitMemory,
    ) -> Option<[bool; 3]> {
        memory.line.clear();
        let mut upper = [None; 3];
        let parts = &clips.parts[parts.0 as usize..parts.1 as usize];
        let mut above = memory.above.as_slice();
        for (part, place) in parts.iter().zip(&memory.places) {
            let slots = &clips.slots[part.slots.0 as usize..part.slots.1 as usize];
            let heights;
            (heights, above) = above.split_at(slots.len());
            for (slot, &height) in slots.iter().zip(heights) {
                if slot.beyond == NONE && matches!(slot.support, Support::Facet(_)) {
                    return None;
                }
                if let Corner::Point(i) = slot.corner {
                    upper[usize::from(i)] = Some(height > 0.0);
                }
            }
            if *place != Place::Split {
                continue;
            }
            let (mut entry, mut exit) = (None, None);
            let placed = |j: usize, id: u32, slot: Slot| Placed {
                id,
                above: heights[j],
                slot,
                agreed: true,
            };
            for j in 0..slots.len() {
                let k = if j + 1 == slots.len() { 0 } else { j + 1 };
                let rises = heights[k] > 0.0;
                if (heights[j] > 0.0) == rises {
                    continue;
                }
                let end = if rises { &mut entry } else { &mut exit };
                if end.is_some() {
                    return None;
                }
                let a = placed(j, self.corner(corners, slots[j], clips), slots[j]);
                let b = placed(k, self.corner(corners, slots[k], clips), slots[k]);
                *end = Some(End {
                    id: self.cut((triangle, corners), part.facet, a, b, clips),
                    support: slots[j].support,
                });
            }
            let (from, to) = (exit?, entry?);
            self.tops.push((part.facet, [from.id, to.id]));
            memory.line.push(Segment { from, to });
        }
        Some([upper[0]?, upper[1]?, upper[2]?])
    }

    /// Orders the segments to one line across the triangle and fills what lies on either side of it; `upper` says which
    /// corners lie above the surface.
    fn fill_beside_line(
        &mut self,
        (triangle, corners): (u32, [u32; 3]),
        upper: [bool; 3],
        memory: &mut SplitMemory,
    ) -> bool {
        let line = &mut memory.line;
        let side = |end: End| match end.support {
            Support::Skin(side) => Some(usize::from(side)),
            Support::Facet(_) => None,
        };
        let Some(start) = line.iter().position(|s| side(s.from).is_some()) else {
            return false;
        };
        line.swap(0, start);
        for i in 1..line.len() {
            let at = line[i - 1].to.id;
            let Some(next) = line[i..].iter().position(|s| s.from.id == at) else {
                return false;
            };
            line.swap(i, i + next);
        }
        let (Some(first), Some(last)) = (side(line[0].from), side(line[line.len() - 1].to)) else {
            return false;
        };
        for piece in [false, true] {
            let ring = memory.join.ring();
            // The upper piece has the line as it runs, the lower one runs back.
            let (from, to) = if piece { (last, first) } else { (first, last) };
            ring.push(line[0].from.id);
            ring.extend(line.iter().map(|s| s.to.id));
            if !piece {
                ring.reverse();
            }
            // A line that comes back to its own side has all corners on one side of it.
            let count = match (to + 3 - from) % 3 {
                0 if upper[from] == piece => 3,
                count => count,
            };
            for i in 1..=count {
                let corner = (from + i) % 3;
                if upper[corner] != piece {
                    return false;
                }
                ring.push(corners[corner]);
            }
            if !self.fill_ring((triangle, corners), piece, &mut memory.join) {
                return false;
            }
        }
        true
    }
}
