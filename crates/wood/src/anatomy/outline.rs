//! The outline of a section.

use super::smoothing::smooth;
use crate::polygon;
use glam::DVec2;

/// A section's outline in a frame's (x, y), m.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Closed loops: the stem's own first, counter-clockwise; then hollows in it and small parts of relief beside it.
    pub loops: Vec<Vec<DVec2>>,
    /// Number of loops, from the first on, that are the stem's own: one, but for a board with slots, which may fall into
    /// several.
    pub own_loops: usize,
    /// Area within the stem's own loops, m²; of a board without its hollows.
    pub area: f64,
    /// Centroid of the first loop, m.
    pub centroid: DVec2,
    /// Length of the stem's own loops, m.
    pub girth: f64,
    /// Part of the girth that was bridged across holes of the mesh, 0 to 1.
    pub bridged: f64,
    /// Root mean square distance of its points from those of the mesh, m: 0 unless it was smoothed.
    pub smoothing_residual: f64,
}

impl Outline {
    /// The points of the stem's own loops.
    pub fn points(&self) -> impl Iterator<Item = DVec2> {
        self.loops[..self.own_loops].iter().flatten().copied()
    }

    /// Whether one of the stem's own loops contains `p`.
    pub fn contains(&self, p: DVec2) -> bool {
        self.loops[..self.own_loops]
            .iter()
            .any(|l| polygon::contains(l, p))
    }

    /// The same with its first loop smoothed, by a root mean square distance of `tolerance` m at most; as it is where that
    /// cannot be.
    pub(super) fn smoothed(mut self, tolerance: f64) -> Self {
        let Some(smoothed) = smooth(&self.loops[0], tolerance) else {
            return self;
        };
        let bridged = self.bridged * self.girth;
        self.girth += polygon::perimeter(&smoothed.points) - polygon::perimeter(&self.loops[0]);
        self.bridged = bridged / self.girth;
        self.smoothing_residual = smoothed.residual;
        self.loops[0] = smoothed.points;
        self
    }

    /// Radius of the circle of the same area, m.
    pub fn mean_radius(&self) -> f64 {
        (self.area / std::f64::consts::PI).sqrt()
    }
}
