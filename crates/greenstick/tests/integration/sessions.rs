//! A session with cached stages gives the same bits as a new one, after any change, in any thread.

use crate::support;
use greenstick::fracture::height_grid::HeightGrid;
use greenstick::fracture::heights::HeightSource;
use greenstick::fracture::presets::Preset;
use greenstick::fracture::recipe::apply_setting;
use greenstick::geometry::{CancelToken, Context, Scene};
use greenstick::skin::broken::BrokenFace;
use greenstick::wood::noise::unit;
use greenstick::wood::stem::StemLocation;
use greenstick::{Break, BreakRequest, BreakSession, BreakStage, Broken, built_in_branch};

fn request(settings: &[&str]) -> BreakRequest {
    let mut request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::default()
    };
    change(&mut request, settings);
    request
}

fn change(request: &mut BreakRequest, settings: &[&str]) {
    for setting in settings {
        apply_setting(&mut request.breaks[0], setting).unwrap();
    }
}

fn assert_same(a: &Broken, b: &Broken, what: &str) {
    assert_eq!(a.report, b.report, "{what}");
    assert_eq!(a.roles, b.roles, "{what}");
    assert!(a.scene == b.scene, "{what}: other scene");
}

#[test]
fn a_report_comes_back_from_json() {
    let mut session = BreakSession::new(built_in_branch());
    let asked = request(&["rings=8", "sectors=16", "species=white oak", "fray=0.4"]);
    let report = session.broken(&asked, &Context::quiet()).unwrap().report;
    let text = serde_json::to_string(&report).unwrap();
    let back: greenstick::BreakReport = serde_json::from_str(&text).unwrap();
    assert_eq!(back, report);
}

/// A change of a request, and the stage at which the session starts after it.
type Change = (&'static str, fn(&mut BreakRequest), Option<BreakStage>);

/// Changes of the location, the grain and the cells.
fn changes_of_the_stem() -> Vec<Change> {
    vec![
        ("nothing", |_| {}, None),
        (
            "slabs",
            |r| change(r, &["slab_height=1.3"]),
            Some(BreakStage::Heights),
        ),
        ("seed", |r| change(r, &["seed=5"]), Some(BreakStage::Layout)),
        (
            "place",
            |r| r.breaks[0].place = StemLocation::Fraction(0.4),
            Some(BreakStage::Stem),
        ),
        (
            "spiral grain",
            |r| change(r, &["spiral_angle=12"]),
            Some(BreakStage::Stem),
        ),
        (
            "slabs in it",
            |r| change(r, &["slab_height=1.1"]),
            Some(BreakStage::Stem),
        ),
        (
            "straight grain",
            |r| change(r, &["spiral_angle=0"]),
            Some(BreakStage::Layout),
        ),
    ]
}

/// Changes of the wood, of what happens to the pieces, and of where heights come from.
fn changes_of_the_pieces() -> Vec<Change> {
    vec![
        (
            "species",
            |r| change(r, &["species=temple juniper"]),
            Some(BreakStage::Heights),
        ),
        (
            "moisture",
            |r| change(r, &["moisture=25"]),
            Some(BreakStage::Heights),
        ),
        (
            "hang",
            |r| change(r, &["hang=30"]),
            Some(BreakStage::Heights),
        ),
        (
            "no hang",
            |r| change(r, &["hang=0"]),
            Some(BreakStage::Heights),
        ),
        ("fray", |r| r.breaks[0].fray = 0.5, Some(BreakStage::Finish)),
        (
            "no fray",
            |r| r.breaks[0].fray = 0.0,
            Some(BreakStage::Finish),
        ),
        (
            "cracks",
            |r| cracks(r, "crack_groups.end=break"),
            Some(BreakStage::Cut),
        ),
        (
            "cracks at the end",
            |r| cracks(r, "crack_groups.end=sawn"),
            Some(BreakStage::Stem),
        ),
        (
            "smooth",
            |r| change(r, &["surface=smooth"]),
            Some(BreakStage::Layout),
        ),
        (
            "apart",
            |r| r.breaks[0].separation = 0.02,
            Some(BreakStage::Finish),
        ),
        (
            "a field",
            |r| r.breaks[0].heights = steps(),
            Some(BreakStage::Heights),
        ),
    ]
}

/// One change after another, each of which starts at another stage or switches something on or off.
#[test]
fn a_session_after_changes_equals_a_new_one() {
    let mut now = request(&["rings=8", "sectors=16"]);
    let mut session = BreakSession::new(built_in_branch());
    let context = Context::quiet();
    session.broken(&now, &context).unwrap();
    let changes = changes_of_the_stem()
        .into_iter()
        .chain(changes_of_the_pieces());
    for (what, change, expected) in changes {
        change(&mut now);
        let cached = session.broken(&now, &context).unwrap();
        assert_eq!(session.started_at(), expected, "{what}");
        let fresh = BreakSession::new(built_in_branch()).broken(&now, &context);
        assert_same(&cached, &fresh.unwrap(), what);
    }
}

#[test]
fn a_walk_through_the_heights_equals_new_breaks() {
    const STEPS: i64 = 10;
    let keys: [(&str, f64, f64); 8] = [
        ("inclination", 0.0, 40.0),
        ("inclination_direction", 0.0, 360.0),
        ("high.height", 0.0, 1.0),
        ("sapwood.perlin_amplitude", 0.0, 0.5),
        ("bark.perlin_amplitude", 0.0, 0.3),
        ("slab_height", 0.0, 2.0),
        ("sliver_height", 0.0, 2.0),
        ("fibre_height", 0.0, 0.4),
    ];
    let context = Context::quiet();
    for style in ["surface=smooth", "surface=fibrous"] {
        let mut asked = request(&["rings=10", "sectors=20", style]);
        let mut sound = BreakSession::new(built_in_branch());
        sound.stem(&asked, &context).unwrap();
        let mut session = sound.fork();
        session.stages(&asked, &context).unwrap();
        for step in 0..STEPS {
            let random = |what: i64| unit(1, step, what, 0);
            let (key, low, high) = keys[(random(0) * keys.len() as f64) as usize];
            // Small changes, after which most stays, and jumps.
            let reach = [0.001, 0.03, 1.0][(random(1) * 3.0) as usize];
            let value = low + (high - low) * (0.3 + 0.7 * reach * random(2));
            change(&mut asked, &[&format!("{key}={value}")]);
            let walked = session.stages(&asked, &context).unwrap();
            let new = sound.fork().stages(&asked, &context).unwrap();
            let (walked, new) = (&walked.cut.face, &new.cut.face);
            let face = |f: &BrokenFace| {
                let face = f.face.clone();
                (face.positions, face.normals, face.coordinates, face.ids)
            };
            assert_eq!(face(walked), face(new), "{style} {key}={value}");
            assert_eq!(walked.face.triangles, new.face.triangles);
            assert_eq!(walked.patch.parts, new.patch.parts);
            assert_eq!(walked.patch.whole, new.patch.whole);
        }
    }
}

fn cracks(request: &mut BreakRequest, end: &str) {
    let recipe = &mut request.breaks[0].recipe;
    let fig20 = Preset::find("fig20").unwrap();
    fig20
        .apply(&mut recipe.face.clone(), &mut recipe.cracks)
        .unwrap();
    change(request, &[end]);
}

/// Heights that rise in steps around the stem.
fn steps() -> HeightGrid {
    HeightGrid {
        sectors: 6,
        values: (0..6).map(|i| 0.004 * f64::from(i)).collect(),
        ..HeightGrid::default()
    }
}

#[test]
fn a_height_field_is_where_the_stem_breaks() {
    let mut request = request(&["surface=smooth", "rings=20", "sectors=60"]);
    request.breaks[0].heights = steps();
    let mut session = BreakSession::new(built_in_branch());
    let stages = session.stages(&request, &Context::quiet()).unwrap();
    let HeightSource::Field(field) = steps().source().unwrap() else {
        unreachable!()
    };
    let place = stages.stem.stem().found.stem.location;
    let surface = &stages.heights.heights.surface;
    let layout = &surface.layout;
    for (facet, heights) in layout.facets.iter().zip(&surface.heights) {
        for (&node, height) in facet.iter().zip(heights) {
            let (rho, phi) = stages.layout.bundles.addresses[node as usize];
            assert!((height - place - field.at(rho, phi)).abs() < 1e-12);
        }
    }
    let whole = stages.stem.stem().node().mesh.volume();
    let parts: f64 = support::pieces(&stages, &request.breaks[0].recipe.face)
        .iter()
        .map(|m| m.volume())
        .sum();
    assert!((parts / whole - 1.0).abs() < 1e-9);
}

fn several(places: &[f64]) -> BreakRequest {
    let only = |(i, &at): (usize, &f64)| {
        let mut one = request(&[
            "rings=8",
            "sectors=16",
            "slab_height=0.3",
            "sliver_height=0.2",
            "splinter_lean=0",
            "splinter_snap=0",
        ]);
        change(&mut one, &[&format!("seed={i}")]);
        Break {
            place: StemLocation::Fraction(at),
            separation: 0.03,
            part_clear: false,
            ..one.breaks.remove(0)
        }
    };
    BreakRequest {
        breaks: places.iter().enumerate().map(only).collect(),
        texture_width: 16,
        ..BreakRequest::default()
    }
}

#[test]
fn a_stem_breaks_at_several_places_into_pieces_in_order() {
    // In any order in the request.
    let request = several(&[0.5, 0.8, 0.2]);
    let mut session = BreakSession::new(built_in_branch());
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let names: Vec<&str> = broken.scene.nodes.iter().map(|n| &*n.name).collect();
    assert_eq!(names[..4], ["piece_0", "piece_1", "piece_2", "piece_3"]);
    let report = &broken.report;
    let mut sum = 0.0;
    for (piece, node) in report.pieces.iter().zip(&broken.scene.nodes) {
        assert!(piece.closed, "{report}");
        assert_eq!(node.mesh.check().self_intersections.unwrap().crossing, 0);
        sum += piece.volume_m3.unwrap();
    }
    assert!((sum / report.input.volume_m3.unwrap() - 1.0).abs() < 1e-6);
    // Each piece moves by the separations of all breaks below it.
    let moved = |i: usize| broken.scene.nodes[i].transform.translation.length();
    for (i, expected) in [0.0, 0.03, 0.06, 0.09].into_iter().enumerate() {
        assert!((moved(i) - expected).abs() < 0.01, "{}", moved(i));
    }
    // Faces lie where they were requested, and each has a material of its own.
    let place = |i: usize| match i {
        0 => &report.place,
        i => &report.further_breaks[i - 1].place,
    };
    let length = place(1).stem_length_m;
    assert!((place(1).length_m / length - 0.8).abs() < 0.01);
    let materials: Vec<u32> = broken.woods.iter().map(|w| w.material).collect();
    assert_eq!(materials, [2, 1, 3]);
    // Beside bark and three woods, sawn ends.
    assert_eq!(broken.scene.materials.len(), 5);
    // A change of the lowest break leaves the others as they are.
    let mut changed = request.clone();
    apply_setting(&mut changed.breaks[2], "slab_height=0.5").unwrap();
    let cached = session.broken(&changed, &Context::quiet()).unwrap();
    assert_eq!(session.started_at(), Some(BreakStage::Heights));
    let fresh = BreakSession::new(built_in_branch()).broken(&changed, &Context::quiet());
    assert_same(&cached, &fresh.unwrap(), "lowest break");
}

#[test]
fn breaks_on_different_stems_and_no_breaks_are_refused() {
    let branch = built_in_branch();
    let mut scene = branch.clone();
    let mut other = branch.nodes[0].clone();
    other.transform.translation.x += 1.0;
    scene.nodes.push(other);
    let mut request = several(&[0.5, 0.6]);
    let point = |x| StemLocation::Point(glam::DVec3::new(x, 0.3, 0.0));
    request.breaks[0].place = point(0.0);
    request.breaks[1].place = point(1.0);
    let refused = |scene: &Scene, request: &BreakRequest| {
        let mut session = BreakSession::new(scene.clone());
        session
            .broken(request, &Context::quiet())
            .unwrap_err()
            .to_string()
    };
    let text = refused(&scene, &request);
    assert!(text.contains("break 2"), "{text}");
    request.breaks.clear();
    let text = refused(&scene, &request);
    assert!(text.contains("at least 1"), "{text}");
}

#[test]
fn forks_work_side_by_side_and_give_the_same() {
    let mut session = BreakSession::new(built_in_branch());
    let context = Context::quiet();
    let seeded = |seed: u64| request(&["rings=8", "sectors=16", &format!("seed={seed}")]);
    session.broken(&seeded(0), &context).unwrap();
    let one_by_one: Vec<Broken> = (1..5)
        .map(|seed| session.broken(&seeded(seed), &context).unwrap())
        .collect();
    let forks: Vec<BreakSession> = (1..5).map(|_| session.fork()).collect();
    let side_by_side: Vec<Broken> = std::thread::scope(|scope| {
        let (context, seeded) = (&context, &seeded);
        let threads: Vec<_> = forks
            .into_iter()
            .zip(1..5)
            .map(|(mut fork, seed)| scope.spawn(move || fork.broken(&seeded(seed), context)))
            .collect();
        let done = threads.into_iter().map(|t| t.join().unwrap().unwrap());
        done.collect()
    });
    for (a, b) in one_by_one.iter().zip(&side_by_side) {
        assert_same(a, b, "fork");
    }
}

/// A context that cancels itself at the first report of a stage.
fn cancelled_in(stage: &'static str) -> Context {
    let token = CancelToken::default();
    let asking = token.clone();
    Context::new(token, move |progress| {
        if progress.stage.name() == stage {
            asking.cancel();
        }
    })
}

#[test]
fn a_cancelled_session_goes_on_where_it_was() {
    let request = request(&["rings=8", "sectors=16", "spiral_angle=10"]);
    let mut session = BreakSession::new(built_in_branch());
    let fresh = BreakSession::new(built_in_branch()).broken(&request, &Context::quiet());
    let fresh = fresh.unwrap();
    // A stage is told of when its work begins; what was made before is kept.
    for (cancelled, starts_at) in [
        ("cut", Some(BreakStage::Cut)),
        ("finish", Some(BreakStage::Finish)),
        ("textures", None),
    ] {
        let stopped = session.broken(&request, &cancelled_in(cancelled));
        assert!(stopped.is_err(), "{cancelled}");
        let broken = session.fork().broken(&request, &Context::quiet()).unwrap();
        assert_same(&broken, &fresh, cancelled);
        let mut session = session.fork();
        session.pieces(&request, &Context::quiet()).unwrap();
        assert_eq!(session.started_at(), starts_at, "{cancelled}");
    }
}
