//! The photograph of a real break: opened, laid, undone, kept with the project, and said where it cannot be read.

use crate::common::{Folder, settle, studio};
use eframe::egui::{self, Key, Modifiers, PointerButton, accesskit::Role};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use greenstick::RequestFile;
use greenstick::files;
use greenstick_studio::model::project_file::ProjectFile;
use greenstick_studio::ui::studio::Studio;
use std::path::Path;

/// A picture of the repository that is no square.
fn picture(folder: &Folder) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = folder.0.join("real break.png");
    std::fs::copy(root.join("docs/pictures/studio/rings.png"), &path).unwrap();
    path.display().to_string()
}

fn wheel(harness: &mut Harness<'_, Studio>, notches: f32) {
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, notches),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
        source: egui::MouseWheelSource::Unknown,
    });
    harness.step();
}

#[test]
fn a_photograph_is_laid_by_drags_and_undone_step_by_step() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let path = picture(&folder);
    harness.state_mut().open(&path);
    settle(&mut harness);
    assert!(harness.state().has_photograph());
    assert_eq!(harness.state().project.photograph.file, Some(path.clone()));
    // It changes the project and not the break.
    assert!(harness.state().project.is_changed());
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.get_by_label("Move").click();
    harness.run_steps(2);
    let from = egui::pos2(600.0, 500.0);
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=5 {
        harness.hover_at(from + egui::vec2(12.0 * i as f32, -6.0 * i as f32));
        harness.step();
    }
    harness.drop_at(from + egui::vec2(60.0, -30.0));
    harness.run_steps(2);
    let laid = harness.state().project.photograph.clone();
    assert!(laid.right > 0.02 && laid.up > 0.01, "{laid:?}");
    assert!((laid.right / laid.up - 2.0).abs() < 1e-3, "{laid:?}");
    harness.hover_at(from);
    harness.step();
    wheel(&mut harness, 2.0);
    let scaled = harness.state().project.photograph.scale;
    assert!(scaled > laid.scale * 1.1, "{scaled}");
    // The view was not moved, nor the break.
    assert_eq!(harness.state().project.file, RequestFile::default());
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.step();
    }
    assert_eq!(harness.state().project.photograph.right, 0.0);
    assert!(harness.state().has_photograph());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert!(!harness.state().has_photograph() && !harness.state().project.is_changed());
    for _ in 0..3 {
        harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
        settle(&mut harness);
    }
    assert!(harness.state().has_photograph());
    assert_eq!(harness.state().project.photograph.scale, scaled);
}

#[test]
fn a_photograph_is_saved_and_restored_with_its_view() {
    let folder = Folder::new();
    let mut harness = studio(&folder, Some(&picture(&folder)));
    settle(&mut harness);
    let triangles = harness.state().triangles();
    harness.get_by_label("Move").click();
    harness.run_steps(2);
    harness.hover_at(egui::pos2(600.0, 500.0));
    harness.step();
    wheel(&mut harness, 2.0);
    let scaled = harness.state().project.photograph.scale;
    // Turned views are kept: the picture is matched from one.
    harness.key_press(Key::Num7);
    harness.key_press(Key::Num5);
    harness.run_steps(2);
    let project = folder.0.join("p.greenstick.toml");
    harness.state_mut().save_as(project.to_str().unwrap());
    assert!(!harness.state().project.is_changed());
    let text = std::fs::read_to_string(&project).unwrap();
    let file = ProjectFile::read(&text).unwrap();
    assert_eq!(
        file.studio.photograph.file.as_deref(),
        Some("real break.png")
    );
    assert!(file.studio.view.saved && file.studio.view.parallel);
    // Readers of recipes read it, too.
    let recipe = RequestFile::resolve(&[], Some(&text), &[]).unwrap();
    assert_eq!(recipe, RequestFile::default());

    let mut again = studio(&folder, Some(project.to_str().unwrap()));
    settle(&mut again);
    assert!(again.state().has_photograph() && !again.state().project.is_changed());
    assert!(scaled > 1.0);
    assert_eq!(again.state().project.photograph.scale, scaled);
    assert_eq!(again.state().triangles(), triangles);
    let middle = glam::DVec3::ZERO;
    let seen = again.state().project_file().studio.view;
    let wanted = file.studio.view.camera(middle).unwrap();
    let found = seen.camera(middle).unwrap();
    assert!((found.target - wanted.target).length() < 1e-5);
    assert_eq!(
        (found.yaw, found.pitch, found.parallel),
        (wanted.yaw, wanted.pitch, wanted.parallel)
    );
}

#[test]
fn a_photograph_beside_the_picture_is_moved_in_its_own_half() {
    let folder = Folder::new();
    let mut harness = studio(&folder, Some(&picture(&folder)));
    settle(&mut harness);
    assert!(harness.state().has_photograph() && harness.state().report().is_some());
    harness.get_by_label("beside").click();
    harness.run_steps(2);
    let from = egui::pos2(900.0, 500.0);
    harness.hover_at(from);
    harness.step();
    harness.event(egui::Event::PointerButton {
        pos: from,
        button: PointerButton::Primary,
        pressed: true,
        modifiers: Modifiers::SHIFT,
    });
    harness.step();
    for i in 1..=4 {
        harness.event(egui::Event::PointerMoved(
            from + egui::vec2(10.0 * i as f32, 0.0),
        ));
        harness.step();
    }
    harness.drop_at(from + egui::vec2(40.0, 0.0));
    harness.run_steps(2);
    let laid = &harness.state().project.photograph;
    assert!(laid.beside && laid.file.is_some());
    assert!(laid.right > 0.01 || laid.turn > 1.0, "{laid:?}");
    let opacity = harness.get_by_role_and_label(Role::Slider, "opacity");
    assert!(opacity.accesskit_node().is_disabled());
    harness.get_by_label("Remove").click();
    harness.run_steps(2);
    assert!(!harness.state().has_photograph());
}

#[test]
fn the_bar_of_a_photograph_wraps_in_a_narrow_window() {
    let folder = Folder::new();
    let mut harness = studio(&folder, Some(&picture(&folder)));
    settle(&mut harness);
    for width in (700..1000).step_by(20) {
        harness.set_size(egui::vec2(width as f32, 450.0));
        harness.run_steps(2);
        for label in ["Move", "over", "beside", "Remove"] {
            let height = harness.get_by_label(label).rect().height();
            assert!(height < 30.0, "{label}: {height} points high at {width}");
        }
        let opacity = harness
            .get_by_role_and_label(Role::Slider, "opacity")
            .rect();
        assert!(
            opacity.right() <= width as f32 && opacity.height() < 30.0,
            "{opacity:?} at {width}"
        );
    }
}

#[test]
fn a_bad_photograph_gives_a_message_that_stays_and_changes_nothing() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let bad = folder.0.join("bad.jpg");
    std::fs::write(&bad, b"no picture").unwrap();
    harness.state_mut().open(bad.to_str().unwrap());
    settle(&mut harness);
    harness.run_steps(20);
    let messages = harness.state().messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].is_error && messages[0].text.contains("bad.jpg"));
    assert!(!harness.state().project.is_changed() && !harness.state().has_photograph());
    // In a narrow window it wraps before it reaches the panel.
    let text = messages[0].text.clone();
    harness.set_size(egui::vec2(920.0, 500.0));
    harness.run_steps(3);
    let (text, panel) = (
        harness.get_by_label(&text),
        harness.get_by_label("The break"),
    );
    assert!(
        text.rect().right() < panel.rect().left(),
        "{:?}",
        text.rect()
    );
    // A project whose photograph is gone opens without it, says so once, and keeps its values.
    let mut file = ProjectFile::default();
    file.studio.photograph.file = Some("gone.png".to_owned());
    file.studio.photograph.turn = 12.0;
    let project = folder.0.join("p.greenstick.toml");
    let bytes = file.to_toml().into_bytes();
    files::write_all(&[files::Output {
        path: project.clone(),
        bytes,
    }])
    .unwrap();
    let mut again = studio(&folder, Some(project.to_str().unwrap()));
    settle(&mut again);
    again.run_steps(20);
    let messages = again.state().messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].text.contains("gone.png"), "{messages:?}");
    assert!(again.state().report().is_some());
    assert_eq!(again.state().project.photograph.turn, 12.0);
}
