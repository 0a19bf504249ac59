//! The mesh that is cut, as pieces are made of it.

use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_wood::stem::LayeredGrain;

/// The mesh that was cut.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The mesh, in its node's coordinates.
    pub mesh: &'a Mesh,
    /// Point number of each vertex.
    pub points: &'a [u32],
    /// A vertex of each point.
    pub vertices: &'a [u32],
    /// Grain coordinates of each point, NaN off the limb.
    pub grain: &'a [DVec3],
    /// Grain coordinates to the node's.
    pub chart: &'a LayeredGrain,
}
