//! How the pieces of an opened break lie in a picture, and the chips about them.

use glam::DVec3;
use greenstick::fracture::recipe::apply_preset;
use greenstick::geometry::Context;
use greenstick::skin::finish::{NodeRole, PieceRole};
use greenstick::skin::view::BreakView;
use greenstick::{Break, BreakRequest, Broken, break_scene, built_in_branch};

/// Breaks the branch with a preset, the pieces a distance (m) apart, and says how a picture shows it.
fn with_view(preset: Option<&str>, separation: f64, then: impl Fn(&Broken, &BreakView)) {
    let mut request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break::default())
    };
    request.breaks[0].separation = separation;
    if let Some(preset) = preset {
        apply_preset(&mut request.breaks[0].recipe, preset).unwrap();
    }
    let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
    let wood = &broken.woods[0];
    let view = BreakView {
        stem: &wood.stem,
        material: wood.material,
        range: broken.report.face.range_m,
        width: wood.width,
        long_side: None,
    };
    then(&broken, &view);
}

#[test]
fn chips_lie_on_the_floor_beside_the_pieces_and_are_of_their_wood() {
    with_view(None, 0.0, |broken, view| {
        let frame = view.stem.grain.axis().frame(view.stem.location);
        let (up, middle) = (frame.tangent, frame.origin);
        let level = middle.dot(up) - 0.2;
        let motion = view.opening(&broken.scene, &broken.roles);
        let node = view.chips(&[up * level, up], up, Some(&motion));
        let mesh = &node.mesh;
        let (closed, volume) = mesh.closed_volume();
        assert!(closed && volume.is_some_and(|v| v > 0.0), "{volume:?}");
        let grown = &mesh.attributes["_GRAIN"];
        let mut high: f64 = 0.0;
        for (v, &p) in mesh.positions.iter().enumerate() {
            let height = p.dot(up) - level;
            assert!(height > -1e-12, "{height}");
            high = high.max(height);
            let flat = |q: DVec3| q - up * q.dot(up);
            let off = (flat(p) - flat(middle)).length();
            // Half a chip's length may reach under the bulge of the bark.
            assert!(off > 0.3 * view.width, "{off} of {}", view.width);
            let [x, y] = [grown.at(v)[0], grown.at(v)[1]].map(f64::from);
            assert!(x.hypot(y) < 1.1 * view.stem.radius);
        }
        assert!(high < 0.5 * view.stem.radius, "{high}");
    });
}

#[test]
fn opened_pieces_lie_clear_of_each_other_with_their_faces_to_the_camera() {
    for preset in [None, Some("brash"), Some("twist")] {
        with_view(preset, 0.01, |broken, view| {
            let motion = view.opening(&broken.scene, &broken.roles);
            let scene = view.opened(&broken.scene, &broken.roles, &motion);
            let piece = |role| {
                let at = (broken.roles.iter()).position(|&r| r == NodeRole::Piece(role));
                let node = &scene.nodes[at.unwrap()];
                node.mesh.transformed(&node.transform)
            };
            let [mut both, upper] = [PieceRole::Lower, PieceRole::Upper].map(piece);
            let first = both.positions.len() as u32;
            both.positions.extend(&upper.positions);
            let moved = upper.triangles.iter().map(|t| t.map(|v| v + first));
            both.triangles.extend(moved);
            both.materials.clear();
            both.attributes.clear();
            let crossing = both.check().self_intersections.unwrap().crossing;
            assert_eq!(crossing, 0, "{preset:?}");
            // Both faces look towards the camera, which looks down on the floor that both lie on.
            let sight = view.sight(None, &broken.scene, &broken.roles);
            let along = view.stem.grain.axis().frame(view.stem.location).tangent;
            for face in [along, motion.transform_vector3(-along)] {
                assert!(face.dot(sight.direction) < -0.4, "{preset:?}: {face}");
                assert!(face.dot(sight.up).abs() < 1e-9, "{preset:?}: {face}");
            }
        });
    }
}

#[test]
fn a_piece_that_hangs_lies_bent_and_its_break_opens_to_the_camera() {
    with_view(Some("green-stick"), 0.01, |broken, view| {
        let sight = view.sight(broken.hinge, &broken.scene, &broken.roles);
        let along = view.stem.grain.axis().frame(view.stem.location).tangent;
        let at = |role| {
            let at = (broken.roles.iter()).position(|&r| r == NodeRole::Piece(role));
            broken.scene.nodes[at.unwrap()].transform
        };
        let turned = at(PieceRole::Upper) * at(PieceRole::Lower).inverse();
        let upper = turned.transform_vector3(along);
        assert!(upper.dot(along) < 0.9, "it is bent: {upper}");
        for face in [along, -upper] {
            assert!(face.dot(sight.direction) < -0.1, "{face}");
            assert!(face.dot(sight.up).abs() < 1e-6, "{face}");
        }
    });
}
