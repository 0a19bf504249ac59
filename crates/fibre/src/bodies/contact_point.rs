//! Contacts between rods' edges and bodies.

use crate::vectors::Vectors;
use glam::DVec3;

/// Largest number of points that are tested on an edge.
const MAX_POINTS_ON_EDGE: f64 = 8.0;
/// Overlap that is tolerated, in radii of a rod: it keeps resting contacts from flickering.
pub(super) const SLOP: f64 = 0.02;

/// One side of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    /// A rod's edge, at a parameter along it (0 to 1).
    Edge { edge: u32, t: f64 },
    /// A body.
    Body(u32),
}

/// A contact of an edge with a body or with another edge, or of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactPoint {
    pub first: Side,
    pub second: Side,
    /// Unit direction from the second side to the first.
    pub normal: DVec3,
    /// Where the impulse acts, m.
    pub point: DVec3,
    /// Overlap, m; negative for a gap that closes within the step.
    pub depth: f64,
    /// Overlap that is tolerated, m.
    pub slop: f64,
    /// Length of rod that the contact represents, m.
    pub length: f64,
}

/// The motion of a step, for contacts that occur within it.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepMotion<'a> {
    /// Velocities of vertices, m/s.
    pub velocity: &'a Vectors,
    /// Length of the step, s.
    pub step: f64,
}

/// Returns the number of points that are tested on an edge of this length (m) of a rod of this radius, without its end.
pub(super) fn points_on_edge(length: f64, radius: f64) -> f64 {
    (length / (2.0 * radius))
        .ceil()
        .clamp(1.0, MAX_POINTS_ON_EDGE)
}
