//! When rods and bonds broke. Of the states of a film's frames only the changes are stored (Sutherland 2012 §5.3: an
//! association is dropped with its bond).

use super::error::RodSkinError;
use super::fracture_state::{FractureState, RodBreak, RodPart};
use super::wood::Wood;
use greenstick_fibre::Cause;
use greenstick_fibre::store::Frame;
use std::collections::BTreeMap;

/// A frame that is never reached: that of what never breaks.
pub(super) const NEVER: u32 = u32::MAX;

/// The parts that a bond holds together.
type BondParts = [Option<(RodPart, RodPart)>; 2];

/// The frame in which each rod and bond broke.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakHistory {
    /// Number of frames added.
    frames: u32,
    /// The first frame in which each vertex of the unbroken bundle is broken.
    break_frames: Vec<u32>,
    /// The parts that each bond of the unbroken bundle holds together, each with the frame from which on it does.
    bonded_parts: Vec<Vec<(u32, BondParts)>>,
    /// The state in the last frame.
    last: FractureState,
    /// Number of parts of rods, and of bonds, in the last frame.
    counts: (usize, usize),
}

impl BreakHistory {
    /// Starts the history of `wood`, which is unbroken before the first frame.
    pub fn new(wood: &Wood) -> Self {
        let last = FractureState::unbroken(wood);
        BreakHistory {
            frames: 0,
            break_frames: vec![NEVER; wood.bundle.vertices()],
            bonded_parts: last.bonded_parts.iter().map(|&h| vec![(0, h)]).collect(),
            last,
            counts: (wood.bundle.rods(), wood.bundle.bonds.len()),
        }
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] for a frame of another bundle.
    pub fn push_frame(
        &mut self,
        wood: &Wood,
        frame: &Frame,
        causes: &BTreeMap<u32, Cause>,
    ) -> Result<(), RodSkinError> {
        let number = self.frames;
        self.frames += 1;
        // Breaks are never undone: as many parts and bonds as before are the same ones.
        let counts = (frame.parent.len(), frame.bonds.len());
        if counts == self.counts {
            return Ok(());
        }
        self.counts = counts;
        let state = FractureState::from_frame(wood, frame, causes)?;
        for broken in state.breaks.iter().flatten() {
            let first = &mut self.break_frames[broken.vertex as usize];
            *first = (*first).min(number);
        }
        for (list, (now, before)) in (self.bonded_parts.iter_mut())
            .zip(state.bonded_parts.iter().zip(&self.last.bonded_parts))
        {
            if now != before {
                list.push((number, *now));
            }
        }
        self.last = state;
        Ok(())
    }

    /// Returns the state of fracture in the last frame.
    pub fn last_state(&self) -> &FractureState {
        &self.last
    }

    /// Returns the first frame in which a vertex is broken.
    pub(crate) fn break_frame(&self, vertex: u32) -> u32 {
        self.break_frames[vertex as usize]
    }

    /// Returns the part in `frame` that a part of the last frame belongs to. `breaks` are those of its rod.
    pub(super) fn part_in_frame(&self, breaks: &[RodBreak], part: RodPart, frame: u32) -> RodPart {
        let before = breaks.iter().take(usize::from(part));
        before
            .filter(|b| self.break_frame(b.vertex) <= frame)
            .count() as RodPart
    }

    /// Returns the first frame in which two parts of the last frame, of a rod with these breaks, are apart.
    pub(super) fn split_frame(&self, breaks: &[RodBreak], a: RodPart, b: RodPart) -> u32 {
        let between = usize::from(a.min(b))..usize::from(a.max(b)).min(breaks.len());
        let frames = breaks[between].iter().map(|b| self.break_frame(b.vertex));
        frames.min().unwrap_or(NEVER)
    }

    /// Returns the first frame in which a bond does not hold two parts together: one of the rod of its vertex, with the
    /// first `breaks`, and one of the rod of its edge, with the second.
    pub(super) fn release_frame(
        &self,
        bond: u32,
        breaks: [&[RodBreak]; 2],
        parts: (RodPart, RodPart),
    ) -> u32 {
        let list = &self.bonded_parts[bond as usize];
        let is_held = |frame: u32| {
            let now = list.partition_point(|c| c.0 <= frame).max(1) - 1;
            let then = (
                self.part_in_frame(breaks[0], parts.0, frame),
                self.part_in_frame(breaks[1], parts.1, frame),
            );
            list[now].1.contains(&Some(then))
        };
        let changes = list.iter().map(|c| c.0);
        let breaks = (breaks.iter().copied().flatten()).map(|b| self.break_frame(b.vertex));
        (changes.chain(breaks))
            .filter(|&frame| frame != NEVER && !is_held(frame))
            .min()
            .unwrap_or(NEVER)
    }
}
