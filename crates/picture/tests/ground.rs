//! What pictures stand on.

use glam::{DAffine3, DQuat, DVec3};
use greenstick_geometry::{Context, Mesh};
use greenstick_picture::{
    CameraPlacement, Ground, Item, Picture, PictureOptions, PlainShader, render,
};

#[test]
fn the_ground_stays_where_it_is_while_what_lies_on_it_moves() {
    // A small tetrahedron.
    let mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    };
    let shader = PlainShader::uniform([0.1, 0.1, 0.1]);
    let at = |x: f64, ground_origin: Option<DVec3>| {
        let item = Item {
            mesh: &mesh,
            transform: DAffine3::from_scale_rotation_translation(
                DVec3::splat(0.02),
                DQuat::IDENTITY,
                DVec3::X * x,
            ),
            shader: &shader,
        };
        let options = PictureOptions {
            ground: Some(Ground::Bench),
            ground_origin,
            depth_of_field: Some(0.0),
            film_grain: Some(0.0),
            lens_softness: Some(0.0),
            camera: Some(CameraPlacement {
                place: DVec3::new(0.0, 0.5, 1.0),
                target: DVec3::ZERO,
                field_of_view: 25f64.to_radians(),
            }),
            width: 320,
            height: 240,
            ..PictureOptions::default()
        };
        render(&[item], &options, &Context::quiet()).unwrap()
    };
    // Of the lowest rows, far from the tetrahedron and its shadow, by how much they differ in the mean.
    let differ = |a: &Picture, b: &Picture| {
        let from = a.rgb.len() * 9 / 10;
        let both = a.rgb[from..].iter().zip(&b.rgb[from..]);
        let sum: u32 = both.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        f64::from(sum) / (a.rgb.len() - from) as f64
    };
    let here = Some(DVec3::ZERO);
    let steady = differ(&at(0.0, here), &at(0.03, here));
    let moved = differ(&at(0.0, None), &at(0.03, None));
    assert!(
        steady < 0.5 && moved > 3.0 * steady.max(0.2),
        "{steady} {moved}"
    );
}
