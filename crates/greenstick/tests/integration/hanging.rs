//! Pieces that hang on, as that of a greenstick fracture.

use glam::{DAffine3, DVec3};
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::wood::primitive;
use greenstick::{Break, BreakRequest, break_scene, built_in_branch};

fn board() -> Scene {
    Scene {
        nodes: vec![Node {
            name: "board".into(),
            transform: DAffine3::from_axis_angle(DVec3::X, 0.4),
            mesh: primitive::board(0.5, 0.06, 0.02).into(),
            parent: None,
            is_detail: false,
        }],
        ..Scene::default()
    }
}

/// Both pieces where they lie, as one mesh.
fn together(nodes: &[Node]) -> Mesh {
    let mut all = Mesh::default();
    for node in nodes {
        let first = all.positions.len() as u32;
        let places = node.mesh.positions.iter();
        all.positions
            .extend(places.map(|&p| node.transform.transform_point3(p)));
        let triangles = node.mesh.triangles.iter();
        all.triangles
            .extend(triangles.map(|t| t.map(|v| v + first)));
    }
    all
}

#[test]
fn a_hanging_piece_touches_the_other_nowhere_and_stays_at_its_hinge() {
    for (scene, seed, angle) in [
        (built_in_branch(), 1, 68.0),
        (built_in_branch(), 2, 25.0),
        (board(), 3, 50.0),
    ] {
        let settings = [format!("seed={seed}"), format!("hang={angle}")];
        let settings = settings.each_ref().map(String::as_str);
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(&["green-stick"], None, &settings).unwrap(),
                ..Break::default()
            })
        };
        let broken = break_scene(scene, &request, &Context::quiet()).unwrap();
        let nodes = &broken.scene.nodes[..2];
        let own = |n: &Node| n.mesh.check().self_intersections.map_or(0, |s| s.crossing);
        let all = together(nodes).check().self_intersections.unwrap();
        assert_eq!(all.crossing, own(&nodes[0]) + own(&nodes[1]), "seed {seed}");

        // The upper piece turned by the angle, and its side at the hinge is still there.
        let hang = broken.report.hang.as_ref().unwrap();
        assert!(hang.angle_degrees >= angle && hang.clear_degrees <= hang.angle_degrees);
        let hinge = DVec3::from_array(hang.hinge_m);
        let nearest = |n: &Node| {
            let places = n.mesh.positions.iter();
            places
                .map(|&p| {
                    let off = n.transform.transform_point3(p) - hinge;
                    off.reject_from(DVec3::from_array(hang.axis)).length()
                })
                .fold(f64::INFINITY, f64::min)
        };
        let radius = broken.woods[0].stem.radius;
        for node in nodes {
            assert!(nearest(node) < 0.15 * radius, "{} is away", node.name);
        }
        let turn = (nodes[1].transform * nodes[0].transform.inverse()).matrix3;
        let cosine = (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0) / 2.0;
        assert!((cosine - hang.angle_degrees.to_radians().cos()).abs() < 1e-9);
    }
}
