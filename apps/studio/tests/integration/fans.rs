//! The handles of the ductile zone and of the layers: dragged on the wood, undone as one step, saved.

use crate::common::{Folder, drag, exported, saved_and_broken, settle, studio};
use eframe::egui::{Key, Modifiers, Vec2};
use egui_kittest::Harness;
use greenstick::RequestFile;
use greenstick::fracture::parameters::BreakParameters;
use greenstick_studio::model::fan::{FanKind, FanPart};
use greenstick_studio::ui::studio::Studio;

fn face(harness: &Harness<'static, Studio>) -> BreakParameters {
    harness.state().project.file.common.recipe.face.clone()
}

fn choose(harness: &mut Harness<'static, Studio>, kind: FanKind) {
    while harness.state().fans.kind != Some(kind) {
        harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
        harness.step();
    }
}

/// Drags a part to where a place of the face is, and returns how far from there its dot then is, points.
fn drag_to(
    harness: &mut Harness<'static, Studio>,
    part: FanPart,
    (rho, degrees): (f32, f64),
) -> f32 {
    let from = harness.state_mut().fan_dot(part).unwrap();
    let to = harness
        .state_mut()
        .face_place_at(rho, degrees.to_radians() as f32)
        .unwrap();
    drag(harness, from, to);
    assert!(harness.state().messages().is_empty());
    harness.state_mut().fan_dot(part).unwrap().distance(to)
}

#[test]
fn the_ductile_zone_is_dragged_on_the_wood() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    // From above all of the rim is seen.
    harness.key_press(Key::Num7);
    harness.step();
    choose(&mut harness, FanKind::Ductile);
    harness.step();
    let first = face(&harness).ductile;
    let (start, end) = (
        first.direction - 0.5 * first.angle,
        first.direction + 0.5 * first.angle,
    );
    drag_to(&mut harness, FanPart::End, (1.0, end + 40.0));
    let wide = face(&harness).ductile;
    assert!((wide.angle - first.angle - 40.0).abs() < 4.0, "{wide:?}");
    // The other edge has not moved.
    let still = (wide.direction - 0.5 * wide.angle - start).rem_euclid(360.0);
    assert!(!(0.06..=359.94).contains(&still), "{still}");
    drag_to(&mut harness, FanPart::Inner, (0.75, wide.direction));
    let thin = face(&harness).ductile;
    assert!((thin.rings - 0.25).abs() < 0.06, "{thin:?}");
    assert_eq!((thin.direction, thin.angle), (wide.direction, wide.angle));
    drag_to(&mut harness, FanPart::Middle, (1.0, wide.direction + 30.0));
    let turned = face(&harness).ductile;
    let by = (turned.direction - thin.direction).rem_euclid(360.0);
    assert!((by - 30.0).abs() < 6.0, "{turned:?}");
    assert_eq!((turned.angle, turned.rings), (thin.angle, thin.rings));
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    for expected in [&thin, &wide, &first] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
        assert_eq!(face(&harness).ductile, *expected);
    }
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!(face(&harness).ductile, wide);
    // Without handles there is nothing to drag.
    harness.key_press(Key::H);
    harness.step();
    assert!(harness.state_mut().fan_dot(FanPart::End).is_none());
}

#[test]
fn a_drag_makes_a_layer_and_raises_it() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    for (kind, up) in [(FanKind::High, 40.0), (FanKind::Low, -40.0)] {
        choose(&mut harness, kind);
        harness.step();
        let before = harness.state().project.fan(0, kind);
        assert!(!before.is_there());
        let first = before.or_first(kind);
        let dot = harness.state_mut().fan_dot(FanPart::Middle).unwrap();
        drag(&mut harness, dot, dot - Vec2::new(0.0, up));
        let raised = harness.state().project.fan(0, kind);
        assert!(raised.is_there(), "{raised:?}");
        let by = (raised.height.unwrap() - first.height.unwrap()).abs();
        assert!(by > 0.1, "{raised:?}");
        assert_eq!((raised.angle, raised.rings), (first.angle, first.rings));
    }
    let [high, low] = [FanKind::High, FanKind::Low].map(|k| harness.state().project.fan(0, k));
    assert!(high.height.unwrap() > 0.0 && low.height.unwrap() < 0.0);
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
    }
    assert_eq!(harness.state().project.file, RequestFile::default());
}
