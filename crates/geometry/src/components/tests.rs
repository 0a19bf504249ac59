use super::{NONE, NonManifoldEdge, Shells, number_points};
use crate::Mesh;
use glam::DVec3;

fn mesh(positions: &[[i32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        positions: positions
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    }
}

#[test]
fn points_are_numbered_as_the_mesh_defines_them() {
    let positions: Vec<DVec3> = (0..5000u64)
        .map(|i| {
            let k = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56;
            DVec3::new(
                (k % 7) as f64,
                (k % 5) as f64 - 2.0,
                if k % 2 == 0 { -0.0 } else { 0.0 },
            )
        })
        .collect();
    let mesh = Mesh {
        positions,
        ..Mesh::default()
    };
    assert_eq!(number_points(&mesh.positions), mesh.points());
    assert_eq!(number_points(&[]), (vec![], 0));
}

#[test]
fn shells_connect_across_seams_and_at_single_points() {
    // Two triangles along a seam of doubled vertices, one joined tip to tip, one alone, one that is out of range.
    let m = mesh(
        &[
            [0, 0, 0],
            [1, 0, 0],
            [0, 1, 0],
            [1, 0, 0],
            [0, 1, 0],
            [1, 1, 0],
            [2, 2, 0],
            [2, 1, 0],
            [9, 9, 9],
            [9, 9, 8],
            [9, 8, 9],
        ],
        &[[8, 9, 10], [0, 1, 2], [4, 3, 5], [5, 7, 6], [0, 1, 99]],
    );
    assert_eq!(
        m.shells(),
        Shells {
            of_triangle: vec![0, 1, 1, 1, NONE],
            count: 2
        }
    );
    let adjacency = m.adjacency();
    assert_eq!(adjacency.neighbours[1], [NONE, 2, NONE]);
    assert_eq!(adjacency.neighbours[2], [1, NONE, NONE]);
    assert_eq!(adjacency.neighbours[3], [NONE; 3]);
    assert!(adjacency.non_manifold.is_empty());
}

#[test]
fn an_edge_with_three_triangles_is_listed_and_connects_none() {
    let m = mesh(
        &[[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]],
        &[[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 0, 1]],
    );
    let adjacency = m.adjacency();
    assert_eq!(adjacency.neighbours, vec![[NONE; 3]; 4]);
    assert_eq!(
        adjacency.non_manifold,
        vec![NonManifoldEdge {
            points: [0, 1],
            triangles: vec![0, 1, 2]
        }]
    );
}
