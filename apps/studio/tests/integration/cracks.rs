//! Cracks that are placed by hand: dragged over the wood, sized, undone, taken away, and saved.

use crate::common::{Folder, drag, exported, saved_and_broken, settle, studio};
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use greenstick::RequestFile;
use greenstick::fracture::parameters::{Crack, CrackEnd, RadialCrack};
use greenstick_studio::model::placed_cracks::CrackEndPoint;
use greenstick_studio::ui::studio::Studio;

fn radial(harness: &Harness<'static, Studio>, number: usize) -> RadialCrack {
    match harness.state().project.placed_cracks().get(number) {
        Some(Crack::Radial(crack)) => crack.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_crack_is_drawn_sized_undone_and_saved() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::K);
    harness.run_steps(2);
    let place = |harness: &mut Harness<'static, Studio>, rho, angle| {
        harness.state_mut().face_place_at(rho, angle).unwrap()
    };
    let (from, to) = (place(&mut harness, 0.3, 0.6), place(&mut harness, 0.8, 0.6));
    drag(&mut harness, from, to);
    assert!(
        harness.state().messages().is_empty(),
        "{:?}",
        harness.state().messages()
    );
    let drawn = radial(&harness, 0);
    assert!(drawn.end - drawn.begin > 0.15, "{drawn:?}");
    // Its depth by the square dot.
    let dot = harness
        .state_mut()
        .crack_dot(0, CrackEndPoint::Depth)
        .unwrap();
    let end = harness
        .state_mut()
        .crack_dot(0, CrackEndPoint::End)
        .unwrap();
    drag(&mut harness, dot, dot + (dot - end) * 0.8);
    let deep = radial(&harness, 0);
    assert!(deep.depth > 1.3 * drawn.depth, "{deep:?}");
    assert_eq!(
        (deep.angle, deep.begin, deep.end),
        (drawn.angle, drawn.begin, drawn.end)
    );
    // The dot is where it was let go.
    let now = harness
        .state_mut()
        .crack_dot(0, CrackEndPoint::Depth)
        .unwrap();
    assert!(now.distance(dot + (dot - end) * 0.8) < 4.0, "{now}");
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(radial(&harness, 0), drawn);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!(radial(&harness, 0), drawn);
    harness.key_press(Key::Delete);
    settle(&mut harness);
    assert!(harness.state().project.placed_cracks().is_empty());
}

#[test]
fn clicks_place_cracks_and_turning_the_picture_places_none() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::K);
    harness.run_steps(2);
    let at = harness.state_mut().face_place_at(0.6, 2.0).unwrap();
    harness.hover_at(at);
    harness.step();
    harness.drag_at(at);
    harness.drop_at(at);
    settle(&mut harness);
    assert_eq!(harness.state().project.placed_cracks().len(), 1);
    // Beside the stem a drag turns the picture.
    let corner = vec2(8.0, 8.0).to_pos2() + vec2(320.0, 640.0);
    drag(&mut harness, corner, corner + vec2(30.0, 0.0));
    assert_eq!(harness.state().project.placed_cracks().len(), 1);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    // Clicks place none any more.
    let bark = harness.state_mut().face_place_at(1.0, 2.0).unwrap();
    harness.hover_at(bark);
    harness.step();
    harness.drag_at(bark);
    harness.drop_at(bark);
    settle(&mut harness);
    assert_eq!(harness.state().project.placed_cracks().len(), 1);
}

#[test]
fn cracks_are_placed_on_the_sawn_end_and_moved_to_the_break() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::K);
    harness.run_steps(2);
    // The end at the tip is seen from above.
    harness.key_press(Key::Num7);
    harness.key_press(Key::Home);
    harness.run_steps(2);
    let place = |harness: &mut Harness<'static, Studio>, rho, angle| {
        harness.state_mut().end_place_at(true, rho, angle).unwrap()
    };
    let (from, to) = (
        place(&mut harness, 0.25, 0.9),
        place(&mut harness, 0.85, 0.9),
    );
    drag(&mut harness, from, to);
    assert!(
        harness.state().messages().is_empty(),
        "{:?}",
        harness.state().messages()
    );
    let drawn = radial(&harness, 0);
    assert!((drawn.angle.to_radians() - 0.9).abs() < 0.1, "{drawn:?}");
    assert!((drawn.begin - 0.25).abs() < 0.08 && (drawn.end - 0.85).abs() < 0.08);
    let end = |harness: &Harness<'static, Studio>| harness.state().project.crack_end();
    assert_eq!(end(&harness), Some(CrackEnd::Sawn));
    // It is drawn where it was dragged: its dots are there, and the wood is open between them.
    let dot = |harness: &mut Harness<'static, Studio>, part| {
        harness.state_mut().crack_dot(0, part).unwrap()
    };
    let seen = dot(&mut harness, CrackEndPoint::End);
    assert!(seen.distance(to) < 3.0, "{seen} {to}");
    let notes = &harness.state().report().unwrap().notes;
    assert!(
        notes
            .iter()
            .all(|n| !n.to_string().contains("sawn off straight")),
        "{notes:?}"
    );
    // A click places another, and one on the broken face none.
    let at = place(&mut harness, 0.6, -2.0);
    harness.hover_at(at);
    harness.step();
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    settle(&mut harness);
    assert_eq!(harness.state().project.placed_cracks().len(), 2);
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    // All are brought to the broken face at once, as one step.
    harness.get_by_label("broken face").click();
    settle(&mut harness);
    assert_eq!(end(&harness), Some(CrackEnd::Break));
    let at = place(&mut harness, 0.5, 0.2);
    drag(&mut harness, at, at + vec2(8.0, 0.0));
    assert_eq!(harness.state().project.placed_cracks().len(), 2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(end(&harness), Some(CrackEnd::Sawn));
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
    }
    assert_eq!(harness.state().project.file, RequestFile::default());
}

#[test]
fn cracks_are_placed_on_the_end_at_the_base() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::K);
    harness.run_steps(2);
    // It is seen from below.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num7);
    harness.key_press(Key::Home);
    harness.run_steps(2);
    let place = |harness: &mut Harness<'static, Studio>, rho, angle| {
        harness.state_mut().end_place_at(false, rho, angle).unwrap()
    };
    let from = place(&mut harness, 0.25, -1.2);
    let to = place(&mut harness, 0.85, -1.2);
    drag(&mut harness, from, to);
    let drawn = radial(&harness, 0);
    let turn = (drawn.angle.to_radians() + 1.2).rem_euclid(std::f64::consts::TAU);
    assert!(!(0.1..6.18).contains(&turn), "{drawn:?}");
    assert!((drawn.begin - 0.25).abs() < 0.08 && (drawn.end - 0.85).abs() < 0.08);
    assert_eq!(harness.state().project.crack_end(), Some(CrackEnd::Base));
    let dot = harness.state_mut().crack_dot(0, CrackEndPoint::End);
    assert!(dot.unwrap().distance(to) < 3.0, "{dot:?} {to}");
    let notes = &harness.state().report().unwrap().notes;
    let said = |text: &str| notes.iter().any(|n| n.to_string().contains(text));
    assert!(
        said("end at the base") && !said("sawn off straight"),
        "{notes:?}"
    );
    // Its depth dot lies in the wood: from the side it is above the end, which looks down.
    harness.key_press(Key::Num1);
    harness.run_steps(2);
    let [end, depth] = [CrackEndPoint::End, CrackEndPoint::Depth]
        .map(|part| harness.state_mut().crack_dot(0, part).unwrap());
    let inner = harness.state_mut().face_place_at(0.0, 0.0).unwrap();
    assert!(
        (depth - end).dot(inner - end) > 0.0,
        "{end} {depth} {inner}"
    );
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
}
