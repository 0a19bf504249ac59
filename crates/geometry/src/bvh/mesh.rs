//! Queries of a tree over the triangles of a mesh: the nearest point and the first triangle along a ray.

use super::{Aabb, Bvh};
use crate::Mesh;
use glam::DVec3;

/// The point of a mesh nearest to a given one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Triangle that holds it.
    pub triangle: usize,
    /// The point.
    pub point: DVec3,
    /// Its distance.
    pub distance: f64,
}

impl Bvh {
    /// The tree over the triangles of `mesh`; triangles with indices out of range are never found.
    pub fn of_triangles(mesh: &Mesh) -> Self {
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

    /// The point of `mesh`, of whose triangles this is the tree, nearest to `point` within `limit`.
    pub fn nearest_on(&self, mesh: &Mesh, point: DVec3, limit: f64) -> Option<Nearest> {
        let (triangle, squared) = self.nearest(point, limit, |t| {
            closest_point_on_triangle(point, mesh.corners(t)).distance_squared(point)
        })?;
        let point = closest_point_on_triangle(point, mesh.corners(triangle));
        Some(Nearest {
            triangle,
            point,
            distance: squared.sqrt(),
        })
    }

    /// The first triangle of `mesh`, of whose triangles this is the tree, along a ray, and the place on the ray in
    /// lengths of `direction`, 0 to `limit`. Both sides of a triangle are hit.
    pub fn first_triangle(
        &self,
        mesh: &Mesh,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
    ) -> Option<(usize, f64)> {
        self.first_hit(origin, direction, limit, |t| {
            ray_triangle(origin, direction, mesh.corners(t))
        })
    }
}

/// The point of a triangle closest to `p` (Ericson 2005, Real-Time Collision Detection, §5.1.5).
pub fn closest_point_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

/// Where the line from `origin` along `direction` meets a triangle, in lengths of `direction` (negative behind the
/// origin). A line through an edge meets at least one of the triangles that share it (Woop, Benthin & Wald 2013,
/// Watertight Ray/Triangle Intersection).
pub fn ray_triangle(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> Option<f64> {
    let size = direction.abs();
    let z = if size.x > size.y && size.x > size.z {
        0
    } else if size.y > size.z {
        1
    } else {
        2
    };
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (sx, sy) = (direction[x] / direction[z], direction[y] / direction[z]);
    let [a, b, c] = corners.map(|p| {
        let d = p - origin;
        [d[x] - sx * d[z], d[y] - sy * d[z], d[z]]
    });
    // The same edge gives the same number, up to its sign, for both of its triangles.
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let sum = u + v + w;
    (sum != 0.0).then(|| (u * a[2] + v * b[2] + w * c[2]) / sum / direction[z])
}
