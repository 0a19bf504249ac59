//! Labels of what is dragged in the picture: they are within it wherever their dots are.

use crate::common::{Folder, settle, studio};
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Shape, Vec2};
use egui_kittest::Harness;
use greenstick_studio::model::fan::{FanKind, FanPart};
use greenstick_studio::ui::studio::Studio;

type Window = Harness<'static, Studio>;

/// Shifts the picture by a drag with the right button.
fn shift(harness: &mut Window, by: Vec2) {
    let from = harness.state().viewport_middle().unwrap();
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Secondary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    harness.hover_at(from);
    harness.step();
    harness.event(button(from, true));
    harness.step();
    for i in 1..=4 {
        harness.hover_at(from + by * (i as f32 / 4.0));
        harness.step();
    }
    harness.event(button(from + by, false));
    harness.run_steps(2);
}

/// The texts that hold a word: where they are drawn, and the area that they are drawn on.
fn drawn_texts(harness: &Window, word: &str) -> Vec<(Rect, Rect)> {
    let shapes = harness.output().shapes.iter();
    let text = |clipped: &eframe::egui::epaint::ClippedShape| match &clipped.shape {
        Shape::Text(text) if text.galley.text().contains(word) => {
            Some((text.visual_bounding_rect(), clipped.clip_rect))
        }
        _ => None,
    };
    shapes.filter_map(text).collect()
}

/// Brings a dot near the edges of the viewport, one after the other, and looks where its label is.
fn assert_inside(harness: &mut Window, word: &str, dot: impl Fn(&mut Window) -> Pos2) {
    let middle = harness.state().viewport_middle().unwrap();
    let mut sides = [0; 4];
    let edge = 0.96;
    let half = {
        let at = dot(harness);
        harness.hover_at(at);
        harness.run_steps(2);
        let found = drawn_texts(harness, word);
        assert_eq!(found.len(), 1, "{found:?}");
        0.5 * found[0].1.size()
    };
    for (i, side) in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y]
        .into_iter()
        .enumerate()
    {
        let wanted = middle + side * half * edge;
        let mut at = dot(harness);
        // What is nearer to the eye than the middle of the picture goes farther than the pointer.
        for _ in 0..8 {
            if at.distance(wanted) < 8.0 {
                break;
            }
            shift(harness, wanted - at);
            at = dot(harness);
        }
        assert!(at.distance(wanted) < 8.0, "{at} {wanted}");
        harness.hover_at(at);
        harness.run_steps(2);
        let found = drawn_texts(harness, word);
        assert_eq!(found.len(), 1, "{found:?} at {at}");
        let (text, area) = found[0];
        assert!(area.contains_rect(text), "{text} in {area}, dot at {at}");
        assert!(!text.contains(at));
        sides[i] += usize::from(text.center().x < at.x) + 2 * usize::from(text.center().y > at.y);
    }
    // Near the right edge it is on the left, near the upper one below.
    assert!(sides[0] & 1 == 1 && sides[3] & 2 == 2, "{sides:?}");
}

#[test]
fn labels_stay_in_the_picture() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    assert_inside(&mut harness, "inclination", |h| {
        h.state().handle_at().unwrap()
    });
    harness.key_press(Key::F);
    harness.run_steps(2);
    while harness.state().fans.kind != Some(FanKind::Ductile) {
        harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
        harness.step();
    }
    harness.run_steps(2);
    assert_inside(&mut harness, "ductile zone, ", |h| {
        h.state_mut().fan_dot(FanPart::Middle).unwrap()
    });
}
