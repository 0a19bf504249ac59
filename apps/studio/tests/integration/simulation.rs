//! Simulations: run beside the window, played, drawn as rods and as wood, stopped, and taken as a still break.

use crate::common::{Folder, drag, settle, studio};
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use greenstick::RequestFile;
use greenstick_studio::model::holds::HoldPart;
use greenstick_studio::model::simulation::{Look, Source};
use greenstick_studio::ui::studio::Studio;
use std::time::{Duration, Instant};

/// A rod that tears within a second or two of work.
pub const TORN: &str = "about = 'a rod is torn'\nduration = 0.5\nframes_per_second = 20.0\nfor_length = '15 cm'\n\
    solver = 'interactive'\n[stem]\nkind = 'cylinder'\nlength = '15 cm'\ndiameter = '1 cm'\n[failure]\nevery = 8\n\
    [rods]\nnumber = 24\nedge = ['6 mm', '9 mm']\nweibull = 12.0\n[[clamp]]\nto = 0.06\n[[clamp]]\nfrom = 0.94\nto = 1.0\n\
    velocity = [0.01, 0.0, 0.0]\n";

/// Writes a scene into a folder; returns its path.
pub fn scene(folder: &Folder, text: &str) -> String {
    let path = folder.0.join("torn.toml");
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn middle(studio: &Studio) -> f32 {
    let drawn = studio.simulation().unwrap().drawn.as_ref().unwrap();
    let sum: f32 = drawn.1.vertices.iter().map(|v| v.position[0].abs()).sum();
    sum / drawn.1.vertices.len() as f32
}

fn errors(harness: &Harness<'_, Studio>) -> usize {
    let messages = harness.state().messages();
    messages.iter().filter(|m| m.is_error).count()
}

#[test]
fn a_scene_is_simulated_played_and_taken_as_a_break_that_projects_keep() {
    let folder = Folder::new();
    let mut harness = studio(&folder, Some(&scene(&folder, TORN)));
    settle(&mut harness);
    assert_eq!(errors(&harness), 0, "{:?}", harness.state().messages());
    let simulation = harness.state().simulation().unwrap();
    assert_eq!(simulation.about, "a rod is torn");
    assert_eq!(simulation.frames(), 11);
    let outcome = simulation.outcome.as_ref().unwrap();
    assert!(outcome.broke && outcome.report.contains("outcome"));
    let fact = |name: &str| outcome.facts.iter().any(|f| f.0 == name);
    assert!(fact("Mode") && fact("Greatest load") && fact("Pieces"));
    assert!(!simulation.recorded.load.lines.is_empty());
    assert!(simulation.recorded.energy.lines.len() > 4);
    assert_eq!(simulation.wood, Some(Ok(())));
    // The last frame is shown; at first the rod was shorter.
    let end = middle(harness.state());
    harness.get_by_label("Rods").click();
    settle(&mut harness);
    assert_eq!(harness.state().simulation().unwrap().look, Look::Rods);
    let rods = middle(harness.state());
    assert!((rods / end - 1.0).abs() < 0.5, "{rods} {end}");
    harness.key_press(Key::ArrowLeft);
    settle(&mut harness);
    assert_eq!(harness.state().simulation().unwrap().shown.unwrap().0, 9);
    assert!(middle(harness.state()) < rods);
    // From the end, it plays from the start to the end.
    harness.key_press(Key::ArrowRight);
    harness.key_press(Key::Space);
    harness.step();
    assert!(harness.state().simulation().unwrap().playback.playing);
    settle(&mut harness);
    assert_eq!(harness.state().simulation().unwrap().shown.unwrap().0, 10);

    harness.get_by_label("Take this break").click();
    settle(&mut harness);
    assert!(harness.state().simulation().is_none());
    assert_eq!(errors(&harness), 0, "{:?}", harness.state().messages());
    let report = harness.state().report().unwrap();
    assert!((report.place.stem_length_m - 0.15).abs() < 0.01);
    assert!(report.pieces.len() >= 2);
    assert!(harness.state().project.is_changed());
    let triangles = harness.state().triangles();
    // What is not saved survives the end of the program, with the stem that has no file.
    eframe::App::on_exit(harness.state_mut());
    let kept = folder.0.join("config/unsaved.greenstick.toml");
    let mut recovered = studio(&folder, Some(kept.to_str().unwrap()));
    settle(&mut recovered);
    assert_eq!(errors(&recovered), 0, "{:?}", recovered.state().messages());
    assert_eq!(recovered.state().triangles(), triangles);
    assert!(recovered.state().project.is_changed());
    let project = folder.0.join("torn.greenstick.toml");
    harness.state_mut().save_as(project.to_str().unwrap());
    assert!(!harness.state().project.is_changed());
    let text = std::fs::read_to_string(&project).unwrap();
    let recipe = RequestFile::resolve(&[], Some(&text), &[]).unwrap();
    assert_eq!(recipe.input.as_deref(), Some("torn_stem.glb"));
    assert!(folder.0.join("torn_stem.glb").is_file());
    let mut again = studio(&folder, Some(project.to_str().unwrap()));
    settle(&mut again);
    assert_eq!(errors(&again), 0, "{:?}", again.state().messages());
    assert_eq!(again.state().triangles(), triangles);
}

#[test]
fn a_simulation_is_stopped_and_left_and_the_window_stays_awake() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let triangles = harness.state().triangles();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::M);
    harness.run_steps(2);
    harness.get_by_label("three-blocks").click();
    harness.run_steps(2);
    harness.get_by_label("Start").click();
    let start = Instant::now();
    let mut longest = Duration::ZERO;
    let frames = |h: &Harness<'_, Studio>| h.state().simulation().map_or(0, |s| s.frames());
    while frames(&harness) < 3 {
        assert!(start.elapsed() < Duration::from_secs(200), "no frames");
        let before = Instant::now();
        harness.step();
        longest = longest.max(before.elapsed());
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(longest < Duration::from_secs(1), "{longest:?}");
    harness.key_press(Key::Escape);
    settle(&mut harness);
    // What was recorded stays to be looked at.
    let simulation = harness.state().simulation().unwrap();
    assert!(simulation.outcome.is_none() && simulation.drawn.is_some());
    assert_eq!(
        simulation.source,
        Source::BuiltIn("three-blocks".to_owned())
    );
    harness.get_by_label("Back to the break").click();
    settle(&mut harness);
    assert!(harness.state().simulation().is_none());
    assert_eq!(harness.state().triangles(), triangles);
    assert_eq!(errors(&harness), 0);
}

#[test]
fn the_stem_at_hand_is_simulated_and_its_break_is_one_step() {
    let folder = Folder::new();
    let mesh = folder.0.join("rod.glb");
    let rod = greenstick::wood::primitive::cylinder(0.006, 0.2, 24);
    let node = greenstick::geometry::Node::new("rod", glam::DAffine3::IDENTITY, rod);
    let made = greenstick::geometry::Scene {
        nodes: vec![node],
        ..greenstick::geometry::Scene::default()
    };
    let unit = greenstick::formats::LengthUnit::Metre;
    let outputs = greenstick::files::encode(&made, &mesh, unit).unwrap();
    greenstick::files::write_all(&outputs).unwrap();
    let mut harness = studio(&folder, Some(mesh.to_str().unwrap()));
    settle(&mut harness);
    let before = harness.state().project.file.clone();
    let source = Source::File(scene(&folder, TORN));
    harness.state_mut().begin_simulation(source, true);
    settle(&mut harness);
    assert_eq!(errors(&harness), 0, "{:?}", harness.state().messages());
    assert!(harness.state().simulation().unwrap().outcome.is_some());
    harness.get_by_label("Take this break").click();
    settle(&mut harness);
    assert_eq!(errors(&harness), 0, "{:?}", harness.state().messages());
    assert_eq!(harness.state().project.input.file_name(), Some("rod.glb"));
    assert_ne!(harness.state().project.file, before);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, before);
}

#[test]
fn a_scene_with_a_mistake_gives_a_message_and_leaves_the_break() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let path = folder.0.join("scene.toml");
    std::fs::write(&path, TORN.replace("'cylinder'", "'cylindre'")).unwrap();
    harness.state_mut().open(path.to_str().unwrap());
    settle(&mut harness);
    harness.run_steps(10);
    let messages = harness.state().messages();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].is_error && messages[0].text.contains("scene.toml"));
    assert!(messages[0].text.contains("cylindre"), "{messages:?}");
    assert!(harness.state().simulation().is_none() && harness.state().report().is_some());
}

#[test]
fn a_clamp_is_dragged_along_the_stem_and_the_wood_is_moved_anew() {
    let folder = Folder::new();
    // It is simulated five times.
    let few = TORN.replace("number = 24", "number = 9");
    let mut harness = studio(&folder, Some(&scene(&folder, &few)));
    settle(&mut harness);
    let part = HoldPart::ClampTo(0);
    let at = |harness: &Harness<'static, Studio>| {
        let holds = &harness.state().simulation().unwrap().holds;
        holds.iter().find(|h| h.part == part).unwrap().at
    };
    let report = |harness: &Harness<'static, Studio>| {
        let outcome = harness.state().simulation().unwrap().outcome.clone();
        outcome.unwrap().report
    };
    let before = report(&harness);
    // Handles are those of the first frame.
    assert!(harness.state().hold_dot(part).is_none());
    harness.get_by_label("To the first frame").click();
    harness.run_steps(3);
    settle(&mut harness);
    assert_eq!(harness.state().simulation().unwrap().shown.unwrap().0, 0);
    let dot = |harness: &Harness<'static, Studio>, part| harness.state().hold_dot(part).unwrap();
    let [base, held, tip] =
        [HoldPart::ClampFrom(0), part, HoldPart::ClampTo(1)].map(|part| dot(&harness, part));
    // The dots lie on the stem in proportion.
    let share = (held - base).length() / (tip - base).length();
    assert!((share - 0.06).abs() < 0.02, "{share}");
    let end = base + (tip - base) * 0.3;
    drag(&mut harness, held, end);
    assert_eq!(errors(&harness), 0, "{:?}", harness.state().messages());
    let moved = at(&harness);
    assert!((0.2..0.45).contains(&moved), "{moved}");
    assert_eq!(harness.state().simulation().unwrap().frames(), 11);
    assert!(report(&harness) != before);
    // The dot is where it was let go.
    harness.get_by_label("To the first frame").click();
    harness.run_steps(3);
    settle(&mut harness);
    let now = dot(&harness, part);
    assert!(now.distance(end) < 4.0, "{now} {end}");
    // A scene that is saved is the one that was simulated.
    let saved = folder.0.join("moved.toml");
    harness.state_mut().save_scene(saved.to_str().unwrap());
    let text = std::fs::read_to_string(&saved).unwrap();
    let setting = greenstick::fibre::scene::Scene::read(&text).unwrap();
    assert_eq!(setting.clamp[0].to, moved);
    let mut again = studio(&folder, Some(saved.to_str().unwrap()));
    settle(&mut again);
    assert_eq!(report(&again), report(&harness));
    // One step back, and forward again.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!((at(&harness), report(&harness)), (0.06, before));
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!(at(&harness), moved);
}
