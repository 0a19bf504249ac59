//! Snaps a mesh to the precision of files: detail too fine for `f32` is removed, and the mesh stays closed.

use super::touching::{inexact, part_touching};
use crate::Mesh;
use crate::components::Topology;
use rustc_hash::FxHashMap;

/// Rounds positions to `f32`, parts points without an edge between them that then coincide, removes triangles two of whose corners then coincide, and removes pairs of triangles that
/// then lie back to back if at least one of the two has the material `inner`; other such pairs come from the input and
/// stay. Each step leaves every edge with as many triangles in one direction as in the other, so a closed mesh stays
/// closed.
pub fn snap_to_f32(mesh: &mut Mesh, inner: u32) {
    snap_with_topology(mesh, inner);
}

/// As [`snap_to_f32`]. Returns the points and edges of the outcome.
pub(super) fn snap_with_topology(mesh: &mut Mesh, inner: u32) -> Topology {
    let before = inexact(mesh);
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    let mut topology = Topology::of(mesh);
    if part_touching(mesh, &topology.points, &before) {
        drop(topology);
        topology = Topology::of(mesh);
    }
    let topology = topology;
    let points = &topology.points;
    let corners = |i: usize| mesh.triangles[i].map(|v| points[v as usize]);
    let is_inner = |i: usize| mesh.material(i) == inner;
    let mut keep: Vec<bool> = (0..mesh.triangles.len())
        .map(|i| {
            let [a, b, c] = corners(i);
            a != b && b != c && c != a
        })
        .collect();
    // Triangles so far without one back to back with them, by their points.
    let mut single: FxHashMap<[u32; 3], Vec<(usize, bool)>> = FxHashMap::default();
    for i in triangles_with_equal_points(mesh, &topology) {
        let [a, b, c] = corners(i);
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        let forward = turns.contains(&sorted);
        let list = single.entry(sorted).or_default();
        match list
            .iter()
            .position(|o| o.1 != forward && (is_inner(o.0) || is_inner(i)))
        {
            Some(n) => {
                keep[list.swap_remove(n).0] = false;
                keep[i] = false;
            }
            None => list.push((i, forward)),
        }
    }
    if keep.iter().all(|k| *k) {
        return topology;
    }
    let mut kept = keep.iter();
    mesh.triangles.retain(|_| *kept.next().unwrap_or(&true));
    let mut kept = keep.iter();
    mesh.materials.retain(|_| *kept.next().unwrap_or(&true));
    Topology::of(mesh)
}

/// Returns the triangles that have all three points in common with another, ascending.
fn triangles_with_equal_points(mesh: &Mesh, topology: &Topology) -> Vec<usize> {
    let mut found = Vec::new();
    let mut across: Vec<(u32, usize)> = Vec::new();
    topology.edges.each(|_, uses| {
        // They share all edges; they are found at the edge of their two lowest points.
        across.clear();
        across.extend(uses.iter().filter_map(|u| {
            let third = mesh.triangles[u.triangle()][(u.edge() + 2) % 3];
            let third = topology.points[third as usize];
            (third > u.high()).then_some((third, u.triangle()))
        }));
        across.sort_unstable();
        let pairs = across.windows(2).filter(|w| w[0].0 == w[1].0);
        found.extend(pairs.flat_map(|w| [w[0].1, w[1].1]));
    });
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_feature_too_fine_for_files_is_removed_and_the_mesh_stays_closed() {
        // A tetrahedron with a spike far thinner than an f32 can tell apart.
        let at = [
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(0.0, 1.0, 0.0),
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::ZERO,
            DVec3::new(1e-12 + 1.0, 0.0, 0.0),
        ];
        let mut mesh = Mesh {
            positions: at.to_vec(),
            // Corner 0 is split in two along the edge to corner 3.
            triangles: vec![
                [4, 1, 2],
                [0, 3, 1],
                [4, 2, 3],
                [1, 3, 2],
                [4, 0, 1],
                [4, 3, 0],
            ],
            materials: vec![0; 6],
            ..Mesh::default()
        };
        assert!(mesh.check().closed);
        snap_to_f32(&mut mesh, 0);
        let report = mesh.check();
        assert_eq!((mesh.triangles.len(), report.degenerate_triangles), (4, 0));
        assert!(report.is_solid(), "{report}");
    }

    /// A tetrahedron on three points and a top.
    fn tetrahedron(base: [DVec3; 3], top: DVec3) -> Mesh {
        let [a, b, c] = base;
        let outwards = (b - a).cross(c - a).dot(top - a) > 0.0;
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        Mesh {
            positions: vec![a, b, c, top],
            triangles: triangles
                .map(|[a, b, c]| if outwards { [a, b, c] } else { [a, c, b] })
                .to_vec(),
            ..Mesh::default()
        }
    }

    #[test]
    fn sheets_that_rounding_brings_together_along_an_edge_are_parted() {
        // An edge of each lies along y, 1e-9 apart.
        let [p, q] = [DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0)];
        let off = DVec3::X * 1e-9;
        let left = tetrahedron([p, q, DVec3::new(0.0, 0.5, 0.0)], DVec3::new(0.3, 0.5, 1.0));
        let right = [p + off, q + off, DVec3::new(2.0, 0.5, 0.0)];
        let right = tetrahedron(right, DVec3::new(1.7, 0.5, 1.0));
        let mut both = left.clone();
        let count = both.positions.len() as u32;
        both.positions.extend(&right.positions);
        let shifted = right.triangles.iter().map(|t| t.map(|v| v + count));
        both.triangles.extend(shifted);
        assert!(both.check().is_solid());
        snap_to_f32(&mut both, 0);
        let report = both.check();
        assert!(
            report.is_solid() && report.non_manifold_vertices == 0,
            "{report}"
        );
        assert_eq!(both.positions[4].x, f64::from(1.0f32.next_up()));
    }
}
