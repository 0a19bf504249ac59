//! Pulling on the wood of a simulation with the pointer; pausing the run and stepping through it.

use crate::common::{Folder, drag, settle, studio};
use eframe::egui::{Key, Modifiers, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use greenstick::built_in_branch;
use greenstick::fibre::EventKind;
use greenstick::fibre::scene::{Scene, StemChoice};
use greenstick::files::read_text;
use greenstick::geometry::Context;
use greenstick::simulate::{MemoryRun, RunSource, SimulateRequest, simulate};
use greenstick_studio::model::holds::HoldPart;
use greenstick_studio::model::simulation::Source;
use greenstick_studio::ui::studio::Studio;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// A stick of few rods that is held at its base.
const HELD: &str = "about = 'a stick is held'\nduration = 0.5\nframes_per_second = 20.0\nfor_length = '15 cm'\n\
    solver = 'interactive'\n[stem]\nkind = 'cylinder'\nlength = '15 cm'\ndiameter = '1 cm'\n[failure]\nevery = 8\n\
    [rods]\nnumber = 9\nedge = ['6 mm', '9 mm']\nweibull = 12.0\n[loads]\ndamping = 5.0\n[[clamp]]\nto = 0.08\n";

type Window = Harness<'static, Studio>;

fn errors(harness: &Window) -> Vec<&str> {
    let messages = harness.state().messages();
    let errors = messages.iter().filter(|m| m.is_error);
    errors.map(|m| &*m.text).collect()
}

fn hand(harness: &Window) -> Option<(f64, [f64; 3])> {
    let holds = &harness.state().simulation().unwrap().holds;
    let hand = holds.iter().find(|h| h.part == HoldPart::Hand);
    hand.map(|h| (h.at, h.by))
}

fn frames(harness: &Window) -> usize {
    harness.state().simulation().unwrap().frames()
}

fn report(harness: &Window) -> String {
    let outcome = harness.state().simulation().unwrap().outcome.clone();
    outcome.unwrap().report
}

fn broke(harness: &Window) -> bool {
    let outcome = &harness.state().simulation().unwrap().outcome;
    outcome.as_ref().unwrap().broke
}

/// Triangles that a frame of the simulation shows.
fn simulated_triangles(harness: &Window) -> usize {
    let drawn = &harness.state().simulation().unwrap().drawn;
    drawn.as_ref().unwrap().1.indices.len() / 3
}

fn first_frame(harness: &mut Window) {
    harness.get_by_label("To the first frame").click();
    harness.run_steps(3);
    settle(harness);
    assert_eq!(harness.state().simulation().unwrap().shown.unwrap().0, 0);
}

/// Steps until something is so.
fn wait(harness: &mut Window, so: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    while !so(harness) {
        assert!(start.elapsed() < Duration::from_secs(200), "it never was");
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The rods that broke, as the window counts them.
fn broken_rods(harness: &Window) -> String {
    let outcome = harness.state().simulation().unwrap().outcome.as_ref();
    let mut facts = outcome.unwrap().facts.iter();
    facts.find(|f| f.0 == "Broken rods").unwrap().1.clone()
}

/// The report on a scene as the command line simulates it, and the rods that broke of all, each once.
fn simulated_alone(scene: Scene) -> (String, String) {
    let request = SimulateRequest {
        scene,
        ..SimulateRequest::default()
    };
    let mut run = MemoryRun::new();
    let report = simulate(&request, &mut run, &Context::quiet()).unwrap();
    let events = run.events().unwrap().into_iter();
    let breaks = events.filter(|e| e.kind == EventKind::RodBroke);
    let rods: BTreeSet<u32> = breaks.map(|e| e.rod).collect();
    let counted = format!("{} of {}", rods.len(), report.rods);
    (report.to_string(), counted)
}

#[test]
fn wood_is_pulled_until_it_breaks_and_the_saved_scene_is_the_same_for_the_command_line() {
    let folder = Folder::new();
    let path = folder.0.join("held.toml");
    std::fs::write(&path, HELD).unwrap();
    let mut harness = studio(&folder, Some(path.to_str().unwrap()));
    settle(&mut harness);
    let still = report(&harness);
    assert!(!broke(&harness));
    first_frame(&mut harness);
    let place = |harness: &Window, at| harness.state().stem_place(at).unwrap();
    let [base, from] = [0.0, 0.9].map(|at| place(&harness, at));
    // Before pulling is switched on, a drag turns the picture.
    drag(&mut harness, from, from + Vec2::new(0.0, 40.0));
    assert_eq!(hand(&harness), None);
    drag(&mut harness, from + Vec2::new(0.0, 40.0), from);
    harness.key_press(Key::L);
    harness.run_steps(2);
    // Where the wood is held it cannot be pulled.
    let held = base + (from - base) * (0.13 / 0.9);
    drag(&mut harness, held, held + Vec2::new(0.0, 60.0));
    assert_eq!(hand(&harness), None);
    // A hand that hardly moves is none.
    drag(&mut harness, from, from + Vec2::new(0.0, 1.0));
    assert_eq!((hand(&harness), report(&harness)), (None, still.clone()));

    let across = Vec2::new(from.y - base.y, base.x - from.x) * 0.6;
    let to = from + across;
    drag(&mut harness, from, to);
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    let (at, by) = hand(&harness).unwrap();
    assert!((at - 0.9).abs() < 0.02, "{at}");
    let way = by[1].hypot(by[2]);
    assert!(by[0] == 0.0 && (0.2..0.66).contains(&way), "{by:?}");
    assert_eq!(frames(&harness), 11);
    let pulled = report(&harness);
    assert!(broke(&harness));
    // Its dot is where it was let go: the drag was in the plane of the picture.
    first_frame(&mut harness);
    let dot = harness.state().hold_dot(HoldPart::Hand).unwrap();
    let held_back = (dot - from).length() / (to - from).length();
    assert!((0.5..1.02).contains(&held_back), "{dot} {to}");

    let saved = folder.0.join("pulled.toml");
    harness.state_mut().save_scene(saved.to_str().unwrap());
    let text = read_text(&saved).unwrap();
    let scene = Scene::read(&text).unwrap();
    assert_eq!(
        (scene.clamp.len(), scene.clamp[1].axes.to_string()),
        (2, "yz".to_owned())
    );
    assert_eq!(
        simulated_alone(scene),
        (pulled.clone(), broken_rods(&harness))
    );

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!((hand(&harness), report(&harness)), (None, still));
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!((hand(&harness), report(&harness)), (Some((at, by)), pulled));
}

#[test]
fn a_hand_tears_the_stem_at_hand_and_its_break_is_one_step() {
    let folder = Folder::new();
    let path = folder.0.join("held.toml");
    std::fs::write(&path, HELD).unwrap();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let before = harness.state().project.file.clone();
    let source = Source::File(path.display().to_string());
    harness.state_mut().begin_simulation(source, true);
    settle(&mut harness);
    harness.key_press(Key::L);
    harness.run_steps(2);
    // At another frame the drag only goes back to the first.
    let middle = harness.state().viewport_middle().unwrap();
    drag(&mut harness, middle, middle + Vec2::new(0.0, 60.0));
    assert_eq!(hand(&harness), None);
    assert_eq!(harness.state().simulation().unwrap().shown.unwrap().0, 0);
    // Along the stem.
    let [from, tip] = [0.85, 1.0].map(|at| harness.state().stem_place(at).unwrap());
    drag(&mut harness, from, from + (tip - from) * 0.6);
    let (_, by) = hand(&harness).unwrap();
    assert!(by[0] > 0.03 && by[1] == 0.0 && by[2] == 0.0, "{by:?}");
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    let saved = folder.0.join("pulled.toml");
    harness.state_mut().save_scene(saved.to_str().unwrap());
    let scene = Scene::read(&read_text(&saved).unwrap()).unwrap();
    // The built-in branch has no file: the scene makes it.
    assert_eq!(scene.stem.kind, StemChoice::Branch);
    assert_eq!(scene.clamp[1].axes.to_string(), "xyz");
    assert_eq!(
        simulated_alone(scene),
        (report(&harness), broken_rods(&harness))
    );
    harness.get_by_label("Take this break").click();
    settle(&mut harness);
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    assert!(harness.state().project.input.is_built_in());
    assert!(harness.state().report().unwrap().pieces.len() >= 2);
    assert_ne!(harness.state().project.file, before);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(harness.state().project.file, before);
}

/// Drags from a place of the window, in steps, as a hand would.
fn pull(harness: &mut Window, from: Pos2, by: Vec2) {
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=6 {
        harness.hover_at(from + by * (i as f32 / 6.0));
        harness.step();
    }
    harness.drop_at(from + by);
    harness.step();
}

#[test]
fn a_pull_is_steered_while_it_runs_and_the_saved_scene_is_the_same_run() {
    let folder = Folder::new();
    let path = folder.0.join("held.toml");
    std::fs::write(&path, HELD.replace("0.5", "1.0")).unwrap();
    let mut harness = studio(&folder, Some(path.to_str().unwrap()));
    settle(&mut harness);
    first_frame(&mut harness);
    harness.key_press(Key::L);
    harness.run_steps(2);
    let from = harness.state().stem_place(0.9).unwrap();
    pull(&mut harness, from, Vec2::new(0.0, 50.0));
    // It is held at once, and let go on by single frames: on a slow machine the window sees the run less often than it makes frames.
    harness.key_press(Key::Space);
    harness.run_steps(2);
    settle(&mut harness);
    std::thread::sleep(Duration::from_millis(300));
    settle(&mut harness);
    while frames(&harness) < 4 {
        let seen = frames(&harness);
        harness.key_press(Key::ArrowRight);
        wait(&mut harness, |h| frames(h) > seen);
        settle(&mut harness);
    }
    let (at, first) = hand(&harness).unwrap();
    let seen = frames(&harness);
    assert!(seen < 20, "the run is over");
    // The hand is where it has got to by now, between where it took hold and where it pulls to.
    let dot = harness.state().hold_dot(HoldPart::Hand).unwrap();
    let way = (dot.y - from.y) / 50.0;
    let part = (seen - 1) as f32 / 20.0;
    assert!((way / part - 1.0).abs() < 0.35, "{way} {part}");
    // Other dots are not there.
    assert!(harness.state().hold_dot(HoldPart::ClampTo(0)).is_none());
    pull(&mut harness, dot, Vec2::new(0.0, -140.0));
    harness.step();
    wait(&mut harness, |h| frames(h) > seen);
    settle(&mut harness);
    // It waited before, and waits again after a frame.
    assert!(harness.state().simulation().unwrap().paused);
    assert_eq!(frames(&harness), seen + 1);
    let holds = &harness.state().simulation().unwrap().holds;
    let steered = holds.iter().find(|h| h.part == HoldPart::Hand).unwrap();
    assert_eq!((steered.before.len(), steered.before[0].by), (1, first));
    let frame = steered.before[0].frame as usize;
    assert!((seen - 1..=seen).contains(&frame), "{frame} of {seen}");
    assert!(steered.at == at && steered.by[2] > first[2], "{steered:?}");
    harness.get_by_label("Go on").click();
    harness.run_steps(2);
    settle(&mut harness);
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    let bent = report(&harness);
    let saved = folder.0.join("steered.toml");
    harness.state_mut().save_scene(saved.to_str().unwrap());
    let scene = Scene::read(&read_text(&saved).unwrap()).unwrap();
    let keys = &scene.clamp[1].key;
    assert!(keys.len() > 20 && keys[frame].move_by[2] < 0.0);
    assert!(keys.last().unwrap().move_by[2] > keys[frame].move_by[2]);
    assert_eq!(
        simulated_alone(scene),
        (bent.clone(), broken_rods(&harness))
    );
    // Steering is a step of its own: without it the wood is moved anew, to where the hand pulled first.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(hand(&harness), Some((at, first)));
    assert_eq!(frames(&harness), 21);
    assert_ne!(report(&harness), bent);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut harness);
    assert_eq!(report(&harness), bent);
}

/// The hand's earlier pulls: the frames until which it pulled there.
fn steered_at(harness: &Window) -> Vec<u32> {
    let holds = &harness.state().simulation().unwrap().holds;
    let hand = holds.iter().find(|h| h.part == HoldPart::Hand).unwrap();
    hand.before.iter().map(|s| s.frame).collect()
}

/// Asserts that the scene as it is saved gives the same run on the command line.
fn assert_saved_is_same(harness: &mut Window, folder: &Folder, name: &str) {
    assert!(errors(harness).is_empty(), "{:?}", errors(harness));
    let saved = folder.0.join(name);
    harness.state_mut().save_scene(saved.to_str().unwrap());
    let scene = Scene::read(&read_text(&saved).unwrap()).unwrap();
    let shown = (report(harness), broken_rods(harness));
    assert_eq!(simulated_alone(scene), shown, "{name}");
}

#[test]
fn a_pull_is_steered_after_its_end_and_from_a_frame_that_is_scrubbed_to() {
    let folder = Folder::new();
    let path = folder.0.join("held.toml");
    std::fs::write(&path, HELD).unwrap();
    let mut harness = studio(&folder, Some(path.to_str().unwrap()));
    settle(&mut harness);
    first_frame(&mut harness);
    harness.key_press(Key::L);
    harness.run_steps(2);
    let [base, from] = [0.0, 0.9].map(|at| harness.state().stem_place(at).unwrap());
    drag(&mut harness, from, from + Vec2::new(0.0, 50.0));
    let pulled = report(&harness);
    let (at, first) = hand(&harness).unwrap();
    assert_eq!((frames(&harness), steered_at(&harness)), (11, Vec::new()));
    // The run is over, and its last frame is shown: a drag anywhere over the wood takes the hand along.
    let dot = harness.state().hold_dot(HoldPart::Hand).unwrap();
    let wood = dot + (base - dot).normalized() * 14.0;
    drag(&mut harness, wood, wood + Vec2::new(0.0, -90.0));
    let (still_at, second) = hand(&harness).unwrap();
    let seen = (dot, base, harness.state().simulation().unwrap().shown);
    assert!(
        still_at == at && second[2] > first[2],
        "{second:?} {first:?} {seen:?}"
    );
    let last = steered_at(&harness);
    assert!(last == [10] && frames(&harness) > 11, "{last:?}");
    let on = (frames(&harness), report(&harness));
    assert_ne!(on.1, pulled);
    assert_saved_is_same(&mut harness, &folder, "on.toml");
    // Back at the sixth frame, by its dot.
    first_frame(&mut harness);
    for _ in 0..5 {
        harness.key_press(Key::ArrowRight);
        harness.run_steps(2);
        settle(&mut harness);
    }
    let dot = harness.state().hold_dot(HoldPart::Hand).unwrap();
    drag(&mut harness, dot, dot + Vec2::new(0.0, 70.0));
    let frame = steered_at(&harness);
    assert!(frame == [5] || frame == [6], "{frame:?}");
    let (_, third) = hand(&harness).unwrap();
    assert!(third[2] < first[2], "{third:?} {first:?}");
    assert_saved_is_same(&mut harness, &folder, "back.toml");
    // Each is a step.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!((frames(&harness), report(&harness)), on);
    assert_eq!(steered_at(&harness), last);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!((frames(&harness), report(&harness)), (11, pulled));
}

#[test]
fn the_stem_at_hand_is_pulled_live_paused_and_stepped() {
    let folder = Folder::new();
    let mut harness = studio(&folder, None);
    settle(&mut harness);
    let triangles = harness.state().triangles();
    harness.key_press(Key::L);
    harness.run_steps(2);
    settle(&mut harness);
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    assert_eq!(frames(&harness), 1);
    // Before anything breaks, the stem is seen as it is.
    let whole: usize = built_in_branch()
        .nodes
        .iter()
        .map(|n| n.mesh.triangles.len())
        .sum();
    assert_eq!(simulated_triangles(&harness), whole);
    let from = harness.state().stem_place(0.85).unwrap();
    // What is dragged runs at once; the pointer is let go without waiting for the end.
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=6 {
        harness.hover_at(from + Vec2::new(0.0, 30.0 * i as f32));
        harness.step();
    }
    harness.drop_at(from + Vec2::new(0.0, 180.0));
    harness.run_steps(2);
    wait(&mut harness, |h| frames(h) >= 2);
    harness.key_press(Key::Space);
    harness.run_steps(2);
    assert!(harness.state().simulation().unwrap().paused);
    // The frame that was being worked out may still come, and no other.
    std::thread::sleep(Duration::from_secs(2));
    harness.run_steps(3);
    let paused = frames(&harness);
    std::thread::sleep(Duration::from_secs(2));
    harness.run_steps(3);
    assert_eq!(frames(&harness), paused);
    harness.key_press(Key::ArrowRight);
    wait(&mut harness, |h| frames(h) == paused + 1);
    settle(&mut harness);
    assert_eq!(
        harness.state().simulation().unwrap().shown.unwrap().0,
        paused
    );
    // Back among what is recorded, the run waits on.
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(2);
    settle(&mut harness);
    assert_eq!(
        harness.state().simulation().unwrap().shown.unwrap().0,
        paused - 1
    );
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    harness.get_by_label("Go on").click();
    wait(&mut harness, |h| frames(h) >= paused + 2);
    harness.key_press(Key::Space);
    harness.run_steps(2);
    // A run that waits is stopped, too.
    harness.key_press(Key::Escape);
    wait(&mut harness, |h| {
        let busy = h.state().is_busy();
        !busy
            && h.query_by_label("The simulation was stopped before its end.")
                .is_some()
    });
    harness.get_by_label("Back to the break").click();
    settle(&mut harness);
    assert_eq!(harness.state().triangles(), triangles);
    assert!(errors(&harness).is_empty());
}

#[test]
fn what_cannot_be_pulled_says_why() {
    let folder = Folder::new();
    let path = folder.0.join("arc.toml");
    let arc = HELD.replace("[[clamp]]\nto = 0.08\n", "")
        + "[[clamp]]\nto = 0.06\narc = true\nkey = [{ time = 0.0 }, { time = 0.5, turn = [0, 1, 0] }]\n\
           [[clamp]]\nfrom = 0.94\nto = 1.0\narc = true\nkey = [{ time = 0.0 }, { time = 0.5, turn = [0, -1, 0] }]\n";
    std::fs::write(&path, arc).unwrap();
    let mut harness = studio(&folder, Some(path.to_str().unwrap()));
    settle(&mut harness);
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    harness.key_press(Key::L);
    harness.run_steps(2);
    let said = errors(&harness);
    assert!(
        said.len() == 1 && said[0].contains("arc") && said[0].contains("Choose"),
        "{said:?}"
    );
    let from = harness.state().stem_place(0.5);
    assert!(from.is_none() && hand(&harness).is_none());

    // A scan has no mesh yet. What its break says is another matter.
    let scan = folder.0.join("scan.xyz");
    let points = (0..4000).map(|i| {
        let (angle, height) = (f64::from(i) * 2.4, f64::from(i) * 5e-4);
        format!(
            "{:.4} {:.4} {height:.4}\n",
            0.1 * angle.cos(),
            0.1 * angle.sin()
        )
    });
    std::fs::write(&scan, points.collect::<String>()).unwrap();
    let mut harness = studio(&folder, Some(scan.to_str().unwrap()));
    settle(&mut harness);
    harness.key_press(Key::L);
    harness.run_steps(2);
    assert!(harness.state().simulation().is_none());
    let said = errors(&harness);
    assert!(
        said.iter().any(|m| m.contains("Export its bark")),
        "{said:?}"
    );
}
