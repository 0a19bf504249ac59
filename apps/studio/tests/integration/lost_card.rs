//! The graphics device is lost: the work is kept, and the same studio goes on in another window, on another device.

use crate::common::{Folder, drag, settle};
use crate::snapshots::{SIZE, card, draw, window};
use eframe::egui::{self, Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use greenstick::schema::Value;
use greenstick_studio::model::project_file::ProjectFile;

#[test]
fn a_lost_device_costs_no_work() {
    let test = "a_lost_device_costs_no_work";
    let Some(first) = card(test) else { return };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &first);
    let key = "break.inclination";
    let now = 0.0;
    harness
        .state_mut()
        .set(key, &Value::Number(20.0), false, now);
    settle(&mut harness);
    let slider = harness
        .get_by_role_and_label(Role::Slider, "Inclination")
        .rect();
    let grip = slider.left_center() + egui::vec2(0.2 * slider.width(), 0.0);
    drag(&mut harness, grip, grip + egui::vec2(20.0, 0.0));
    let before = harness.state().project.file.clone();
    let picture = draw(&harness, &first);
    assert_eq!(harness.state().lost_card(), None);

    first.device.destroy();
    harness.step();
    assert!(harness.state().lost_card().is_some());
    // The viewport is not drawn on a device that is not there, and the window asks to be closed.
    let mut shapes = harness.output().shapes.iter();
    assert!(!shapes.any(|s| matches!(s.shape, egui::Shape::Callback(_))));
    let commands = &harness.output().viewport_output[&egui::ViewportId::ROOT].commands;
    assert!(commands.contains(&egui::ViewportCommand::Close));
    // What was kept on the disk is the whole request, in case no other window opens.
    let kept = folder.0.join("config").join("unsaved.greenstick.toml");
    let kept = std::fs::read_to_string(kept).unwrap();
    assert_eq!(ProjectFile::read(&kept).unwrap().request, before);

    let Some(second) = card(test) else { return };
    let size = egui::vec2(SIZE[0] as f32, SIZE[1] as f32);
    let mut harness = crate::common::moved_to(
        harness,
        size,
        crate::snapshots::CardRenderer(second.clone()),
    );
    let ctx = harness.ctx.clone();
    harness.state_mut().go_on(&ctx);
    harness.state_mut().use_card(&ctx, &second);
    settle(&mut harness);
    assert_eq!(harness.state().lost_card(), None);
    assert_eq!(harness.state().project.file, before);
    // The same picture, but for the line that says what happened.
    let again = draw(&harness, &second);
    let pixels = |rgb: &[u8]| rgb.as_chunks::<3>().0.to_vec();
    let (old, new) = (pixels(&picture.rgb), pixels(&again.rgb));
    let others = old.iter().zip(&new).filter(|(a, b)| a != b).count();
    assert!(others * 50 < old.len(), "{others} of {} pixels", old.len());
    // The past came along.
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
    }
    assert_eq!(
        harness.state().project.file,
        greenstick::RequestFile::default()
    );
}
