//! Faces as rods meet them.

use crate::rods::{BreakHistory, RodPart, Wood};
use crate::simulated::{ObservedRun, SimulatedFracture};

/// The faces of the wood, as rods meet them.
pub(super) struct RodFaces<'a> {
    pub wood: &'a Wood<'a>,
    pub run: &'a ObservedRun,
    pub fractures: &'a [SimulatedFracture],
    /// For each face and rod, the length along the axis at which the rod passes it, m.
    lengths: Vec<Vec<f64>>,
    /// For each face and rod, the part of the rod before its break there; `None` where it is whole.
    parts_before: Vec<Vec<Option<RodPart>>>,
}

impl<'a> RodFaces<'a> {
    pub fn new(
        wood: &'a Wood<'a>,
        run: &'a ObservedRun,
        fractures: &'a [SimulatedFracture],
    ) -> Self {
        let lengths = fractures.iter().map(|f| f.lengths_of_rods(wood)).collect();
        RodFaces {
            wood,
            run,
            fractures,
            lengths,
            parts_before: (fractures.iter().map(|f| f.parts_before().collect())).collect(),
        }
    }

    /// The number of faces.
    pub fn count(&self) -> usize {
        self.fractures.len()
    }

    /// The rod whose cell is nearest to a point of the section.
    pub fn rod_at(&self, at: glam::DVec2) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (rod, cell) in self.wood.cells.iter().enumerate() {
            let far = cell.centroid.distance_squared(at);
            if far < least {
                (best, least) = (rod, far);
            }
        }
        best
    }

    /// The length along the axis at which a rod passes a face, m.
    pub fn length(&self, face: usize, rod: usize) -> f64 {
        self.lengths[face][rod]
    }

    /// The least and the greatest length along the axis at which rods pass a face, m.
    pub fn range(&self, face: usize) -> (f64, f64) {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let lengths = self.lengths[face].iter();
        lengths.fold(none, |(low, high), &l| (low.min(l), high.max(l)))
    }

    /// The part of a rod before its break in a face; `None` where it is whole there.
    pub fn part_before(&self, face: usize, rod: usize) -> Option<RodPart> {
        self.parts_before[face][rod]
    }

    /// The face nearest to a length along the axis, m.
    pub fn nearest(&self, along: f64) -> Option<usize> {
        let off = |face: &usize| (self.mean_length(*face) - along).abs();
        (0..self.count()).min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The first frame in which a rod is broken in each face.
    pub fn openings(&self, history: &BreakHistory) -> Vec<u32> {
        let opening = |face: usize| {
            let rods = 0..self.wood.bundle.rods();
            let frames = rods.map(|rod| self.break_frame(face, rod, history));
            frames.min().unwrap_or(u32::MAX)
        };
        (0..self.count()).map(opening).collect()
    }

    /// The first frame in which a rod is broken in a face; [`u32::MAX`] for one that is whole there.
    pub fn break_frame(&self, face: usize, rod: usize, history: &BreakHistory) -> u32 {
        let vertex = self.broken_vertex(face, rod);
        vertex.map_or(u32::MAX, |vertex| history.break_frame(vertex))
    }

    /// The mean length along the axis at which rods pass a face, m.
    pub fn mean_length(&self, face: usize) -> f64 {
        let all = &self.lengths[face];
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }

    /// The vertex of the unbroken bundle at which a rod broke in a face; `None` for one that is whole there.
    pub fn broken_vertex(&self, face: usize, rod: usize) -> Option<u32> {
        let part = self.parts_before[face][rod]?;
        let of_rod = &self.run.state.breaks[rod];
        of_rod.get(usize::from(part)).map(|b| b.vertex)
    }
}
