//! The section browser, driven as a person would: a height is dragged, a ring is dragged, undone, and saved.

use crate::common::{Folder, drag, exported, saved_and_broken, settle, studio, test_data};
use eframe::egui::{Event, Key, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::Queryable;
use greenstick::RequestFile;
use greenstick::wood::stem::PithPosition;

#[test]
fn a_ring_is_dragged_to_where_it_is_and_the_break_follows() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::S);
    settle(&mut harness);
    let before = harness.state().ring_edges();
    assert!(before.len() > 6, "{before:?}");
    // Half a ring outwards, along the direction of 0°.
    let from = harness.state().ring_at(3, 0.0).unwrap();
    let next = harness.state().ring_at(4, 0.0).unwrap();
    let to = from + (next - from) * 0.5;
    drag(&mut harness, from, to);
    assert!(harness.state().messages().is_empty());
    let after = harness.state().ring_edges();
    let radii = harness.state().project.file.rings.series.ring_radii.clone();
    assert_eq!(radii.map(|r| r.len()), Some(before.len()));
    // The rings that the break has now are those of the answer: the ring goes through where it was let go, and the others have
    // followed, but for the bark.
    let at = harness.state().ring_at(3, 0.0).unwrap();
    assert!(at.distance(to) < 1.0, "{at} {to}");
    assert_eq!((after.len(), after.last()), (before.len(), before.last()));
    assert!(after[0] > before[0] && after[5] > before[5] && after[3] > before[3]);
    assert!((after[0] / before[0] - after[3] / before[3]).abs() < 1e-3);
    // Another ring leaves it where it is.
    let from = harness.state().ring_at(6, 0.0).unwrap();
    let inner = harness.state().ring_at(5, 0.0).unwrap();
    drag(&mut harness, from, from + (inner - from) * 0.6);
    let third = harness.state().ring_edges();
    assert!(third[6] < after[6] && (third[3] - after[3]).abs() < 1e-6);
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    // Each drag was one step.
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
    }
    assert_eq!(harness.state().project.file, RequestFile::default());
    assert_eq!(harness.state().ring_edges(), before);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    let again = harness.state().ring_edges();
    assert!(again.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-9));
    // The pins are kept with the project.
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    let path = folder.0.join("saved.greenstick.toml");
    let mut opened = studio(&folder, path.to_str());
    settle(&mut opened);
    assert_eq!(opened.state().project.pinned, [3, 6].into());
    harness.get_by_label("Rings worked out").click();
    settle(&mut harness);
    let rings = &harness.state().project.file.rings;
    assert_eq!(rings, &RequestFile::default().rings);
}

#[test]
fn the_pith_and_the_onset_are_dragged_and_the_rings_follow() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::S);
    settle(&mut harness);
    let pith = harness.state().pith_dot().unwrap();
    let to = pith + vec2(18.0, -11.0);
    drag(&mut harness, pith, to);
    assert!(harness.state().messages().is_empty());
    // The rings of the answer are about where it was let go.
    let now = harness.state().pith_dot().unwrap();
    assert!(now.distance(to) < 1.0, "{pith} {now} {to}");
    let moved = harness.state().project.file.stem.pith;
    assert!(matches!(moved, Some(PithPosition::Section(_))), "{moved:?}");
    let first = harness.state().ring_at(0, 1.0).unwrap();
    let opposite = harness
        .state()
        .ring_at(0, 1.0 + std::f64::consts::PI)
        .unwrap();
    let middle = first + (opposite - first) * 0.5;
    assert!(middle.distance(to) < 2.0, "{middle} {to}");
    // The onset goes where its dot is let go, outwards along its angle.
    let dot = harness.state().onset_dot().unwrap();
    let pith = harness.state().pith_dot().unwrap();
    let outwards = pith + (dot - pith).normalized() * 60.0;
    drag(&mut harness, dot, outwards);
    let onset = harness.state().project.file.stem.eccentricity_onset;
    assert!(onset.is_some());
    assert!(harness.state().onset_dot().unwrap().distance(outwards) < 1.5);
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    // A double click leaves the onset to the program, and each drag was one step.
    let at = harness.state().onset_dot().unwrap();
    for pressed in [true, false, true, false] {
        harness.hover_at(at);
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    settle(&mut harness);
    assert_eq!(harness.state().project.file.stem.eccentricity_onset, None);
    for _ in 0..3 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
    }
    assert_eq!(harness.state().project.file, RequestFile::default());
}

#[test]
fn the_height_is_dragged_on_the_stem_and_in_the_panel() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.get_by_label("Anatomy").click();
    settle(&mut harness);
    let length = |h: &egui_kittest::Harness<'static, _>| {
        greenstick_studio::ui::studio::Studio::section_length(h.state()).unwrap()
    };
    let at_break = harness.state().report().unwrap().place.length_m;
    assert!((length(&harness) - at_break).abs() < 1e-9);
    harness.key_press(Key::Home);
    harness.run_steps(3);
    let dot = harness.state().section_dot_at().unwrap();
    let mut moved = Vec::new();
    for by in [vec2(0.0, -150.0), vec2(0.0, 250.0), vec2(50.0, 0.0)] {
        let dot = harness.state().section_dot_at().unwrap_or(dot);
        drag(&mut harness, dot, dot + by);
        moved.push(length(&harness));
    }
    let far = moved
        .iter()
        .map(|m| (m - at_break).abs())
        .fold(0.0, f64::max);
    assert!(far > 0.02, "{moved:?}");
    // Neither turned the camera's break nor the request.
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.get_by_label("At the break").click();
    harness.run_steps(2);
    assert!((length(&harness) - at_break).abs() < 1e-9);
}

#[test]
fn a_board_has_arcs_and_an_erosion_says_so() {
    let folder = Folder::new();
    let board = test_data("homecart_cutting_board.gltf");
    let mut harness = studio(&folder, Some(&board));
    settle(&mut harness);
    harness.key_press(Key::S);
    settle(&mut harness);
    let kind = harness.state().report().unwrap().place.kind.clone();
    assert_eq!(kind, "board");
    assert!(harness.state().section_length().is_some());
    let before = harness.state().ring_edges();
    assert!(!before.is_empty());
    let mut branch = studio(&folder, None);
    settle(&mut branch);
    let text = greenstick::schema::Value::Text("erosion".into());
    branch.state_mut().set("rings_by", &text, false, 0.0);
    branch.key_press(Key::S);
    settle(&mut branch);
    assert!(branch.state().ring_edges().is_empty());
    branch.get_by_label("Rings that come from an erosion cannot be dragged.");
}
