//! The window, driven as a person would: click, type, drag, undo. Needs no graphics adapter: nothing is drawn.

use crate::common::{Folder, settle, studio, test_data};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use greenstick::RequestFile;
use greenstick::files::encode;
use greenstick::formats::LengthUnit;
use greenstick::schema::{Kind, Parameters, Value};
use greenstick::wood::noise::unit;
use greenstick_studio::ui::studio::Studio;
use std::path::Path;
use std::time::Instant;

#[test]
fn the_built_in_branch_is_broken_at_the_start() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let report = harness.state().report().unwrap();
    assert!(report.pieces.len() >= 2 && harness.state().triangles() > 1000);
    assert!(harness.state().messages().is_empty());
}

#[test]
fn a_slider_is_dragged_and_undone_as_one_step() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let slider = harness
        .get_by_role_and_label(Role::Slider, "Inclination")
        .rect();
    harness.drag_at(slider.left_center() + eframe::egui::vec2(3.0, 0.0));
    harness.step();
    for i in 1..6 {
        harness.hover_at(slider.left_center() + eframe::egui::vec2(3.0 + 6.0 * i as f32, 0.0));
        harness.step();
    }
    harness.drop_at(slider.left_center() + eframe::egui::vec2(33.0, 0.0));
    settle(&mut harness);
    let moved = harness.state().project.file.common.recipe.face.inclination;
    assert!(moved > 1.0, "{moved}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    let again = harness.state().project.file.common.recipe.face.inclination;
    assert_eq!(again, moved);
}

#[test]
fn breaks_are_added_moved_selected_and_taken_away() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let before = harness.state().report().unwrap().pieces.len();
    harness.key_press(Key::A);
    settle(&mut harness);
    let breaks = |harness: &Harness<'_, Studio>| harness.state().project.break_count();
    assert_eq!(breaks(&harness), 2);
    assert_eq!(harness.state().project.selected(), Some(1));
    assert!(harness.state().report().unwrap().pieces.len() > before);
    assert!(harness.state().messages().is_empty());
    // The panel shows the second break, and changes it alone.
    let now = 0.0;
    let key = "break.inclination";
    harness
        .state_mut()
        .set(key, &Value::Number(15.0), false, now);
    settle(&mut harness);
    let inclination = |harness: &Harness<'_, Studio>, i: usize| {
        let file = &harness.state().project.file;
        file.breaks[i].recipe.face.inclination
    };
    assert_eq!(
        [0, 1].map(|i| inclination(&harness, i)),
        [RequestFile::default().common.recipe.face.inclination, 15.0]
    );
    harness.get_by_label("all").click();
    harness.step();
    assert_eq!(harness.state().project.selected(), None);
    harness.get_by_label("1").click();
    harness.step();
    assert_eq!(harness.state().project.selected(), Some(0));
    harness.get_by_label("Remove the break").click();
    settle(&mut harness);
    assert_eq!(breaks(&harness), 1);
    let left = &harness.state().project.file.common.recipe.face;
    assert_eq!(left.inclination, 15.0);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(breaks(&harness), 2);
}

#[test]
fn the_handle_on_the_wood_tilts_the_break_as_one_step() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let dot = harness.state().handle_at().unwrap();
    harness.hover_at(dot);
    harness.step();
    harness.drag_at(dot);
    harness.step();
    for i in 1..6 {
        harness.hover_at(dot - eframe::egui::vec2(0.0, 8.0 * i as f32));
        harness.step();
    }
    let end = dot - eframe::egui::vec2(0.0, 40.0);
    harness.drop_at(end);
    settle(&mut harness);
    let face = &harness.state().project.file.common.recipe.face;
    assert!(face.inclination > 5.0, "{}", face.inclination);
    // The dot is where it was let go.
    let dot = harness.state().handle_at().unwrap();
    assert!(dot.distance(end) < 3.0, "{dot} {end}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.key_press(Key::H);
    harness.step();
    assert!(harness.state().handle_at().is_none());
}

#[test]
fn a_tree_that_cannot_break_in_its_middle_is_broken_beside_it() {
    let folder = Folder::new();
    let tree = test_data("quaternius_DeadTree_1.gltf");
    let mut harness = studio(&folder, Some(&tree));
    settle(&mut harness);
    assert!(harness.state().report().is_some());
    let messages = harness.state().messages();
    assert!(messages.iter().all(|m| !m.is_error), "{messages:?}");
    let told = |m: &greenstick_studio::ui::studio::Message| m.text.starts_with("Broken at 0.");
    assert!(messages.iter().any(told), "{messages:?}");
    assert!(!harness.state().project.is_changed());
}

#[test]
fn a_search_finds_a_parameter_and_a_double_click_resets_it() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let now = 0.0;
    harness
        .state_mut()
        .set("break.slab_height", &Value::Number(3.0), false, now);
    settle(&mut harness);
    let search = harness.get_by_role(Role::TextInput);
    search.focus();
    harness.step();
    harness
        .get_by_role(Role::TextInput)
        .type_text("slab height");
    harness.run_steps(3);
    let name = harness
        .get_by_role_and_label(Role::Label, "Slab height")
        .rect()
        .center();
    harness.hover_at(name);
    harness.step();
    for _ in 0..2 {
        harness.drag_at(name);
        harness.event(eframe::egui::Event::PointerButton {
            pos: name,
            button: eframe::egui::PointerButton::Primary,
            pressed: false,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    settle(&mut harness);
    assert_eq!(
        harness.state().project.file.common.recipe.face.slab_height,
        0.8
    );
    assert!(harness.query_by_label("Inclination").is_none());
}

#[test]
fn a_click_on_the_stem_moves_the_break() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let before = harness.state().report().unwrap().place.length_m;
    // Along the middle of the viewport there is wood somewhere.
    let mut moved = false;
    for i in 0..12 {
        let at = eframe::egui::pos2(300.0 + 55.0 * i as f32, 300.0 + 25.0 * (i % 5) as f32);
        harness.hover_at(at);
        harness.step();
        harness.drag_at(at);
        harness.drop_at(at);
        settle(&mut harness);
        let place = harness.state().report().unwrap().place.length_m;
        moved |= (place - before).abs() > 1e-6;
    }
    assert!(moved, "no click met the stem");
    assert!(
        harness.state().messages().is_empty(),
        "{:?}",
        harness.state().messages()
    );
}

#[test]
fn presets_apply_by_a_click_and_are_undone() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.get_by_label("brash").click();
    settle(&mut harness);
    let expected = RequestFile::resolve(&["brash"], None, &[]).unwrap();
    assert_eq!(harness.state().project.file, expected);
    harness.get_by_label("Undo").click();
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
}

#[test]
fn a_bad_file_gives_a_message_that_stays_until_it_is_dismissed() {
    let folder = Folder::new();
    let bad = folder.0.join("bad.glb");
    std::fs::write(&bad, b"no mesh").unwrap();
    let mut harness = studio(&folder, Some(bad.to_str().unwrap()));
    settle(&mut harness);
    harness.run_steps(20);
    let messages = harness.state().messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(
        messages[0].is_error && messages[0].text.contains("bad.glb"),
        "{messages:?}"
    );
    // What was shown before goes on.
    assert!(harness.state().report().is_some());
    harness.get_by_label("Dismiss").click();
    harness.run_steps(2);
    assert!(harness.state().messages().is_empty());
}

#[test]
fn a_mesh_opens_and_a_project_comes_back_as_it_was() {
    let folder = Folder::new();
    let tree = test_data("quaternius_DeadTree_1.gltf");
    let mut harness = studio(&folder, Some(&tree));
    settle(&mut harness);
    harness
        .state_mut()
        .set("at", &Value::Text("0.1".into()), false, 0.0);
    harness
        .state_mut()
        .set("break.inclination", &Value::Number(20.0), false, 0.0);
    settle(&mut harness);
    let file = harness.state().project.file.clone();
    let project = folder.0.join("tree.greenstick.toml");
    harness.state_mut().save_as(project.to_str().unwrap());
    let mut again = studio(&folder, Some(project.to_str().unwrap()));
    settle(&mut again);
    // Its images are not in the repository, which a note says.
    let errors = again.state().messages().iter().filter(|m| m.is_error);
    assert_eq!(errors.count(), 0, "{:?}", again.state().messages());
    assert_eq!(again.state().project.file, file);
    assert_eq!(
        again.state().project.input.file_name(),
        Some("quaternius_DeadTree_1.gltf")
    );
    assert_eq!(again.state().triangles(), harness.state().triangles());
}

#[test]
fn lengths_are_shown_in_the_unit_that_was_chosen() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let shown = |harness: &Harness<'_, Studio>| {
        let fields = harness.get_all_by_role_and_label(Role::SpinButton, "Noise diameter");
        fields
            .filter_map(|f| f.value())
            .collect::<Vec<_>>()
            .join("")
    };
    assert!(shown(&harness).contains("cm"), "{}", shown(&harness));
    harness.get_by_value("cm").click();
    harness.run_steps(20);
    harness.get_by_label("in").click();
    harness.run_steps(20);
    assert!(shown(&harness).starts_with("0.394"), "{}", shown(&harness));
    // The request is what it was, and another start shows the same unit.
    assert_eq!(harness.state().project.file, RequestFile::default());
    let mut again = studio(&folder, None);
    settle(&mut again);
    assert!(shown(&again).contains("in"));
}

/// Longest update of the window, apart from drawing and from what else the machine does, s.
const LONGEST_UPDATE: f64 = 0.1;

#[test]
fn sliders_at_their_ends_and_at_random_do_no_harm() {
    let folder = Folder::new();
    // A face of few cells: what counts is whether each change goes well, not how fine the face is.
    let first = RequestFile::resolve(
        &[],
        None,
        &["break.rings=6", "break.sectors=12", "break.sliver_count=12"],
    )
    .unwrap();
    let project = folder.0.join("coarse.toml");
    std::fs::write(&project, first.to_toml()).unwrap();
    let mut harness = studio(&folder, Some(project.to_str().unwrap()));
    settle(&mut harness);
    let list = harness.state().project.file.list();
    let numbers: Vec<_> = list
        .into_iter()
        .filter(|p| p.min().is_some() && !p.key.starts_with("picture") && p.max() < Some(1e5))
        // These decide how long the work takes. Grain that winds by 30° a radius through a high face is cut in minutes.
        .filter(|p| {
            let slow = [
                "break.rings",
                "break.sectors",
                "break.spiral_angle",
                "samples",
                "texture_size",
            ];
            !slow.contains(&p.key.as_str())
        })
        .collect();
    assert!(numbers.len() > 80, "{}", numbers.len());
    let mut updates = Vec::new();
    for i in 0..200u32 {
        let p = &numbers[(unit(5, i.into(), 0, 0) * numbers.len() as f64) as usize];
        let (min, max) = (p.min().unwrap(), p.max().unwrap());
        let share = match i % 3 {
            0 => 0.0,
            1 => 1.0,
            _ => unit(6, i.into(), 0, 0),
        };
        let x = min + (max - min) * share;
        let value = match p.kind {
            Kind::Integer { step, .. } => Value::Integer((x / step as f64).round() as i128 * step),
            _ => Value::Number(x),
        };
        harness
            .state_mut()
            .set(&p.key, &value, i % 2 == 0, f64::from(i));
        let start = Instant::now();
        harness.step();
        updates.push(start.elapsed().as_secs_f64());
    }
    while harness.state().project.history.undo_label().is_some() {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.step();
    }
    settle(&mut harness);
    assert_eq!(harness.state().project.file, first);
    assert!(harness.state().report().is_some());
    // Half of them, as a busy machine gives the processor to others now and then.
    updates.sort_by(f64::total_cmp);
    let (half, longest) = (updates[updates.len() / 2], updates[updates.len() - 1]);
    println!(
        "updates: half within {:.1} ms, longest {:.1} ms",
        1e3 * half,
        1e3 * longest
    );
    assert!(half < LONGEST_UPDATE, "{half} s");
}

#[test]
fn a_stem_that_is_too_thick_asks_for_the_unit_of_its_file() {
    let folder = Folder::new();
    // The built-in branch, in millimetres.
    let mut scene = greenstick::built_in_branch();
    for node in &mut scene.nodes {
        let large = node
            .mesh
            .transformed(&glam::DAffine3::from_scale(glam::DVec3::splat(1e3)));
        node.mesh = large.into();
    }
    let outputs = encode(&scene, Path::new("branch.stl"), LengthUnit::Metre).unwrap();
    let path = folder.0.join("branch.stl");
    std::fs::write(&path, &outputs[0].bytes).unwrap();
    let mut harness = studio(&folder, Some(path.to_str().unwrap()));
    settle(&mut harness);
    let thick = |h: &Harness<'static, Studio>| 2.0 * h.state().report().unwrap().place.radius_m;
    assert!((thick(&harness) - 40.6).abs() < 1.0, "{}", thick(&harness));
    harness.get_by_label("Millimetres").click();
    harness.run_steps(2);
    settle(&mut harness);
    assert!(
        (thick(&harness) - 0.0406).abs() < 1e-3,
        "{}",
        thick(&harness)
    );
    assert_eq!(
        harness.state().project.file.unit,
        Some(LengthUnit::Millimetre)
    );
    assert!(harness.query_by_label("Millimetres").is_none());
}

#[test]
fn the_wheel_goes_nearer_to_what_is_under_the_pointer_and_never_past_it() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::Home);
    harness.run_steps(2);
    // The sawn end is far from the middle of the picture, and nearer to the eye.
    let end =
        |harness: &mut Harness<'static, Studio>| harness.state_mut().end_place_at(true, 0.4, 0.5);
    let at = end(&mut harness).unwrap();
    let other = |harness: &mut Harness<'static, Studio>| {
        harness.state_mut().end_place_at(true, 0.4, 3.6).unwrap()
    };
    let before = at.distance(other(&mut harness));
    harness.hover_at(at);
    harness.step();
    for _ in 0..24 {
        harness.event(eframe::egui::Event::MouseWheel {
            unit: eframe::egui::MouseWheelUnit::Line,
            delta: eframe::egui::vec2(0.0, 1.0),
            phase: eframe::egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
            source: eframe::egui::MouseWheelSource::Unknown,
        });
        harness.step();
    }
    let now = end(&mut harness).expect("the end is behind the camera");
    assert!(now.distance(at) < 3.0, "{now} {at}");
    // 24 notches of 0.88 are 21 times nearer.
    let nearer = now.distance(other(&mut harness)) / before;
    assert!((10.0..40.0).contains(&nearer), "{nearer}");
}
