//! When rods and bonds broke: the partings of a film's frames, of which only the changes are kept (Sutherland 2012
//! §5.3: an association is dropped with its bond).

use super::parting::{Part, Parting, RodBreak};
use super::{RodSkinError, Wood};
use greenstick_fibre::Cause;
use greenstick_fibre::store::Frame;
use std::collections::BTreeMap;

/// A frame that is never reached: what holds on.
pub(super) const NEVER: u32 = u32::MAX;

type Holds = [Option<(Part, Part)>; 2];

/// What broke in which frame.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// Frames seen.
    frames: u32,
    /// The first frame in which each vertex of the unbroken bundle is broken.
    broke: Vec<u32>,
    /// For each bond of the unbroken bundle what it holds from which frame on, but for what it holds in the first.
    holds: Vec<Vec<(u32, Holds)>>,
    last: Parting,
    /// Numbers of parts of rods and of bonds in the last frame.
    counts: (usize, usize),
}

impl History {
    /// Of `wood`, unbroken before the first frame.
    pub fn new(wood: &Wood) -> Self {
        let last = Parting::none(wood);
        History {
            frames: 0,
            broke: vec![NEVER; wood.bundle.vertices()],
            holds: last.holds.iter().map(|&h| vec![(0, h)]).collect(),
            last,
            counts: (wood.bundle.rods(), wood.bundle.bonds.len()),
        }
    }

    /// Looks at the next frame.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] for a frame of another bundle.
    pub fn see(
        &mut self,
        wood: &Wood,
        frame: &Frame,
        causes: &BTreeMap<u32, Cause>,
    ) -> Result<(), RodSkinError> {
        let number = self.frames;
        self.frames += 1;
        // Rods only part, and bonds are lost but by rods that part: as many of both are the same ones.
        let counts = (frame.parent.len(), frame.bonds.len());
        if counts == self.counts {
            return Ok(());
        }
        self.counts = counts;
        let parting = Parting::of(wood, frame, causes)?;
        for broken in parting.breaks.iter().flatten() {
            let known = &mut self.broke[broken.vertex as usize];
            *known = (*known).min(number);
        }
        for (list, (now, before)) in
            (self.holds.iter_mut()).zip(parting.holds.iter().zip(&self.last.holds))
        {
            if now != before {
                list.push((number, *now));
            }
        }
        self.last = parting;
        Ok(())
    }

    /// What is broken in the last frame seen.
    pub fn last(&self) -> &Parting {
        &self.last
    }

    /// The first frame in which a vertex is broken.
    pub(super) fn broke(&self, vertex: u32) -> u32 {
        self.broke[vertex as usize]
    }

    /// The part that a part of the last frame's is of in `frame`: breaks of the rod before it that there are then.
    pub(super) fn part(&self, breaks: &[RodBreak], part: Part, frame: u32) -> Part {
        let before = breaks.iter().take(usize::from(part));
        before.filter(|b| self.broke(b.vertex) <= frame).count() as Part
    }

    /// The first frame in which two of the last frame's parts of a rod, with these breaks, are not one.
    pub(super) fn parted(&self, breaks: &[RodBreak], a: Part, b: Part) -> u32 {
        let between = usize::from(a.min(b))..usize::from(a.max(b)).min(breaks.len());
        let frames = breaks[between].iter().map(|b| self.broke(b.vertex));
        frames.min().unwrap_or(NEVER)
    }

    /// The first frame in which a bond does not hold two parts together: of the rod of its vertex with these breaks, and
    /// of the rod of its edge.
    pub(super) fn let_go(&self, bond: u32, breaks: [&[RodBreak]; 2], parts: (Part, Part)) -> u32 {
        let list = &self.holds[bond as usize];
        let held = |frame: u32| {
            let now = list.partition_point(|c| c.0 <= frame).max(1) - 1;
            let then = (
                self.part(breaks[0], parts.0, frame),
                self.part(breaks[1], parts.1, frame),
            );
            list[now].1.contains(&Some(then))
        };
        let changes = list.iter().map(|c| c.0);
        let breaks = (breaks.iter().copied().flatten()).map(|b| self.broke(b.vertex));
        (changes.chain(breaks))
            .filter(|&frame| frame != NEVER && !held(frame))
            .min()
            .unwrap_or(NEVER)
    }
}
