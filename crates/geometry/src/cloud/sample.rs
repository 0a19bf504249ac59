//! Points on the surface of meshes.

use super::PointCloud;
use crate::Mesh;
use glam::DVec3;

/// Samples meshes: their vertices, and on every triangle a number of points in proportion to its area, one at least. There
/// are about `count` points on triangles where triangles are fewer; of thin boards narrow sides show, too. Normals are those
/// of the triangles.
pub fn sample_meshes(meshes: &[Mesh], count: f64) -> PointCloud {
    let mut cloud = PointCloud::default();
    let area_per_point = meshes.iter().map(Mesh::area).sum::<f64>() / count;
    for mesh in meshes {
        let mut vertex_normals = vec![DVec3::ZERO; mesh.positions.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let across = (b - a).cross(c - a);
            for &v in triangle {
                vertex_normals[v as usize] += across;
            }
            let normal = across.normalize_or_zero();
            let points = 0.5 * across.length() / area_per_point;
            for i in 0..points.round().clamp(1.0, count) as u32 {
                let (u, v) = low_discrepancy_point(i);
                cloud.points.push(a + (b - a) * u + (c - a) * v);
                cloud.normals.push(normal);
            }
        }
        // Vertices that no triangle has are no surface.
        for (p, n) in mesh.positions.iter().zip(vertex_normals) {
            if let Some(normal) = n.try_normalize() {
                cloud.points.push(*p);
                cloud.normals.push(normal);
            }
        }
    }
    cloud
}

/// Point `i` of a sequence that covers a triangle evenly, along two of its sides: a sequence of low discrepancy (Roberts
/// 2018) in the square, folded at its diagonal. The first is the middle.
fn low_discrepancy_point(i: u32) -> (f64, f64) {
    const STEPS: (f64, f64) = (0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    let third = 1.0 / 3.0;
    let [u, v] = [STEPS.0, STEPS.1].map(|step| (third + step * f64::from(i)).fract());
    if u + v <= 1.0 {
        (u, v)
    } else {
        (1.0 - u, 1.0 - v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_cover_triangles_by_their_area() {
        let mesh = Mesh {
            positions: [(0.0, 0.0), (3.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let cloud = sample_meshes(&[mesh], 4000.0);
        assert_eq!(cloud.points.len(), 4004);
        assert!(cloud.normals.iter().all(|n| *n == DVec3::Z));
        let right = cloud.points.iter().filter(|p| p.x > 0.0).count();
        assert!((2998..=3002).contains(&right), "{right}");
        // As many in each half of the larger triangle, parted at its median.
        let near = cloud
            .points
            .iter()
            .filter(|p| p.x > 0.0 && p.x < 3.0 * p.y)
            .count();
        assert!((1450..=1550).contains(&near), "{near}");
    }
}
