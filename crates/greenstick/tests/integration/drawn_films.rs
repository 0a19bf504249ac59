//! Films of the mesh that was simulated, cut along the faces that the run decided: whole until the first rod breaks, with
//! pieces that keep their volume, move as their rods do and stay together where the wood holds.

use glam::DVec3;
use greenstick::fibre::scene::Scene as Setting;
use greenstick::film::{DrawnFilm, film_of_faces, open_run};
use greenstick::geometry::{Context, Mesh, Motion, Node, Pose, Scene};
use greenstick::simulate::{MemoryRun, SceneMeshes, SimulateRequest, simulate};
use greenstick::skin::{
    WoodField,
    film::{FilmOptions, Run, shows_well},
    view::{FilmView, close_up, close_up_of_frame},
};
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

const NO_MESHES: SceneMeshes = SceneMeshes {
    input: None,
    bodies: Vec::new(),
};

/// Simulates a scene in memory.
fn recorded(scene: Setting) -> Arc<MemoryRun> {
    let request = SimulateRequest {
        scene,
        meshes: NO_MESHES,
        resume: false,
    };
    let mut store = MemoryRun::new();
    simulate(&request, &mut store, &Context::quiet()).unwrap();
    Arc::new(store)
}

fn opened(store: Arc<MemoryRun>) -> Run {
    open_run(store, &NO_MESHES, &Context::quiet()).unwrap()
}

/// The built-in `pull`, whose ends are drawn 5 mm apart: what came loose of either side is still beside it.
fn pulled() -> Run {
    static STORE: LazyLock<Arc<MemoryRun>> = LazyLock::new(|| {
        let mut setting = Setting::built_in("pull").unwrap();
        setting.clamp[1].key[2].move_by = [5e-3, 0.0, 0.0];
        recorded(setting)
    });
    opened(STORE.clone())
}

fn options() -> FilmOptions {
    FilmOptions {
        texture_width: 0,
        bodies: false,
        ..FilmOptions::default()
    }
}

fn film(run: &mut Run) -> DrawnFilm {
    let frames = run.frames();
    film_of_faces(run, 0..frames, &options(), &Context::quiet()).unwrap()
}

/// The vertices of two meshes that are in the same place.
fn pairs(lower: &Mesh, upper: &Mesh) -> Vec<(usize, usize)> {
    let key = |p: &DVec3| p.to_array().map(f64::to_bits);
    let numbered = lower.positions.iter().enumerate();
    let places: BTreeMap<_, usize> = numbered.map(|(v, p)| (key(p), v)).collect();
    let numbered = upper.positions.iter().enumerate();
    numbered
        .filter_map(|(v, p)| Some((*places.get(&key(p))?, v)))
        .collect()
}

/// The meshes of a frame.
fn at(film: &mut DrawnFilm, frame: usize) -> Vec<Mesh> {
    let scene: Scene = film.skinned.at(frame).unwrap();
    let nodes = scene.nodes.iter();
    nodes.map(|node| (*node.mesh).clone()).collect()
}

/// The distances between pairs of vertices, m, ascending.
fn distances(meshes: &[Mesh], pairs: &[(usize, usize)]) -> Vec<f64> {
    let far = |&(a, b): &(usize, usize)| meshes[0].positions[a].distance(meshes[1].positions[b]);
    let mut all: Vec<f64> = pairs.iter().map(far).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// The first frame in which a rod is broken.
fn first_break(run: &Run) -> usize {
    let whole = run.frame(0).unwrap().parent.len();
    let broken = |&n: &usize| run.frame(n).unwrap().parent.len() > whole;
    (0..run.frames()).find(broken).unwrap()
}

#[test]
fn wood_that_is_pulled_apart_is_whole_until_it_breaks_and_then_moves_as_its_rods() {
    let mut run = pulled();
    let (first, last) = (first_break(&run), run.frames() - 1);
    assert!(first > 2);
    let mut film = film(&mut run);
    assert!(film.reports[0].parted);
    let solids = film.skinned.film.pieces.iter().filter(|p| !p.is_detail);
    let rest: Vec<Mesh> = solids.map(|p| p.mesh.clone()).collect();
    assert!(rest.len() == 2 && rest.iter().all(|mesh| mesh.check().is_solid()));
    let pairs = pairs(&rest[0], &rest[1]);
    assert!(pairs.len() > 1000);
    for frame in 0..first {
        let off = distances(&at(&mut film, frame), &pairs)[pairs.len() - 1];
        assert!(off < 1e-12, "{off} m in frame {frame}");
    }
    // Each side keeps its volume, but for the strain.
    let moved = at(&mut film, last);
    for (mesh, rest) in moved.iter().zip(&rest) {
        let part = mesh.volume() / rest.volume();
        assert!((part - 1.0).abs() < 0.02, "{part}");
    }
    // Beside the face, where all rods are of one side, each side moves as the rods next to it.
    let on_face = || pairs.iter().map(|&(v, _)| rest[0].positions[v].x);
    let face = [
        on_face().fold(f64::INFINITY, f64::min) - 0.01,
        on_face().fold(f64::NEG_INFINITY, f64::max) + 0.01,
    ];
    let upright = |p: [f32; 3]| {
        let [x, y, z] = p.map(f64::from);
        DVec3::new(x, z, -y)
    };
    let (before, after) = (run.frame(0).unwrap(), run.frame(last).unwrap());
    for (mesh, rest) in moved.iter().zip(&rest) {
        let (mut off, mut moves) = (Vec::new(), Vec::new());
        let beside = |v: &usize| !(face[0]..face[1]).contains(&rest.positions[*v].x);
        for v in (0..rest.positions.len()).filter(beside).step_by(7) {
            let (p, q) = (rest.positions[v], mesh.positions[v]);
            let at_rest = |&i: &usize| upright(before.position[after.origin[i] as usize]);
            let nearest = (0..after.origin.len())
                .min_by(|a, b| at_rest(a).distance(p).total_cmp(&at_rest(b).distance(p)))
                .unwrap();
            let rod = upright(after.position[nearest]) - at_rest(&nearest);
            off.push(rod.distance(q - p));
            moves.push(rod.length());
        }
        for list in [&mut off, &mut moves] {
            list.sort_by(f64::total_cmp);
        }
        let (off, most) = (off[off.len() / 2], moves[moves.len() * 9 / 10]);
        assert!(off < 2e-4, "{off} of {most} m");
    }
    let opened = distances(&moved, &pairs)[pairs.len() / 2];
    assert!(opened > 4e-3, "{opened}");
}

#[test]
fn fields_on_the_skin_are_those_of_the_rods_beside_it() {
    let mut run = pulled();
    let mut film = film(&mut run);
    let near = run.nearby_rods(&film.skinned.film);
    let mut at_start = film.skinned.at(0).unwrap();
    let mut on_skin = |of_rods: &[f64]| {
        near.set_field(WoodField::Strain, of_rods, &mut at_start.nodes);
        let nodes = at_start.nodes.iter().take(2);
        let values = |node: &Node| {
            let values = node.mesh.attributes["_STRAIN"].data.clone();
            values.into_iter().zip(node.mesh.positions.clone())
        };
        nodes.flat_map(values).collect::<Vec<_>>()
    };
    let start = run.frame(0).unwrap();
    // Positions in frames have single precision: 1e-8 m on edges of 5 mm, and strains at failure of 1 %.
    for field in [WoodField::Strain, WoodField::Damage] {
        let values = on_skin(&run.field(field, &start));
        assert!(values.iter().all(|(v, _)| v.abs() < 1e-3));
    }
    // Fields that say where rods are: along the stem to within half an edge of 7 mm, across it to within the distance of rods.
    let rest = &run.wood().bundle.rest;
    let ones = on_skin(&vec![1.0; rest.len()]);
    assert!(ones.iter().all(|(v, _)| (v - 1.0).abs() < 1e-5));
    let spacing = run.wood().spacing();
    let along = on_skin(&(0..rest.len()).map(|v| rest.get(v).x).collect::<Vec<_>>());
    let across = on_skin(&(0..rest.len()).map(|v| rest.get(v).z).collect::<Vec<_>>());
    for ((x, p), (y, _)) in along.iter().zip(&across) {
        assert!((f64::from(*x) - p.x).abs() < 3.5e-3, "{x} at {p}");
        assert!((f64::from(*y) - p.y).abs() < spacing, "{y} at {p}");
    }
}

#[test]
fn skin_that_is_not_where_its_rods_are_is_noticed_and_close_ups_show_the_break() {
    let mut run = pulled();
    let mut film = film(&mut run);
    assert!(film.misplaced_share(&run).unwrap() < 1e-3);
    let (at_rest, start) = (film.skinned.at(0).unwrap(), run.frame(0).unwrap());
    let mut moved = at_rest.clone();
    for node in &mut moved.nodes {
        // By the diameter of the stem.
        let mesh = Arc::make_mut(&mut node.mesh);
        mesh.positions.iter_mut().for_each(|p| p.y += 0.01);
    }
    let share = |scene: &Scene| run.misplaced_share(&film.skinned.film, &start, &scene.nodes);
    assert_eq!((share(&at_rest), share(&moved)), (0.0, 1.0));
    // What the rods do not fill, as the rest of a tree, is not asked after.
    let far = [DVec3::Y, DVec3::Y + DVec3::X, DVec3::Y + DVec3::Z];
    let mut with_more = at_rest.clone();
    let shown = Arc::make_mut(&mut with_more.nodes[0].mesh);
    shown.positions.extend(far.map(|p| p + DVec3::X));
    let mesh = &mut film.skinned.film.pieces[0].mesh;
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(far);
    mesh.triangles.push([first, first + 1, first + 2]);
    let share = run.misplaced_share(&film.skinned.film, &start, &with_more.nodes);
    assert_eq!(share, 0.0);
    // A close-up of three diameters of 1 cm about the break.
    let inner = film.broken.woods[0].material;
    let near = close_up(&at_rest, &[inner], 3.0).unwrap();
    assert!((near.1 / 0.015 - 1.0).abs() < 0.05, "{near:?}");
    let place = film.reports[0].place_m;
    assert!((near.0.x - place).abs() < 0.01, "{near:?} {place}");
    // Of pieces that lie apart, the larger one.
    let mut apart = at_rest.clone();
    for (node, by) in apart.nodes.iter_mut().zip([-0.5, 0.5]) {
        let mesh = Arc::make_mut(&mut node.mesh);
        mesh.positions.iter_mut().for_each(|p| p.x += by);
    }
    let volumes = [0, 1].map(|piece| apart.nodes[piece].mesh.volume());
    let by = if volumes[0] > volumes[1] { -0.5 } else { 0.5 };
    let (centre, radius) = close_up_of_frame(&apart, &[inner], 3.0).unwrap();
    assert!((centre.x - place - by).abs() < radius, "{centre} {place}");
    assert!((radius - near.1).abs() < 1e-12);
    let together = close_up_of_frame(&at_rest, &[inner], 3.0).unwrap();
    assert_eq!(together, near);
    // A film of both shows the break before, between the pieces, and both faces after.
    let mut view = FilmView::default();
    view.add(&at_rest, &[inner]);
    let still = view.close_up(Some(3.0)).unwrap();
    assert!(
        still.0.distance(near.0) < radius && still.1 < 1.5 * radius,
        "{still:?}"
    );
    // Where nothing is asked for, everything, unless that is much more than nine diameters about the break.
    assert_eq!(view.close_up(None), None);
    let mut larger = view.clone();
    larger.points.push(still.0 + DVec3::X);
    let usual = larger.close_up(None).unwrap();
    assert!((usual.1 / (3.0 * near.1) - 1.0).abs() < 1e-9, "{usual:?}");
    view.add(&apart, &[inner]);
    let (centre, radius) = view.close_up(Some(3.0)).unwrap();
    for x in [place - 0.5, place, place + 0.5] {
        assert!((centre.x - x).abs() < radius, "{centre} {radius} {x}");
    }
    assert!(radius < 0.5 + 2.0 * near.1, "{radius}");
    let middle = view.middle().unwrap();
    assert!((middle.x - place).abs() < 0.2, "{middle}");
}

#[test]
fn wood_in_two_is_shown_by_its_faces_though_a_split_runs_beyond_them() {
    for (misplaced, in_two, shown) in [
        (0.04, false, true),
        (0.06, false, false),
        (0.06, true, true),
        (0.2, true, false),
    ] {
        assert_eq!(shows_well(misplaced, in_two), shown);
    }
}

#[test]
fn a_range_of_frames_has_the_same_pieces_and_shows_the_same() {
    let mut run = pulled();
    let number = first_break(&run) + 1;
    let mut whole = film(&mut run);
    let mut one =
        film_of_faces(&mut run, number..number + 1, &options(), &Context::quiet()).unwrap();
    let (a, b) = (at(&mut whole, number), at(&mut one, 0));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        let both = a.positions.iter().zip(&b.positions);
        let off = both.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off}");
    }
}

#[test]
fn wood_that_is_broken_in_part_stays_together_at_a_hinge() {
    let mut setting = Setting::built_in("bend").unwrap();
    setting.duration = 0.2;
    let mut run = opened(recorded(setting));
    let mut film = film(&mut run);
    let report = &film.reports[0];
    assert!(!report.parted && report.broken > 4, "{report:?}");
    let whole = report.rods - report.broken;
    assert!(whole > 4, "{report:?}");
    let solids = film.skinned.film.pieces.iter().filter(|p| !p.is_detail);
    let rest: Vec<Mesh> = solids.map(|p| p.mesh.clone()).collect();
    assert!(rest.len() == 2 && rest.iter().all(|mesh| mesh.check().is_solid()));
    let pairs = pairs(&rest[0], &rest[1]);
    let moved = at(&mut film, run.frames() - 1);
    let apart = distances(&moved, &pairs);
    let share = |limit: f64| apart.partition_point(|&d| d < limit) as f64 / apart.len() as f64;
    // What holds touches, what is torn gapes.
    assert!(share(1e-9) > 0.03, "{}", share(1e-9));
    assert!(apart[apart.len() - 1] > 0.01);
    let mut poses = vec![Pose::IDENTITY; film.skinned.film.joints.len()];
    film.skinned.motion.poses(0, &mut poses).unwrap();
    assert!(poses.iter().all(Pose::is_sound));
}

#[test]
fn strands_of_torn_fibre_move_with_the_wood_that_they_are_peeled_off() {
    let mut run = pulled();
    let last = run.frames() - 1;
    let mut film = film(&mut run);
    let strands: Vec<usize> = (0..film.skinned.film.pieces.len())
        .filter(|&piece| film.skinned.film.pieces[piece].is_detail)
        .collect();
    let name = |piece: usize| film.skinned.film.pieces[piece].name.clone();
    let names: Vec<String> = strands.iter().map(|&piece| name(piece)).collect();
    assert_eq!(names, ["lower_fuzz", "upper_fuzz"]);
    let rest: Vec<Mesh> = (film.skinned.film.pieces.iter())
        .map(|p| p.mesh.clone())
        .collect();
    let scene = film.skinned.at(last).unwrap();
    for (piece, &fuzz) in strands.iter().enumerate() {
        assert!(scene.nodes[fuzz].is_detail && rest[fuzz].triangles.len() > 500);
        let moved = &scene.nodes[fuzz].mesh;
        // As far from the wood beside it as it was: the wood is drawn out by a hundredth at most.
        for v in (0..moved.positions.len()).step_by(29) {
            let at_rest = rest[fuzz].positions[v];
            let beside = (0..rest[piece].positions.len())
                .min_by(|&a, &b| {
                    let far = |i: usize| rest[piece].positions[i].distance_squared(at_rest);
                    far(a).total_cmp(&far(b))
                })
                .unwrap();
            let before = at_rest - rest[piece].positions[beside];
            let after = moved.positions[v] - scene.nodes[piece].mesh.positions[beside];
            let off = (after.length() - before.length()).abs();
            assert!(off < 1e-5 + 0.03 * before.length(), "{off} of {before}");
        }
        let edges = |mesh: &Mesh| -> Vec<f64> {
            let all = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
            all.map(|[a, b, _]| a.distance(b)).collect()
        };
        let both = edges(moved).into_iter().zip(edges(&rest[fuzz]));
        let drawn = both.filter(|(now, then)| (now / then - 1.0).abs() > 0.1);
        assert!(drawn.count() * 100 < rest[fuzz].triangles.len());
    }
}

#[test]
fn a_frame_on_its_base_is_that_of_the_film_with_the_base_where_it_was() {
    let mut run = pulled();
    let last = run.frames() - 1;
    let mut film = film(&mut run);
    let film_from_stem = run.film_from_stem();
    let shown = film.skinned.at(last).unwrap();
    let on_base = film.skinned.on_its_base(last, &film_from_stem).unwrap();
    assert_eq!(on_base.len(), shown.nodes.len());
    // What a rigid motion keeps.
    let places = |nodes: &[Node]| -> Vec<DVec3> {
        let of_node = |node: &Node| node.mesh.positions.clone();
        nodes.iter().flat_map(of_node).step_by(997).collect()
    };
    let (a, b) = (places(&shown.nodes), places(&on_base));
    for ((p, q), (r, s)) in a.iter().zip(&a[1..]).zip(b.iter().zip(&b[1..])) {
        assert!((p.distance(*q) - r.distance(*s)).abs() < 1e-12);
    }
    let rest = &film.broken.scene.nodes[0];
    let stem = run.stem();
    let (mut held, mut farthest) = (0, 0.0f64);
    for (v, &p) in rest.mesh.positions.iter().enumerate() {
        let p = rest.transform.transform_point3(p);
        // Within the clamp at the base.
        if stem.grain.axis().length_at(p) < 0.01 {
            farthest = farthest.max(on_base[0].mesh.positions[v].distance(p));
            held += 1;
        }
    }
    assert!(held > 40 && farthest < 1e-4, "{farthest} m of {held}");
}
