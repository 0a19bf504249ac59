//! Bark of limbs: its coordinates run along them.

use glam::{DAffine3, Vec2, Vec3};
use greenstick::geometry::{Node, Scene};
use greenstick::wood::primitive;
use greenstick_studio::model::meshes::{DrawnScene, Vertex};

/// A limb of a scene in which nothing is broken.
fn limb(radius: f64, turn: DAffine3) -> DrawnScene {
    let mesh = primitive::cylinder_of(radius, 1.0, 24, 40);
    DrawnScene::unbroken(&Scene {
        nodes: vec![Node::new("limb", turn, mesh)],
        ..Scene::default()
    })
}

#[test]
fn bark_runs_along_a_limb_however_it_lies_and_is_finer_on_thin_ones() {
    let turns = [0.0, 0.7, 1.57].map(DAffine3::from_rotation_x);
    for (turn, radius) in turns.into_iter().zip([0.03, 0.03, 0.006]) {
        let scene = limb(radius, turn);
        // Its longest extent is its axis.
        let positions = || scene.vertices.iter().map(|v| Vec3::from_array(v.position));
        let far = positions().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let axis = far.unwrap().normalize();
        // A fifth of the radius of a stem of 3 cm, to the power of 0.8.
        let fine = if radius < 0.02 { 3.624 } else { 1.0 };
        let place = |v: &Vertex| Vec3::from_array(v.position).dot(axis);
        let near: Vec<&Vertex> = scene
            .vertices
            .iter()
            .filter(|v| place(v).abs() < 0.3)
            .collect();
        assert!(near.len() > 100);
        let first = near[0];
        let ways = near
            .iter()
            .map(|v| (v.grain[2] - first.grain[2], place(v) - place(first)));
        let sign = ways.clone().map(|(a, b)| a * b).sum::<f32>().signum();
        for (v, (length, along)) in near.iter().zip(ways) {
            let off = length - along * sign * fine;
            assert!(off.abs() < 0.02 * fine, "{off} at radius {radius}");
            assert!((v.grain[3] * fine / 0.4 - 1.0).abs() < 0.1, "{:?}", v.grain);
            let about = Vec2::new(v.grain[0], v.grain[1]).length();
            let round = radius as f32 * fine;
            assert!((about / round - 1.0).abs() < 0.15, "{about} {round}");
        }
    }
}
