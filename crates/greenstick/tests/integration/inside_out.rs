//! Meshes whose triangles face inwards, and mirrored nodes, break as the same mesh does that faces outwards.

use glam::{DAffine3, DVec3};
use greenstick::geometry::{Context, Scene};
use greenstick::{BreakRequest, Broken, break_scene, built_in_branch};

fn broken(scene: Scene) -> Broken {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::default()
    };
    break_scene(scene, &request, &Context::quiet()).unwrap()
}

/// Volumes of both pieces in the world, m³; both must be closed.
fn volumes(broken: &Broken) -> [f64; 2] {
    [0, 1].map(|i| {
        let node = &broken.scene.nodes[i];
        let mesh = node.mesh.transformed(&node.transform);
        let report = mesh.check();
        assert!(report.closed && report.oriented, "{report}");
        mesh.volume()
    })
}

fn assert_alike(made: &Broken, plain: [f64; 2]) {
    for (made, plain) in volumes(made).into_iter().zip(plain) {
        assert!((made / plain - 1.0).abs() < 1e-9, "{made} {plain}");
    }
}

#[test]
fn a_mesh_inside_out_is_turned_over() {
    let plain = broken(built_in_branch());
    let turned_over = |b: &Broken| {
        let repairs = &b.report.input.repairs;
        repairs.iter().any(|note| note.contains("inside out"))
    };
    assert!(!turned_over(&plain));
    let mut scene = built_in_branch();
    for t in &mut scene.nodes[0].mesh_mut().triangles {
        t.swap(1, 2);
    }
    let made = broken(scene);
    assert!(turned_over(&made));
    assert_alike(&made, volumes(&plain));
}

#[test]
fn an_open_tube_inside_out_shows_wood() {
    // Without its ends the branch encloses nothing: only the faces tell outside from inside.
    let open = |inside_out: bool| {
        let mut scene = built_in_branch();
        let node = &mut scene.nodes[0];
        let mesh = node.mesh.transformed(&node.transform);
        let (low, high) = mesh.bounds().unwrap();
        let along = (high - low).max_position();
        let margin = 0.02 * (high - low)[along];
        let kept = (0..mesh.triangles.len()).filter(|&t| {
            let inner =
                |p: &DVec3| p[along] > low[along] + margin && p[along] < high[along] - margin;
            mesh.corners(t).iter().all(inner)
        });
        node.mesh_mut().triangles = kept.map(|t| mesh.triangles[t]).collect();
        node.mesh_mut().materials.clear();
        if inside_out {
            node.mesh_mut()
                .triangles
                .iter_mut()
                .for_each(|t| t.swap(1, 2));
        }
        broken(scene)
    };
    let [plain, turned] = [false, true].map(open);
    for i in [0, 1] {
        let [a, b] = [&plain, &turned].map(|b| b.scene.nodes[i].mesh.area());
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn a_mirrored_node_breaks_like_the_mesh_it_shows() {
    let plain = volumes(&broken(built_in_branch()));
    let mut scene = built_in_branch();
    let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let node = &mut scene.nodes[0];
    node.mesh = node.mesh.transformed(&mirror).into();
    node.transform *= mirror;
    assert_alike(&broken(scene), plain);
}
