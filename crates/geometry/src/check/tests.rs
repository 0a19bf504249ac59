//! Meshes with one known defect each.

use crate::Mesh;
use glam::{DAffine3, DVec3};

/// The unit cube, every face with its own four vertices.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in 0..2 {
            let start = mesh.positions.len() as u32;
            for corner in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let mut p = DVec3::ZERO;
                p[axis] = f64::from(side);
                p[(axis + 1) % 3] = f64::from(corner[0]);
                p[(axis + 2) % 3] = f64::from(corner[1]);
                mesh.positions.push(p);
            }
            let faces = [[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| i + start));
            mesh.triangles
                .extend(faces.map(|[a, b, c]| if side == 1 { [a, b, c] } else { [a, c, b] }));
        }
    }
    mesh
}

fn moved(mesh: &Mesh, by: [f64; 3]) -> Mesh {
    mesh.transformed(&DAffine3::from_translation(DVec3::from(by)))
}

fn joined(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let start = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles
            .extend(mesh.triangles.iter().map(|t| t.map(|i| i + start)));
    }
    all
}

#[test]
fn a_cube_with_seams_is_a_solid() {
    let report = cube().check();
    assert!(report.is_solid(), "{report}");
    assert_eq!(
        (
            report.vertices,
            report.points,
            report.triangles,
            report.components
        ),
        (24, 8, 12, 1)
    );
    assert!(
        (report.volume_m3.unwrap() - 1.0).abs() < 1e-15 && (report.area_m2 - 6.0).abs() < 1e-15
    );
    let text = report.to_string();
    assert!(
        text.contains("area 6 m², volume 1 m³") && text.contains("no self-intersections"),
        "{text}"
    );
}

#[test]
fn each_defect_is_found_alone() {
    let none = cube().check();
    let mut open = cube();
    open.triangles.truncate(10);
    let report = open.check();
    assert_eq!(
        (report.boundary_edges, report.boundary_loops, report.closed),
        (4, 1, false)
    );
    assert!(report.oriented && report.volume_m3.is_none());

    let mut turned = cube();
    turned.triangles[3].swap(0, 1);
    let report = turned.check();
    assert_eq!(
        (report.misoriented_edges, report.closed, report.oriented),
        (3, true, false)
    );
    assert!(report.volume_m3.is_none());

    let mut inside_out = cube();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let report = inside_out.check();
    assert!(report.oriented && report.volume_m3 == Some(-1.0) && !report.is_solid());

    let report = joined(&[cube(), moved(&cube(), [1.0, 1.0, 1.0])]).check();
    assert_eq!(
        (report.non_manifold_vertices, report.non_manifold_edges),
        (1, 0)
    );
    assert_eq!(report.non_manifold_vertex_places, vec![[1.0; 3]]);
    assert_eq!(report.components, 1);

    let report = joined(&[cube(), moved(&cube(), [1.0, 1.0, 0.0])]).check();
    assert_eq!(
        (report.non_manifold_edges, report.closed, report.oriented),
        (1, false, true)
    );
    assert_eq!(report.non_manifold_edge_places, vec![[1.0, 1.0, 0.5]]);

    let mut doubled = cube();
    doubled.triangles.push([1, 2, 0]);
    doubled.triangles.push([0, 2, 1]);
    let report = doubled.check();
    assert_eq!(
        (report.duplicate_triangles, report.non_manifold_edges),
        (2, 3)
    );

    let mut degenerate = cube();
    degenerate.triangles.push([0, 1, 1]);
    let report = degenerate.check();
    assert_eq!(report.degenerate_triangles, 1);
    assert_eq!((report.closed, report.volume_m3), (true, none.volume_m3));

    let mut broken = cube();
    broken.triangles.push([0, 1, 24]);
    broken.positions.push(DVec3::new(f64::NAN, 0.0, 0.0));
    broken.triangles.push([0, 1, 25]);
    let report = broken.check();
    assert_eq!(
        (report.non_finite_positions, report.indices_out_of_range),
        (1, 1)
    );
    assert!(report.closed && !report.is_solid());
    assert!(!Mesh::default().check().closed);
}

#[test]
fn crossing_and_touching_triangles_are_distinguished() {
    let report = joined(&[cube(), moved(&cube(), [0.5, 0.25, 0.125])]).check();
    let found = report.self_intersections.clone().unwrap();
    assert!(found.crossing > 0 && found.touching == 0, "{report}");
    assert!(
        found
            .crossing_places
            .iter()
            .all(|p| p.iter().all(|x| (0.125..=1.5).contains(x)))
    );
    assert!(report.closed && !report.is_solid());
    // A cube whose corner rests on the other's face, and cubes that rest face on face.
    let tip = cube().transformed(
        &(DAffine3::from_translation(DVec3::new(0.3, 0.4, 1.0))
            * DAffine3::from_mat3(glam::DMat3::from_cols_array(&[
                1., -1., 1., 1., 1., 1., -1., 0., 2.,
            ]))),
    );
    let found = joined(&[cube(), tip]).check().self_intersections.unwrap();
    assert!(found.crossing == 0 && found.touching >= 1);
    let found = joined(&[cube(), moved(&cube(), [0.5, 0.5, 1.0])])
        .check()
        .self_intersections
        .unwrap();
    assert!(found.crossing > 0);
    let apart = joined(&[cube(), moved(&cube(), [0.5, 0.5, 1.0 + f64::EPSILON])]).check();
    assert!(apart.is_solid() && apart.components == 2);
}

#[test]
fn a_mesh_whose_triangles_all_cross_is_checked_up_to_a_million_pairs() {
    // Each stands across the z axis, turned against the others.
    let mut mesh = Mesh::default();
    for k in 0..1500u32 {
        let (s, c) = (f64::from(k) * 0.002).sin_cos();
        mesh.positions.extend([
            DVec3::new(c, s, -1.0),
            DVec3::new(-c, -s, -1.0),
            DVec3::new(0.1 * c, 0.1 * s, 1.0),
        ]);
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let report = mesh.check();
    let found = report.self_intersections.as_ref().unwrap();
    assert!(found.incomplete && found.crossing + found.touching == super::MAX_CONTACTS);
    assert!(report.to_string().contains("was ended early"));
}
