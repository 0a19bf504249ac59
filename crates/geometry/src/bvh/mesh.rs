//! Queries of a tree over the triangles of a mesh: the nearest point, and the first triangle along a ray.

use super::Aabb;
use super::tree::Bvh;
use crate::Mesh;
use crate::triangle::{closest_point_on_triangle, line_triangle_intersection};
use glam::DVec3;

/// The point of a mesh that is nearest to a given one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// Triangle that contains it.
    pub triangle: usize,
    /// The point.
    pub point: DVec3,
    /// Its distance.
    pub distance: f64,
}

impl Bvh {
    /// Builds the tree over the triangles of `mesh`. Triangles with indices out of range are never found.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let boxes: Vec<Aabb> = mesh
            .triangles
            .iter()
            .map(|t| match t.map(|i| mesh.positions.get(i as usize)) {
                [Some(&a), Some(&b), Some(&c)] => Aabb::around(&[a, b, c]),
                _ => Aabb::EMPTY,
            })
            .collect();
        Bvh::new(&boxes)
    }

    /// Finds the point of `mesh` nearest to `point` within the distance `limit`. The tree must be that of the mesh's
    /// triangles.
    pub fn nearest_on_mesh(&self, mesh: &Mesh, point: DVec3, limit: f64) -> Option<NearestPoint> {
        let (triangle, squared) = self.nearest(point, limit, |t| {
            closest_point_on_triangle(point, mesh.corners(t)).distance_squared(point)
        })?;
        let point = closest_point_on_triangle(point, mesh.corners(triangle));
        Some(NearestPoint {
            triangle,
            point,
            distance: squared.sqrt(),
        })
    }

    /// Finds the first triangle of `mesh` along a ray, and the ray parameter in lengths of `direction`, from 0 to
    /// `limit`. Triangles are hit from both sides. The tree must be that of the mesh's triangles.
    pub fn first_triangle(
        &self,
        mesh: &Mesh,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
    ) -> Option<(usize, f64)> {
        self.first_hit(origin, direction, limit, |t| {
            line_triangle_intersection(origin, direction, mesh.corners(t))
        })
    }
}
