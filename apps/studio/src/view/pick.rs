//! What of a scene lies under the pointer.

use crate::model::meshes::DrawnScene;
use glam::Vec3;

/// A point of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picked {
    /// Where it is, from the middle, m.
    pub position: Vec3,
    /// Its grain coordinates, m, where it is on the stem.
    pub grain: Option<Vec3>,
    /// Its piece.
    pub piece: usize,
}

/// Returns the nearest point of a scene on a ray; `only` looks through all pieces but one.
pub fn pick(scene: &DrawnScene, ray: (Vec3, Vec3), only: Option<usize>) -> Option<Picked> {
    let (origin, direction) = ray;
    let mut nearest: Option<(f32, Picked)> = None;
    for corners in scene.along(ray) {
        let v = corners.map(|i| &scene.vertices[i as usize]);
        let piece = v[0].zone_piece[1] as usize;
        if only.is_some_and(|only| piece != only) {
            continue;
        }
        let p = v.map(|v| Vec3::from_array(v.position));
        let Some((t, [u, w])) = meet(origin, direction, p) else {
            continue;
        };
        if nearest.as_ref().is_some_and(|n| n.0 <= t) {
            continue;
        }
        let grain = v.map(|v| Vec3::from_slice(&v.grain));
        let on_stem = v.iter().all(|v| v.grain[3] > 0.5);
        let picked = Picked {
            position: origin + direction * t,
            grain: on_stem.then(|| grain[0] * (1.0 - u - w) + grain[1] * u + grain[2] * w),
            piece,
        };
        nearest = Some((t, picked));
    }
    nearest.map(|n| n.1)
}

/// Where a ray meets a triangle (Möller and Trumbore 1997): its distance and the weights of the second and third corner.
fn meet(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<(f32, [f32; 2])> {
    let (e, f) = (b - a, c - a);
    let p = direction.cross(f);
    let determinant = e.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e);
    let w = direction.dot(q) / determinant;
    let t = f.dot(q) / determinant;
    (u >= 0.0 && w >= 0.0 && u + w <= 1.0 && t > 0.0).then_some((t, [u, w]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_where_it_is() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let met = meet(Vec3::new(0.25, 0.5, 2.0), -Vec3::Z, corners).unwrap();
        assert!((met.0 - 2.0).abs() < 1e-6 && (met.1[0] - 0.25).abs() < 1e-6);
        assert!(meet(Vec3::new(0.75, 0.5, 2.0), -Vec3::Z, corners).is_none());
        assert!(meet(Vec3::new(0.25, 0.5, 2.0), Vec3::Z, corners).is_none());
    }
}
