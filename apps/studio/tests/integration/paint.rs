//! Painting on the broken face: strokes with the pointer, undone as one step each, saved, and broken by the command line.

use crate::common::{Folder, drag, exported, saved_and_broken, settle, studio};
use eframe::egui::{Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use greenstick::RequestFile;
use greenstick::fracture::height_grid::HeightGrid;
use greenstick::fracture::heights::FailureMode;
use greenstick_studio::model::painted::{Brush, BrushKind, middles};
use greenstick_studio::ui::studio::Studio;
use std::time::Instant;

fn grid(harness: &Harness<'static, Studio>) -> HeightGrid {
    let painted = harness.state().project.painted(0);
    painted.cloned().unwrap_or_default()
}

fn place(harness: &mut Harness<'static, Studio>, rho: f32, angle: f32) -> Pos2 {
    harness.state_mut().face_place_at(rho, angle).unwrap()
}

/// Mean of some values of a grid over cells that a stroke along an angle from one ring coordinate to another covers, and over those
/// on the other side of the pith.
fn sides(grid: &HeightGrid, values: &[f64], angle: f64) -> [f64; 2] {
    [0.0, std::f64::consts::PI].map(|turn| {
        let near =
            |(rho, phi): (f64, f64)| (phi - angle - turn).cos() > 0.97 && (0.4..0.7).contains(&rho);
        let chosen: Vec<f64> = middles(grid)
            .zip(values)
            .filter(|(m, _)| near(*m))
            .map(|(_, v)| *v)
            .collect();
        chosen.iter().sum::<f64>() / chosen.len() as f64
    })
}

/// A studio that paints on the broken face, seen from above.
fn painting(folder: &Folder) -> Harness<'static, Studio> {
    let mut harness = studio(folder, None);
    settle(&mut harness);
    harness.key_press(Key::Num7);
    harness.key_press(Key::B);
    harness.run_steps(2);
    harness
}

#[test]
fn strokes_on_the_face_say_what_stays_and_what_splinters() {
    let folder = Folder::new();
    let mut harness = painting(&folder);
    let stroke = |harness: &mut Harness<'static, Studio>| {
        let (from, to) = (place(harness, 0.3, 1.0), place(harness, 0.8, 1.0));
        drag(harness, from, to);
        let messages = harness.state().messages();
        assert!(messages.iter().all(|m| !m.is_error), "{messages:?}");
    };
    stroke(&mut harness);
    let stays = grid(&harness);
    // What is painted lies over the plane of the face: it can still be tilted.
    assert!(harness.state().handle_at().is_some());
    let radius = harness.state().report().unwrap().place.radius_m;
    let [here, there] = sides(&stays, &stays.values, 1.0);
    assert!(here > 0.1 * radius && there == 0.0, "{here} {there}");
    harness.get_by_label("Splinter").click();
    harness.run_steps(2);
    assert_eq!(harness.state().paint.brush.kind, BrushKind::Splinter);
    stroke(&mut harness);
    let splinters = grid(&harness);
    let [here, there] = sides(&splinters, &splinters.splintering, 1.0);
    assert!(here > 1.5 && there == 1.0, "{here} {there}");
    assert_eq!(splinters.values, stays.values);
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
    // Each stroke is a step.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(grid(&harness), stays);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!(grid(&harness), stays);
    harness.get_by_label("Clear").click();
    settle(&mut harness);
    assert_eq!(harness.state().project.file, RequestFile::default());
}

#[test]
fn a_painted_face_follows_its_plane_and_its_layers() {
    let folder = Folder::new();
    let mut harness = painting(&folder);
    let (from, to) = (place(&mut harness, 0.3, 1.0), place(&mut harness, 0.8, 1.0));
    drag(&mut harness, from, to);
    settle(&mut harness);
    let painted = grid(&harness);
    let heights = |harness: &mut Harness<'static, Studio>| {
        settle(harness);
        let face = harness.state_mut().face().unwrap();
        [0.0, 1.5, 3.0, 4.5].map(|angle| face.height((0.6, angle)) / face.radius())
    };
    let level = heights(&mut harness);
    let set = |harness: &mut Harness<'static, Studio>, key: &str, value: f64| {
        let value = greenstick::schema::Value::Number(value);
        harness.state_mut().set(key, &value, false, 0.0);
    };
    set(&mut harness, "break.inclination", 30.0);
    let tilted = heights(&mut harness);
    assert_eq!(grid(&harness), painted);
    // The steepest line goes up at the angle 0. The map of heights is of what splinters reach, cell by cell.
    let slope = 0.6 * 30f32.to_radians().tan();
    for (k, angle) in [0.0f32, 1.5, 3.0, 4.5].into_iter().enumerate() {
        let off = tilted[k] - level[k] - slope * angle.cos();
        assert!(off.abs() < 0.15, "{angle}: {tilted:?} {level:?}");
    }
    let (saved, bytes) = saved_and_broken(&mut harness, &folder);
    assert_eq!(saved, harness.state().project.file);
    assert!(bytes == exported(&harness), "not the command line's bytes");
}

#[test]
fn a_stroke_over_the_bark_says_where_it_breaks() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    harness.key_press(Key::B);
    harness.run_steps(2);
    harness.state_mut().paint.brush = Brush {
        kind: BrushKind::Break,
        size: 0.5,
        strength: 1.0,
    };
    let radius = harness.state().report().unwrap().place.radius_m;
    // The bark that faces who looks: below the rim at an angle at which it is nearest to the bottom of the picture.
    let angles = (0..24).map(|i| f64::from(i) * std::f64::consts::TAU / 24.0);
    let rim: Vec<(f64, Pos2)> = angles
        .map(|a| (a, place(&mut harness, 1.0, a as f32)))
        .collect();
    let (angle, edge) = rim
        .into_iter()
        .max_by(|a, b| a.1.y.total_cmp(&b.1.y))
        .unwrap();
    let from = edge + eframe::egui::vec2(0.0, 40.0);
    drag(&mut harness, from, from + eframe::egui::vec2(8.0, 0.0));
    let painted = grid(&harness);
    let at_bark: Vec<f64> = middles(&painted)
        .zip(&painted.values)
        .filter(|((rho, phi), _)| *rho > 0.95 && (phi - angle).cos() > 0.98)
        .map(|(_, height)| *height)
        .collect();
    let lowest = at_bark.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest < -0.3 * radius, "{at_bark:?}");
    // The rim of the break is where the stroke was.
    let rim = place(&mut harness, 1.0, angle as f32);
    assert!(rim.y > edge.y + 12.0, "{rim} {edge}");
}

/// Seconds that this thread has worked, whatever else the machine does; wall time where the system does not tell.
fn worked() -> f64 {
    let said = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = said.and_then(|s| s.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |n| 1e-9 * n)
}

static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);

/// A stroke in twelve steps, between which answers are drawn; no update may take the window's thread longer than a tenth of a second.
fn stroke_held(harness: &mut Harness<'static, Studio>, from: Pos2, to: Pos2, held: Modifiers) {
    harness.event(eframe::egui::Event::PointerMoved(from));
    harness.step();
    let button = |pos, pressed| eframe::egui::Event::PointerButton {
        pos,
        button: eframe::egui::PointerButton::Primary,
        pressed,
        modifiers: held,
    };
    let (mut longest, mut most): (f64, f64) = (0.0, 0.0);
    let mut update = |harness: &mut Harness<'static, Studio>| {
        let (start, before) = (Instant::now(), worked());
        harness.step();
        longest = longest.max(start.elapsed().as_secs_f64());
        most = most.max(worked() - before);
    };
    // A step is an update for each event that waits: one at a time, as each is to be measured.
    let send = |harness: &mut Harness<'static, Studio>,
                event,
                update: &mut dyn FnMut(&mut Harness<'static, Studio>)| {
        let keys = eframe::egui::Event::ModifiersChanged;
        for event in [keys(held), event, keys(Modifiers::NONE)] {
            harness.event(event);
            update(harness);
        }
    };
    send(harness, button(from, true), &mut update);
    for i in 0..=12 {
        let pos = from + (to - from) * (i as f32 / 12.0);
        send(harness, eframe::egui::Event::PointerMoved(pos), &mut update);
        // Between two moves answers come, and a pointer that rests paints nothing; keys are held for the moves alone.
        let painted = grid(harness);
        for _ in 0..4 {
            std::thread::sleep(std::time::Duration::from_millis(20));
            update(harness);
            assert!(grid(harness) == painted, "painted without a move");
        }
    }
    send(harness, button(to, false), &mut update);
    let begun = Instant::now();
    while harness.state().is_busy() && begun.elapsed().as_secs() < 300 {
        std::thread::sleep(std::time::Duration::from_millis(10));
        update(harness);
    }
    settle(harness);
    println!(
        "longest update {:.1} ms, of which the thread worked at most {:.1} ms",
        1e3 * longest,
        1e3 * most
    );
    assert!(most < 0.1, "{most}");
}

#[test]
fn painting_a_fine_face_leaves_the_window_quick() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    for key in ["break.rings", "break.sectors"] {
        let value = greenstick::schema::Value::Integer(200);
        harness.state_mut().set(key, &value, false, 0.0);
    }
    settle(&mut harness);
    harness.key_press(Key::Num7);
    harness.key_press(Key::B);
    harness.run_steps(2);
    let (from, to) = (place(&mut harness, 0.3, 4.0), place(&mut harness, 0.8, 4.0));
    stroke_held(&mut harness, from, to, Modifiers::NONE);
    assert!(harness.state().project.painted(0).is_some());
}

#[test]
fn a_stroke_with_ctrl_does_the_opposite_and_beside_the_stem_the_picture_turns() {
    let folder = Folder::new();
    let mut harness = painting(&folder);
    let corner = eframe::egui::pos2(330.0, 640.0);
    drag(&mut harness, corner, corner + eframe::egui::vec2(3.0, 0.0));
    assert_eq!(harness.state().project.file, RequestFile::default());
    harness.state_mut().paint.brush.kind = BrushKind::Splinter;
    harness.state_mut().paint.brush.strength = 1.0;
    let (from, to) = (place(&mut harness, 0.3, 4.0), place(&mut harness, 0.8, 4.0));
    // Wood is crushed where it was made blunt again and again.
    for (from, to) in [(from, to), (to, from)] {
        stroke_held(&mut harness, from, to, Modifiers::COMMAND);
    }
    let blunt = grid(&harness);
    let crushed = blunt.modes.iter().filter(|m| **m == FailureMode::Crushed);
    let crushed = crushed.count();
    assert!(crushed > 3, "{crushed}");
    let [here, there] = sides(&blunt, &blunt.splintering, 4.0);
    assert!(here < 0.5 && there == 1.0, "{here} {there}");
}
