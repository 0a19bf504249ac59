//! The volume that two solids share, by parallel rays.

use crate::{Aabb, Mesh};
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// Most rays along either axis; where there would be more, they are farther apart.
const MAX_RAYS: f64 = 600.0;
/// Where rays pass, in distances from the side of a region: no round part, so that few meet an edge.
const OFFSET: f64 = 0.437;
/// Least length of a ray in both solids that counts, in distances of rays: solids that fit touch, and rounding must not show.
const LEAST_LENGTH: f64 = 0.01;

/// Rays at equal distances that measure solids.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use greenstick_geometry::overlap::ParallelRays;
/// use greenstick_geometry::Mesh;
///
/// let tetrahedron = Mesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
///     ..Mesh::default()
/// };
/// let rays = ParallelRays { axes: [DVec3::X, DVec3::Y, DVec3::Z], spacing: 0.002 };
/// // Moved by half an edge, it shares a tetrahedron half as large with itself.
/// let moved = DAffine3::from_translation(DVec3::X * 0.5);
/// let region = rays.bounds(tetrahedron.positions.iter().copied());
/// let shared = rays.shared_volume([(&tetrahedron, &DAffine3::IDENTITY), (&tetrahedron, &moved)], &region);
/// assert!((shared - 1.0 / 48.0).abs() < 1e-4, "{shared}");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelRays {
    /// Unit vectors at right angles: along the rays, and two across them.
    pub axes: [DVec3; 3],
    /// Distance of neighbouring rays, in the unit of positions.
    pub spacing: f64,
}

/// A place at which a ray enters or leaves a solid.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    ray: u32,
    /// How far along the ray.
    at: f64,
    /// Which of the solids.
    solid: u8,
    /// By how much its winding number grows.
    winding: i8,
}

impl ParallelRays {
    /// Returns the box along the axes that holds points.
    pub fn bounds(&self, points: impl Iterator<Item = DVec3>) -> Aabb {
        let [x, y, z] = self.axes;
        points.fold(Aabb::EMPTY, |all, p| {
            all.join(&Aabb::around(&[DVec3::new(x.dot(p), y.dot(p), z.dot(p))]))
        })
    }

    /// Returns the volume that two closed meshes, each moved by its transform, share in a region, a box along the axes; in the unit
    /// of positions cubed. Where both only touch, it is zero. Rays that do not leave a mesh as often as they enter it do not count.
    pub fn shared_volume(&self, solids: [(&Mesh, &DAffine3); 2], region: &Aabb) -> f64 {
        let size = region.high - region.low;
        if !(size.min_element() > 0.0 && size.is_finite()) {
            return 0.0;
        }
        let spacing = self.spacing.max(size.y.max(size.z) / MAX_RAYS);
        let grid = Grid {
            low: region.low,
            spacing,
            count: [size.y, size.z].map(|l| (l / spacing).ceil() as i64),
        };
        let mut crossings = Vec::new();
        let [x, y, z] = self.axes;
        let onto_axes = DAffine3::from_mat3(DMat3::from_cols(x, y, z).transpose());
        for (solid, (mesh, transform)) in solids.into_iter().enumerate() {
            let map = onto_axes * *transform;
            for t in 0..mesh.triangles.len() {
                let corners = mesh.corners(t).map(|p| map.transform_point3(p));
                grid.each_crossing(corners, |ray, at, winding| {
                    crossings.push(Crossing {
                        ray,
                        at,
                        solid: solid as u8,
                        winding,
                    });
                });
            }
        }
        crossings.sort_unstable_by(|a, b| a.ray.cmp(&b.ray).then(a.at.total_cmp(&b.at)));
        let least = LEAST_LENGTH * spacing;
        let rays = crossings.chunk_by(|a, b| a.ray == b.ray);
        let length: f64 = rays.map(|ray| shared_length(ray, region, least)).sum();
        length * spacing * spacing
    }
}

/// The length (at least `least` each time) for which a ray, by its crossings in order, is within both solids and the region.
fn shared_length(crossings: &[Crossing], region: &Aabb, least: f64) -> f64 {
    let mut winding = [0; 2];
    let (mut sum, mut from) = (0.0, f64::NEG_INFINITY);
    for crossing in crossings {
        if winding[0] != 0 && winding[1] != 0 {
            let length = crossing.at.min(region.high.x) - from.max(region.low.x);
            if length > least {
                sum += length;
            }
        }
        winding[usize::from(crossing.solid)] += i32::from(crossing.winding);
        from = crossing.at;
    }
    if winding == [0; 2] { sum } else { 0.0 }
}

/// Rays on a grid.
struct Grid {
    low: DVec3,
    spacing: f64,
    /// Along both axes across the rays.
    count: [i64; 2],
}

impl Grid {
    /// Visits the rays that pass through a triangle: the number of each, where on it, and the sign of the turn.
    fn each_crossing(&self, corners: [DVec3; 3], mut visit: impl FnMut(u32, f64, i8)) {
        let flat = corners.map(|p| DVec2::new(p.y - self.low.y, p.z - self.low.z));
        let (low, high) = (
            flat[0].min(flat[1]).min(flat[2]),
            flat[0].max(flat[1]).max(flat[2]),
        );
        let first = |x: f64| ((x / self.spacing - OFFSET).ceil() as i64).max(0);
        let last = |x: f64, count: i64| ((x / self.spacing - OFFSET).floor() as i64).min(count - 1);
        for i in first(low.x)..=last(high.x, self.count[0]) {
            for j in first(low.y)..=last(high.y, self.count[1]) {
                let at = (DVec2::new(i as f64, j as f64) + OFFSET) * self.spacing;
                let [a, b, c] = flat.map(|p| p - at);
                let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
                let turn = match weights {
                    w if w.iter().all(|&w| w > 0.0) => 1,
                    w if w.iter().all(|&w| w < 0.0) => -1,
                    _ => continue,
                };
                let sum: f64 = weights.iter().sum();
                let along: f64 = (0..3).map(|k| weights[k] * corners[k].x).sum();
                visit((i * self.count[1] + j) as u32, along / sum, turn);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    /// The box between two corners, closed.
    fn cuboid(low: DVec3, high: DVec3) -> Mesh {
        let corner = |i: u32| {
            let pick = |bit: u32, l: f64, h: f64| if i >> bit & 1 == 0 { l } else { h };
            DVec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            )
        };
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let mesh = Mesh {
            positions: (0..8).map(corner).collect(),
            triangles: faces
                .iter()
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
            ..Mesh::default()
        };
        assert!(mesh.closed_volume().1.is_some_and(|v| v > 0.0));
        mesh
    }

    fn rays() -> ParallelRays {
        let turn = DQuat::from_rotation_y(0.3) * DQuat::from_rotation_x(0.2);
        ParallelRays {
            axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|v| turn * v),
            spacing: 0.004,
        }
    }

    fn shared(one: &Mesh, other: &Mesh, moved: &DAffine3) -> f64 {
        let rays = rays();
        let region = rays.bounds(one.positions.iter().copied());
        rays.shared_volume([(one, &DAffine3::IDENTITY), (other, moved)], &region)
    }

    #[test]
    fn boxes_share_their_intersection_and_share_nothing_where_they_touch() {
        let one = cuboid(DVec3::ZERO, DVec3::ONE);
        let other = cuboid(DVec3::ZERO, DVec3::new(0.5, 1.0, 2.0));
        let moved = DAffine3::from_translation(DVec3::new(0.7, 0.2, -0.5));
        let expected = 0.3 * 0.8 * 1.0;
        let found = shared(&one, &other, &moved);
        assert!((found - expected).abs() < 2e-3 * expected, "{found}");
        let beside = DAffine3::from_translation(DVec3::X);
        assert_eq!(shared(&one, &other, &beside), 0.0);
        // The same box inside out is the same box.
        let mut turned = one.clone();
        turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let inside_out = shared(&turned, &other, &moved);
        assert!((inside_out - found).abs() < 1e-12);
    }

    #[test]
    fn open_meshes_and_empty_regions_share_nothing() {
        let one = cuboid(DVec3::ZERO, DVec3::ONE);
        let mut open = one.clone();
        open.triangles.truncate(2);
        assert_eq!(shared(&one, &open, &DAffine3::IDENTITY), 0.0);
        let identity = DAffine3::IDENTITY;
        let solids = [(&one, &identity), (&one, &identity)];
        let nothing = rays().shared_volume(solids, &Aabb::EMPTY);
        assert_eq!(nothing, 0.0);
    }
}
