//! Whether a mesh is closed, and the volume that it encloses: the part of an examination that every piece of a break needs.

use crate::Mesh;
use crate::components::{Topology, corner_points};

impl Mesh {
    /// Returns whether the mesh is closed, and its volume if it is closed and oriented: what [`Mesh::check`] finds of both,
    /// without the rest of the examination. The unit of the volume is that of the positions, cubed.
    ///
    /// ```
    /// use glam::DVec3;
    /// use greenstick_geometry::Mesh;
    ///
    /// let mut tetrahedron = Mesh {
    ///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
    ///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    ///     ..Mesh::default()
    /// };
    /// assert_eq!(tetrahedron.closed_volume(), (true, Some(1.0 / 6.0)));
    /// tetrahedron.triangles.pop();
    /// assert_eq!(tetrahedron.closed_volume(), (false, None));
    /// ```
    pub fn closed_volume(&self) -> (bool, Option<f64>) {
        self.closed_volume_with(&Topology::of(self))
    }

    /// As [`Mesh::closed_volume`], with the points and edges of the mesh.
    pub(crate) fn closed_volume_with(&self, topology: &Topology) -> (bool, Option<f64>) {
        if !self.positions.iter().all(|p| p.is_finite()) {
            let report = self.check_with(super::CheckOptions {
                self_intersections: false,
            });
            return (report.closed, report.volume_m3);
        }
        let points = &topology.points;
        let sound: Vec<usize> = (0..self.triangles.len())
            .filter(|&t| {
                corner_points(self.triangles[t], points)
                    .is_some_and(|[a, b, c]| a != b && b != c && c != a)
            })
            .collect();
        let Some(&first) = sound.first() else {
            return (false, None);
        };
        let (mut closed, mut oriented) = (true, true);
        topology.edges.each(|low, uses| {
            let [a, b] = uses else {
                closed = false;
                return;
            };
            let starts_low =
                [a, b].map(|u| points[self.triangles[u.triangle()][u.edge()] as usize] == low);
            oriented &= starts_low[0] != starts_low[1];
        });
        let origin = self.corners(first)[0];
        let volume = || {
            let sum: f64 = sound
                .iter()
                .map(|&t| {
                    let [a, b, c] = self.corners(t).map(|p| p - origin);
                    a.dot(b.cross(c))
                })
                .sum();
            sum / 6.0
        };
        (closed, (closed && oriented).then(volume))
    }
}
