use super::simplify;
use crate::{Attribute, Context, Mesh};
use glam::DVec3;

/// A log along z. Its side has texture coordinates with a seam; its end faces have another material and vertices of their
/// own.
fn log(rings: usize, around: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let mut coordinates = Vec::new();
    let place = |z: f64, k: usize, radius: f64| {
        let angle = std::f64::consts::TAU * (k % around) as f64 / around as f64;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    for i in 0..rings {
        for k in 0..=around {
            let share = i as f64 / (rings - 1) as f64;
            // Thinner towards the top, and not straight.
            let at = place(4.0 * share, k, 0.3 - 0.1 * share);
            mesh.positions.push(at + DVec3::X * (0.4 * share * share));
            coordinates.extend([k as f32 / around as f32, share as f32]);
        }
    }
    let at = |i: usize, k: usize| (i * (around + 1) + k) as u32;
    for i in 0..rings - 1 {
        for k in 0..around {
            mesh.triangles
                .push([at(i, k), at(i, k + 1), at(i + 1, k + 1)]);
            mesh.triangles
                .push([at(i, k), at(i + 1, k + 1), at(i + 1, k)]);
        }
    }
    mesh.materials = vec![1; mesh.triangles.len()];
    for (ring, up) in [(0, false), (rings - 1, true)] {
        let first = mesh.positions.len() as u32;
        for k in 0..around {
            mesh.positions.push(mesh.positions[at(ring, k) as usize]);
            coordinates.extend([0.5, 0.5]);
        }
        for k in 1..around as u32 - 1 {
            let [b, c] = if up { [k, k + 1] } else { [k + 1, k] };
            mesh.triangles.push([first, first + b, first + c]);
        }
    }
    mesh.materials.resize(mesh.triangles.len(), 0);
    let attribute = Attribute {
        width: 2,
        data: coordinates,
    };
    mesh.attributes.insert("TEXCOORD_0".into(), attribute);
    mesh
}

fn area_of(mesh: &Mesh, material: u32) -> f64 {
    let triangles = (0..mesh.triangles.len()).filter(|&t| mesh.material(t) == material);
    triangles
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum()
}

#[test]
fn a_log_keeps_its_volume_materials_and_seams() {
    let mesh = log(81, 48);
    assert!(mesh.check().is_solid());
    for share in [0.5, 0.25, 0.1] {
        let target = (share * mesh.triangles.len() as f64) as usize;
        let simplified = simplify(&mesh, &[], target, &Context::quiet()).unwrap();
        let report = simplified.mesh.check();
        assert!(report.closed && report.oriented);
        assert_eq!(
            report.non_manifold_vertices + report.degenerate_triangles,
            0
        );
        assert!(simplified.mesh.triangles.len() <= target);
        assert!((simplified.mesh.volume() / mesh.volume() - 1.0).abs() < 0.01);
        // A twentieth of the thinner end.
        assert!(simplified.error < 0.01, "{share}: {}", simplified.error);
        for material in [0, 1] {
            let [old, new] = [&mesh, &simplified.mesh].map(|m| area_of(m, material));
            assert!((new / old - 1.0).abs() < 0.02, "{material}: {old} {new}");
        }
        // Vertices are some of those before, with what they had; no triangle reaches over the seam.
        let coordinates = &simplified.mesh.attributes["TEXCOORD_0"];
        for (new, &old) in simplified.original_vertices.iter().enumerate() {
            assert_eq!(simplified.mesh.positions[new], mesh.positions[old as usize]);
            assert_eq!(
                coordinates.at(new),
                mesh.attributes["TEXCOORD_0"].at(old as usize)
            );
        }
        let covered: f64 = (simplified.mesh.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|v| coordinates.at(v as usize));
                let [a, b, c] = [a, b, c].map(|x| [f64::from(x[0]), f64::from(x[1])]);
                0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
            })
            .sum();
        assert!((covered - 1.0).abs() < 1e-5, "{covered}");
    }
}

#[test]
fn thin_pieces_keep_their_volume() {
    // A splinter of six sides, as few triangles as it may have: its volume is what keeps it from going.
    let mut mesh = log(200, 6);
    mesh.positions
        .iter_mut()
        .for_each(|p| *p *= DVec3::new(0.02, 0.02, 1.0));
    let simplified = simplify(&mesh, &[], 1, &Context::quiet()).unwrap();
    assert!(simplified.mesh.check().closed && simplified.mesh.triangles.len() < 300);
    let ratio = simplified.mesh.volume() / mesh.volume();
    assert!((ratio - 1.0).abs() < 0.01 + 1e-12, "{ratio}");
}

#[test]
fn bends_in_another_pose_keep_their_vertices() {
    let mesh = log(81, 24);
    // The pose has a kink in the middle, where the mesh at rest has none.
    let kinked: Vec<DVec3> = (mesh.positions.iter())
        .map(|p| {
            let over = (p.z - 2.0).max(0.0);
            *p + DVec3::Y * over
        })
        .collect();
    let target = mesh.triangles.len() / 8;
    let context = Context::quiet();
    let blind = simplify(&mesh, &[], target, &context).unwrap();
    let seeing = simplify(&mesh, std::slice::from_ref(&kinked), target, &context).unwrap();
    // The exact distance of the pose's points from the surface.
    let off = |simplified: &super::Simplified| {
        super::largest_distance(
            &kinked,
            &simplified.mesh,
            &simplified.original_vertices,
            &context,
        )
        .unwrap()
    };
    assert!(off(&seeing) <= seeing.error);
    assert!(
        off(&seeing) < 0.7 * off(&blind),
        "{} {}",
        off(&seeing),
        off(&blind)
    );
}

#[test]
fn a_mesh_that_cannot_be_simplified_is_returned() {
    let context = Context::quiet();
    let mesh = log(3, 4);
    let least = simplify(&mesh, &[], 0, &context).unwrap();
    assert!(least.mesh.check().closed && least.mesh.triangles.len() >= 4);
    let mut wrong = mesh.clone();
    wrong.positions[3].z = f64::NAN;
    let same = simplify(&wrong, &[], 2, &context).unwrap();
    assert_eq!(same.original_vertices.len(), wrong.positions.len());
    assert_eq!(
        simplify(&Mesh::default(), &[], 2, &context)
            .unwrap()
            .original_vertices,
        []
    );
}
