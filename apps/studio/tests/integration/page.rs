//! The work of the page's worker, without a browser: what crosses between the two as bytes stays the same.

use greenstick::RequestFile;
use greenstick::fibre::scene::Scene;
use greenstick::geometry::{CancelToken, Context, ImageSource};
use greenstick::simulate::{MemoryRun, RunSource, SimulateRequest, simulate};
use greenstick_studio::model::desk::Desk;
use greenstick_studio::model::engine::{Engine, Failure, Haste, Job, Shown};
use greenstick_studio::model::hand::{BY_HAND, add_hand};
use greenstick_studio::model::held::{HeldFile, read_input};
use greenstick_studio::model::holds::{HoldPart, Moved};
use greenstick_studio::model::input::{Input, InputContent};
use greenstick_studio::model::messages::{Answer, Ask, OpenedFiles, from_bytes, to_bytes};
use greenstick_studio::model::messages::{AskedSimulation, SimulationAsk};
use greenstick_studio::model::simulation::{Look, News, Outcome, Recorded, Source};
use std::path::Path;
use std::sync::{Arc, Mutex};

fn test_file(name: &str) -> HeldFile {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    HeldFile {
        name: name.to_owned(),
        bytes: std::fs::read(root.join(name)).unwrap(),
    }
}

/// Asks as the page does: through bytes, both ways.
fn ask(desk: &mut Desk, ask: &Ask, files: Vec<HeldFile>) -> (Option<Answer>, Vec<HeldFile>) {
    let bytes = to_bytes(ask).unwrap();
    let (answer, files) = {
        let asked = from_bytes(&bytes).unwrap();
        desk.answer(asked, files, &mut |_| {}, &Context::default())
    };
    let answer = answer.map(|a| from_bytes(&to_bytes(&a).unwrap()).unwrap());
    (answer, files)
}

fn shown(desk: &mut Desk, input: u64, request: &RequestFile) -> Result<Box<Shown>, Failure> {
    let question = Ask::Show {
        number: 7,
        input,
        request: request.to_toml(),
        haste: Haste::Whole,
        sections_of: None,
    };
    match ask(desk, &question, Vec::new()).0 {
        Some(Answer::Shown(7, shown)) => shown.map(|s| s.expect("the whole answer")),
        other => panic!("{other:?}"),
    }
}

fn opened(files: Vec<HeldFile>) -> Result<Box<OpenedFiles>, Failure> {
    match ask(&mut Desk::default(), &Ask::Open { unit: None }, files).0 {
        Some(Answer::Opened(opened)) => opened,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_picture_is_the_same_after_its_way_through_bytes() {
    let file = RequestFile::resolve(&["green-stick"], None, &["at=0.3"]).unwrap();
    let job = Job {
        input: Input::built_in(),
        file: file.clone(),
        haste: Haste::Whole,
        sections_of: None,
    };
    let direct = Engine::default().work(&job, &mut |_| {}, &Context::default());
    let direct = direct.unwrap().unwrap();
    let crossed = shown(&mut Desk::default(), 0, &file).unwrap();
    assert!(crossed.drawn.indices.len() > 3000);
    assert!(crossed.drawn == direct.drawn, "the meshes differ");
    assert_eq!(crossed.report, direct.report);
}

#[test]
fn a_photograph_comes_back_small_enough_to_be_shown() {
    // Wider than any card takes: every two pixels become one.
    let (width, height) = (2500, 3);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    let pixels: Vec<u8> = (0..width * height).flat_map(|_| [200, 100, 50]).collect();
    writer.write_image_data(&pixels).unwrap();
    writer.finish().unwrap();
    let read = |bytes: Vec<u8>| {
        let name = "branch.png".to_owned();
        let files = vec![HeldFile { name, bytes }];
        match ask(&mut Desk::default(), &Ask::Picture, files).0 {
            Some(Answer::Pictured(picture)) => picture,
            other => panic!("{other:?}"),
        }
    };
    let (width, height, rgb) = read(bytes).unwrap();
    assert_eq!((width, height), (1250, 2));
    assert!(rgb.chunks(3).all(|c| c == [200, 100, 50]));
    let failure = read(b"no picture".to_vec()).unwrap_err();
    assert!(
        failure.message.starts_with("branch.png: "),
        "{}",
        failure.message
    );
}

#[test]
fn a_file_that_is_held_is_broken_until_another_is() {
    let [tree, numbers] =
        [".gltf", ".bin"].map(|e| test_file(&format!("quaternius_DeadTree_1{e}")));
    let alone = opened(vec![tree.clone()]).unwrap_err();
    assert!(
        alone
            .message
            .contains("choose quaternius_DeadTree_1.bin together")
    );
    let found = opened(vec![numbers.clone(), tree.clone()]).unwrap();
    let (name, seen) = found.input.unwrap();
    assert!(name == tree.name && seen.unbroken.is_some_and(|d| d.indices.len() > 300));
    let mut desk = Desk::default();
    let unit = None;
    assert!(
        ask(
            &mut desk,
            &Ask::Hold { input: 5, unit },
            vec![numbers, tree]
        )
        .0
        .is_none()
    );
    let file = RequestFile::resolve(&[], None, &["at=0.1"]).unwrap();
    let report = shown(&mut desk, 5, &file).unwrap().report;
    assert!(report.place.radius_m > 0.05, "{:?}", report.place);
    assert!(
        shown(&mut desk, 6, &file)
            .unwrap_err()
            .message
            .contains("open it again")
    );
    let off = RequestFile::resolve(&[], None, &["at=900m"]).unwrap();
    assert!(shown(&mut desk, 5, &off).unwrap_err().place.is_some());
}

#[test]
fn what_is_no_mesh_is_said_and_a_project_asks_for_its_file() {
    let held = |name: &str, text: &str| HeldFile {
        name: name.to_owned(),
        bytes: text.as_bytes().to_vec(),
    };
    let bad = opened(vec![held("bad.glb", "no mesh")]).unwrap_err();
    assert!(bad.message.contains("bad.glb"), "{}", bad.message);
    let strange = opened(vec![held("letter.doc", "Dear")]).unwrap_err();
    assert!(strange.message.contains("letter.doc") && strange.message.contains("glb"));
    let project = held("p.greenstick.toml", "input = 'trees/tree.off'\nat = 0.4\n");
    let alone = opened(vec![project.clone()]).unwrap();
    assert_eq!(
        (alone.missing.as_deref(), alone.input.is_none()),
        (Some("tree.off"), true)
    );
    let mesh = held("tree.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let both = opened(vec![project, mesh]).unwrap();
    assert_eq!(
        (both.missing, both.input.unwrap().0),
        (None, "tree.off".to_owned())
    );
}

#[test]
fn textures_that_are_chosen_with_a_mesh_come_along() {
    let text = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let held = |name: &str, bytes: &[u8]| HeldFile {
        name: name.to_owned(),
        bytes: bytes.to_vec(),
    };
    let png = std::fs::read(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/pictures/presets/brash.png"),
    );
    let mesh = held("t.obj", text.as_bytes());
    let material = held("t.mtl", b"newmtl m\nmap_Kd textures/a.png\n");
    let input = read_input(
        &[material.clone(), mesh.clone(), held("a.png", &png.unwrap())],
        None,
    );
    let InputContent::Mesh(scene) = &*input.unwrap().content.clone() else {
        panic!("no mesh")
    };
    assert!(matches!(scene.images[0].source, ImageSource::Bytes(_)));
    let without = read_input(&[mesh, material], None).unwrap();
    assert!(
        without.notes.iter().any(|n| n.contains("a.png")),
        "{:?}",
        without.notes
    );
}

#[test]
fn pieces_equal_those_of_the_command_line() {
    let name = "quaternius_DeadTree_1.gltf";
    let settings = ["at=0.1", "texture_size=256"];
    let request = RequestFile::resolve(&["brash"], None, &settings).unwrap();
    let export = Ask::Export {
        request: request.to_toml(),
        path: "broken.glb".to_owned(),
    };
    let (answer, files) = ask(
        &mut Desk::default(),
        &export,
        vec![test_file(name), test_file("quaternius_DeadTree_1.bin")],
    );
    assert!(matches!(answer, Some(Answer::Exported(Ok(names))) if names == ["broken.glb"]));
    // As the program does: read, broken with its provenance, encoded.
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data")
        .join(name);
    let scene = greenstick::files::read(&path, None).unwrap();
    let context = Context::default();
    let mut broken = greenstick::break_scene(scene, &request.request(), &context).unwrap();
    broken.scene.metadata = request.provenance(Some(name), None).metadata();
    let expected = greenstick::files::encode(
        &broken.scene,
        Path::new("broken.glb"),
        request.unit.unwrap_or_default(),
    );
    assert!(
        files[0].bytes == expected.unwrap()[0].bytes,
        "the bytes differ"
    );
}

/// A simulation that is asked for: a stem that a hand bends until it breaks.
fn pulled(number: u64, by: f64) -> AskedSimulation {
    let hand = Moved {
        part: HoldPart::Hand,
        at: 0.9,
        by: [0.0, by, 0.0],
        before: Vec::new(),
    };
    AskedSimulation {
        number,
        source: Source::ByHand,
        input: 0,
        place: None,
        own: false,
        moved: vec![hand],
    }
}

/// What is told of a simulation until it is over or has so many frames, and how often it rested on the way.
fn moved(desk: &mut Desk, first: SimulationAsk, most: usize) -> (Vec<News>, usize) {
    let (mut all, mut rests) = (Vec::new(), 0);
    let reached = Arc::new(Mutex::new(Vec::new()));
    let mut next = first;
    loop {
        let asked = from_bytes(&to_bytes(&Ask::Simulation(next)).unwrap()).unwrap();
        let mut early = |answer: Answer| match from_bytes(&to_bytes(&answer).unwrap()).unwrap() {
            Answer::Simulated(_, news) => all.push(*news),
            other => panic!("{other:?}"),
        };
        let context = {
            let reached = reached.clone();
            Context::new(CancelToken::default(), move |p| {
                reached.lock().unwrap().push(p.overall);
            })
        };
        let (answer, _) = desk.answer(asked, Vec::new(), &mut early, &context);
        let count = |news: &News| match news {
            News::Recorded(recorded) => recorded.times.len(),
            _ => 0,
        };
        let frames = all.iter().map(count).max().unwrap_or(0);
        match answer {
            Some(Answer::Rested(_, false)) if frames < most => rests += 1,
            Some(Answer::Rested(..)) => {
                let reached = reached.lock().unwrap();
                assert!(reached.is_sorted(), "progress ran backwards: {reached:?}");
                let steps = reached.windows(2).map(|w| w[1] - w[0]);
                let jump = steps.fold(0.0, f64::max);
                assert!(jump < 0.5, "progress jumped by {jump}");
                return (all, rests);
            }
            other => panic!("{other:?}"),
        }
        next = SimulationAsk::GoOn;
    }
}

fn outcome(all: &[News]) -> &Outcome {
    let ended = all.iter().find_map(|news| match news {
        News::Ended(Ok(outcome)) => Some(outcome),
        _ => None,
    });
    ended.unwrap_or_else(|| panic!("{all:?}"))
}

fn last_recorded(all: &[News]) -> &Recorded {
    let last = all.iter().rev().find_map(|news| match news {
        News::Recorded(recorded) => Some(recorded),
        _ => None,
    });
    last.unwrap_or_else(|| panic!("{all:?}"))
}

#[test]
fn a_simulation_of_single_frames_is_that_of_the_command_line() {
    let asked = pulled(3, -0.15);
    let mut setting = Scene::read(BY_HAND).unwrap();
    add_hand(&mut setting, &asked.moved[0]);
    let request = SimulateRequest {
        scene: setting,
        ..SimulateRequest::default()
    };
    let mut alone = MemoryRun::default();
    let report = simulate(&request, &mut alone, &Context::quiet()).unwrap();

    let mut desk = Desk::default();
    let begin = SimulationAsk::Begin(asked.clone());
    let (all, rests) = moved(&mut desk, begin, usize::MAX);
    assert_eq!(last_recorded(&all).times, alone.frames().unwrap().times);
    assert!(rests > 20, "{rests}");
    let seen = outcome(&all);
    assert!(seen.broke);
    // The clock is no part of it.
    let told = |report: &str| {
        let lines = report.lines().filter(|l| !l.starts_with("time"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(told(&seen.report), told(&report.to_string()));
    assert!(
        matches!(all.last(), Some(News::Wood(_))),
        "{:?}",
        all.last()
    );

    // Its frames are drawn, and its break is taken with the stem that the scene made.
    let draw = Ask::Simulation(SimulationAsk::Draw(rests / 2, Look::Rods));
    match ask(&mut desk, &draw, Vec::new()).0 {
        Some(Answer::Simulated(3, news)) => match *news {
            News::Frame(_, Look::Rods, frame) => assert!(frame.scene.indices.len() > 3000),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
    let take = Ask::Simulation(SimulationAsk::Take(9));
    let (Some(Answer::Taken(3, taken)), files) = ask(&mut desk, &take, Vec::new()) else {
        panic!("no break was taken");
    };
    assert_eq!(files.len(), 1);
    let stem = Answer::Opened(opened(files.clone()));
    assert!(matches!(stem, Answer::Opened(Ok(_))));
    let taken = taken.unwrap().taken(files[0].bytes.clone()).unwrap();
    assert!(taken.input.is_some() && taken.request.breaks.len() == 1);
}

#[test]
fn a_hand_that_is_steered_between_two_frames_pulls_elsewhere_from_there_on() {
    let mut desk = Desk::default();
    moved(&mut desk, SimulationAsk::Begin(pulled(1, -0.1)), 5);
    let steer = Ask::Simulation(SimulationAsk::Steer([0.0, 0.0, 0.05]));
    let (hand, way) = match ask(&mut desk, &steer, Vec::new()).0 {
        Some(Answer::Simulated(1, news)) => match *news {
            News::Steered(hand, way) => (hand, way),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    };
    assert_eq!(hand.by, [0.0, 0.0, 0.05]);
    assert_eq!(hand.before.len(), 1);
    assert!(
        way[4].1[1] < 0.0 && way[way.len() - 1].1 == hand.by,
        "{way:?}"
    );
    let (steered, _) = moved(&mut desk, SimulationAsk::GoOn, 12);
    let alone = AskedSimulation {
        moved: vec![hand],
        ..pulled(2, 0.0)
    };
    let (begun, _) = moved(&mut Desk::default(), SimulationAsk::Begin(alone), 12);
    let [steered, begun] = [&steered, &begun].map(|all| last_recorded(all));
    assert_eq!(steered.times.len(), 12);
    assert_eq!(steered, begun);
}
