//! Chips that lie about an opened break in a picture.

use glam::DVec3;
use greenstick::geometry::Context;
use greenstick::skin::view::BreakView;
use greenstick::{Break, BreakRequest, break_scene, built_in_branch};

#[test]
fn chips_lie_on_the_floor_beside_the_pieces_and_are_of_their_wood() {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break::default())
    };
    let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
    let wood = &broken.woods[0];
    let view = BreakView {
        stem: &wood.stem,
        material: wood.material,
        range: broken.report.face.range_m,
        width: wood.width,
        long_side: None,
    };
    let frame = wood.stem.grain.axis().frame(wood.stem.location);
    let (up, middle) = (frame.tangent, frame.origin);
    let level = middle.dot(up) - 0.2;
    let node = view.chips(&[up * level, up], up, true);
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
        assert!(off > 0.3 * wood.width, "{off} of {}", wood.width);
        let [x, y] = [grown.at(v)[0], grown.at(v)[1]].map(f64::from);
        assert!(x.hypot(y) < 1.1 * wood.stem.radius);
        assert_eq!(mesh.attributes["_FALLEN"].at(v), [1.0]);
    }
    assert!(high < 0.5 * wood.stem.radius, "{high}");
}
