//! The points and edges of a mesh, found once for everything that asks for them.

use super::{Edges, number_points};
use crate::Mesh;
use glam::DVec3;

/// The points and edges of a mesh.
pub(crate) struct Topology {
    /// Point of each vertex, as numbered by [`Mesh::points`].
    pub points: Vec<u32>,
    /// Number of points.
    pub count: usize,
    /// Edges between them.
    pub edges: Edges,
}

impl Topology {
    pub fn of(mesh: &Mesh) -> Self {
        let (points, count) = number_points(&mesh.positions);
        let edges = Edges::new(&mesh.triangles, &points, count);
        Topology {
            points,
            count,
            edges,
        }
    }

    /// Returns the positions of the points of its mesh.
    pub fn positions(&self, mesh: &Mesh) -> Vec<DVec3> {
        let mut positions = vec![DVec3::ZERO; self.count];
        for (&point, &position) in self.points.iter().zip(&mesh.positions) {
            positions[point as usize] = position;
        }
        positions
    }
}
