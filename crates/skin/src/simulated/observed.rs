//! What a run shows of the breaks of its rods: where along the wood each lies, how far it gapes, and how the wood failed.

use crate::rods::{FractureState, RodPart, RodSkinError, Wood};
use glam::DVec3;
use greenstick_fibre::store::Frame;
use greenstick_fibre::{Cause, Event, EventKind};
use greenstick_fracture::heights::FailureMode;
use std::collections::BTreeMap;

/// A break of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RodEnd {
    /// The rod.
    pub rod: u32,
    /// The part of the rod before it; the next one follows it.
    pub part: RodPart,
    /// Length along the axis of the run's stem, m.
    pub along: f64,
    /// Distance of the two ends in the frame, m.
    pub opening: f64,
    /// How the wood failed: torn, crushed or twisted.
    pub mode: FailureMode,
}

/// The breaks of a frame of a run.
#[derive(Debug, Clone)]
pub struct ObservedRun {
    /// The state of fracture.
    pub state: FractureState,
    /// Time of the frame, s.
    pub time: f64,
    /// The breaks of each rod, along it.
    pub(super) breaks: Vec<Vec<RodEnd>>,
}

/// Why rods broke and when their edges yielded.
#[derive(Default)]
struct History {
    causes: BTreeMap<u32, Cause>,
    /// When each vertex broke, s.
    broke: BTreeMap<u32, f64>,
    /// When each edge, named by its first vertex, began to yield in compression, s.
    yielded: BTreeMap<u32, f64>,
}

impl History {
    /// The history until a time, s.
    fn until(events: &[Event], time: f64) -> History {
        let mut history = History::default();
        for event in events.iter().filter(|e| e.time <= time) {
            match event.kind {
                EventKind::RodBroke => {
                    history.causes.entry(event.vertex).or_insert(event.cause);
                    history.broke.entry(event.vertex).or_insert(event.time);
                }
                EventKind::RodYielded => {
                    history.yielded.entry(event.vertex).or_insert(event.time);
                }
                EventKind::BondBroke => {}
            }
        }
        history
    }

    /// How the wood failed where a rod broke at `vertex`. Fibres that had yielded in compression beside the break are
    /// kinked there, and tear short at last whatever parts them.
    fn mode(&self, vertex: u32) -> FailureMode {
        let broke = self.broke.get(&vertex).copied().unwrap_or(f64::INFINITY);
        let crushed = [vertex.wrapping_sub(1), vertex]
            .iter()
            .any(|edge| self.yielded.get(edge).is_some_and(|&time| time < broke));
        match self.causes.get(&vertex) {
            Some(Cause::Compression) => FailureMode::Crushed,
            _ if crushed => FailureMode::Crushed,
            Some(Cause::Torsion) => FailureMode::Twisted,
            _ => FailureMode::Torn,
        }
    }
}

impl ObservedRun {
    /// Reads a frame and the events up to it.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] for a frame of another bundle.
    pub fn new(wood: &Wood, frame: &Frame, events: &[Event]) -> Result<Self, RodSkinError> {
        let history = History::until(events, frame.time);
        let state = FractureState::from_frame(wood, frame, &history.causes)?;
        let mut breaks: Vec<Vec<RodEnd>> = vec![Vec::new(); wood.bundle.rods()];
        for rod in 1..frame.parent.len() {
            let parent = frame.parent[rod];
            if frame.parent[rod - 1] != parent {
                continue;
            }
            let after = frame.rod_offsets[rod] as usize;
            let of_rod = &mut breaks[parent as usize];
            of_rod.push(RodEnd {
                rod: parent,
                part: of_rod.len() as RodPart,
                along: break_length(wood, frame, parent as usize, after),
                opening: position(frame, after - 1).distance(position(frame, after)),
                mode: history.mode(frame.origin[after]),
            });
        }
        Ok(ObservedRun {
            state,
            time: frame.time,
            breaks,
        })
    }

    /// Number of rods that are broken at least once.
    pub fn broken_rods(&self) -> usize {
        self.state.broken_rods()
    }

    /// The part of a rod at a length along the axis, m.
    pub(crate) fn part_at(&self, rod: usize, along: f64) -> RodPart {
        self.breaks[rod].partition_point(|b| b.along <= along) as RodPart
    }
}

fn position(frame: &Frame, vertex: usize) -> DVec3 {
    DVec3::from_array(frame.position[vertex].map(f64::from))
}

/// The length along the axis (m) of the break between vertices `after − 1` and `after` of a frame, both of which were one
/// vertex of a rod. That vertex was moved along the wood to where the rod broke, at most by half an edge, so that its place
/// follows from the lengths of the edges beside it, which carry next to no load any more.
fn break_length(wood: &Wood, frame: &Frame, rod: usize, after: usize) -> f64 {
    let vertex = frame.origin[after] as usize;
    let range = wood.bundle.rod(rod);
    let own = wood.along[vertex];
    if vertex <= range.start || vertex + 1 >= range.end {
        return own;
    }
    let (before, beyond) = (wood.along[vertex - 1], wood.along[vertex + 1]);
    let length = |a: usize, b: usize| position(frame, a).distance(position(frame, b));
    // Both parts have an edge at least.
    let (a, b) = (length(after - 2, after - 1), length(after, after + 1));
    let along = before + (beyond - before) * a / (a + b).max(f64::MIN_POSITIVE);
    along.clamp(0.5 * (before + own), 0.5 * (own + beyond))
}
