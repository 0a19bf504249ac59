//! What a film has besides the skin of its rods: the rest of the input, of which nothing is lost and which moves with what
//! it hangs on; plain nodes for what moves as a whole; collision shapes and levels of detail.

use glam::{DAffine3, DVec3};
use greenstick::fibre::scene::Scene as Setting;
use greenstick::film::{film_of_faces, open_run};
use greenstick::geometry::convex::is_convex;
use greenstick::geometry::{Bvh, Context, ConvexOptions, Mesh, Motion, Node, Pose, Scene};
use greenstick::simulate::{MemoryRun, SceneMeshes, SimulateRequest, simulate};
use greenstick::skin::film::{FilmOptions, Run, SkinnedFilm, collision, level};
use greenstick::wood::primitive;
use std::sync::Arc;

const RADIUS: f64 = 3e-3;
const LENGTH: f64 = 0.1;
/// Where the trunk has its side branch.
const BRANCH: f64 = 0.025;
const LEAF: DVec3 = DVec3::new(0.0, 0.085, 5e-3);

const SCENE: &str = "duration = 0.02\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"input\"\nat = \"0.6\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nname = \"press\"\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n";

fn node(name: &str, mesh: Mesh, at: DVec3) -> Node {
    Node {
        name: name.into(),
        transform: DAffine3::from_translation(at),
        mesh: mesh.into(),
        parent: None,
        is_detail: false,
    }
}

/// A trunk whose side branch is of the same surface: one of its squares drawn out.
fn trunk() -> Mesh {
    let mut mesh = primitive::cylinder(RADIUS, LENGTH, 24);
    mesh.attributes.clear();
    let middle = |t: &[u32; 3]| t.iter().map(|&v| mesh.positions[v as usize]).sum::<DVec3>() / 3.0;
    let goal = DVec3::new(RADIUS, BRANCH, 0.0);
    let mut order: Vec<[u32; 3]> = mesh.triangles.clone();
    order.sort_by(|a, b| {
        middle(a)
            .distance(goal)
            .total_cmp(&middle(b).distance(goal))
    });
    let first = order[0];
    let second = *order[1..]
        .iter()
        .find(|t| t.iter().filter(|v| first.contains(v)).count() == 2)
        .unwrap();
    let own = second.iter().copied().find(|v| !first.contains(v)).unwrap();
    let k = (0..3).find(|&k| !second.contains(&first[k])).unwrap();
    // Counter-clockwise from outside.
    let mut ring = vec![first[k], first[(k + 1) % 3], own, first[(k + 2) % 3]];
    mesh.triangles.retain(|t| *t != first && *t != second);
    for _ in 0..20 {
        let next = mesh.positions.len() as u32;
        for &v in &ring {
            let p = mesh.positions[v as usize] + DVec3::X * 1e-3;
            mesh.positions.push(p);
        }
        for k in 0..4 {
            let (a, b) = (ring[k], ring[(k + 1) % 4]);
            let (c, d) = (next + (k as u32 + 1) % 4, next + k as u32);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        ring = (next..next + 4).collect();
    }
    mesh.triangles
        .extend([[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]);
    assert!(mesh.check().is_solid());
    mesh
}

fn input() -> Scene {
    let small = primitive::cylinder(5e-4, 2e-3, 8);
    Scene {
        nodes: vec![
            node("tree", trunk(), DVec3::new(0.2, 0.1, 0.0)),
            node("leaf", small.clone(), LEAF + DVec3::new(0.2, 0.1, 0.0)),
            node("stone", small, DVec3::new(5.0, 0.0, 0.0)),
        ],
        ..Scene::default()
    }
}

/// Simulates the scene in memory.
fn run() -> Run {
    run_of(Setting::read(SCENE).unwrap())
}

fn run_of(scene: Setting) -> Run {
    let request = SimulateRequest {
        scene,
        meshes: SceneMeshes {
            input: Some(input()),
            bodies: Vec::new(),
        },
        resume: false,
    };
    let context = Context::quiet();
    let mut store = MemoryRun::new();
    simulate(&request, &mut store, &context).unwrap();
    open_run(Arc::new(store), &request.meshes, &context).unwrap()
}

fn options(rest: bool) -> FilmOptions {
    FilmOptions {
        texture_width: 0,
        bodies: false,
        rest,
        ..FilmOptions::default()
    }
}

fn piece<'a>(film: &'a SkinnedFilm, name: &str) -> (usize, &'a Mesh) {
    let at = film.film.pieces.iter().position(|p| p.name == name);
    let at = at.unwrap_or_else(|| panic!("no {name}: {:?}", film.report.rest));
    (at, &film.film.pieces[at].mesh)
}

/// Returns how far a point is from the nearest joint of the rods, where joint `j` is at `position(j)`, m.
fn rod_distance(film: &SkinnedFilm, position: impl Fn(usize) -> DVec3, p: DVec3) -> f64 {
    let joints = film.film.joints.iter().enumerate();
    let rods = joints.filter(|(_, joint)| joint.name.starts_with("vertex"));
    rods.map(|(j, _)| position(j).distance(p))
        .fold(f64::INFINITY, f64::min)
}

/// The corners of the box about all nodes.
fn corners(nodes: &[Node]) -> [DVec3; 2] {
    let points = nodes.iter().flat_map(|node| {
        let at = |p: &DVec3| node.transform.transform_point3(*p);
        node.mesh.positions.iter().map(at).collect::<Vec<_>>()
    });
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
        [low.min(p), high.max(p)]
    })
}

#[test]
fn a_film_of_an_input_is_where_its_mesh_is() {
    let input = input();
    let turned = |p: DVec3| DVec3::new(p.x, p.z, -p.y);
    for up in ["y", "z"] {
        let kept = format!("kind = \"input\"\nup = \"{up}\"");
        let text = SCENE.replace("kind = \"input\"", &kept);
        let mut run = run_of(Setting::read(&text).unwrap());
        let film = run.film(0..1, &options(true), &Context::quiet());
        let first = film.unwrap().at(0).unwrap();
        let expected = |nodes: &[Node]| {
            let [low, high] = corners(nodes);
            match up {
                "y" => [low, high],
                // Turned to have y up.
                _ => [turned(low).min(turned(high)), turned(low).max(turned(high))],
            }
        };
        let off = |found: &[Node], source: &[Node]| {
            let both = corners(found).into_iter().zip(expected(source));
            both.map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
        };
        let named = |name: &str| {
            let node = first.nodes.iter().find(|node| node.name == name);
            std::slice::from_ref(node.unwrap())
        };
        let stone = off(named("standing_000"), &input.nodes[2..]);
        assert!(stone < 1e-12, "{up}: {stone} m");
        // The skin of the rods leaves out a little at the ends.
        let all = off(&first.nodes, &input.nodes);
        assert!(all < 0.1 * RADIUS, "{up}: {all} m");
    }
}

#[test]
fn a_stem_stands_in_its_film_as_its_scene_says() {
    for (inclination, along) in [
        (0.0, DVec3::X),
        (90.0, DVec3::Y),
        (30.0, DVec3::new(0.75f64.sqrt(), 0.5, 0.0)),
    ] {
        let text = SCENE.replace(
            "kind = \"input\"\nat = \"0.6\"",
            &format!("kind = \"cylinder\"\ninclination = {inclination}"),
        );
        let run = run_of(Setting::read(&text).unwrap());
        // Cylinders grow along y.
        let way = run.film_from_stem().transform_vector3(DVec3::Y);
        assert!(way.distance(along) < 1e-9, "{way}");
        let laid = run.along_x();
        let way = laid.film_from_stem().transform_vector3(DVec3::Y);
        assert!(way.distance(DVec3::X) < 1e-9, "{way}");
    }
}

#[test]
fn lines_of_rods_and_bonds_are_all_there_beside_breaks_between_vertices_too() {
    let run = run();
    let mut broke = false;
    for number in 0..run.frames() {
        let frame = run.frame(number).unwrap();
        let (rods, bonds) = (run.rod_lines(&frame), run.bond_lines(&frame));
        broke |= rods.parts.iter().any(|&part| part > 0);
        assert_eq!(rods.parts.len(), frame.parent.len());
        assert_eq!(bonds.stretch.len(), frame.bonds.len(), "frame {number}");
        assert_eq!(bonds.points.len(), 2 * frame.bonds.len());
        let longest = bonds.stretch.iter().copied().fold(0.0, f64::max);
        assert!(longest < 2.0, "frame {number}: {longest}");
        // Wood tears at 1 % of strain; an edge that a break shortens by up to a half is not crushed by that.
        let greatest = rods.strains.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        assert!(greatest < 0.05, "frame {number}: {greatest}");
    }
    assert!(broke);
}

#[test]
fn nothing_of_the_input_is_lost_and_twigs_move_with_their_rods() {
    let mut run = run().along_x();
    let context = Context::quiet();
    let frames = run.frames();
    let mut film = run.film(0..frames, &options(true), &context).unwrap();
    let rest = film.report.rest.clone();
    let reported: Vec<(&str, &str, bool)> = (rest.pieces.iter())
        .map(|p| (p.name.as_str(), p.input.as_str(), p.closed))
        .collect();
    let wanted = [
        ("rest_lower", "tree", true),
        ("twig_000", "leaf", true),
        ("standing_000", "stone", true),
    ];
    assert_eq!(reported, wanted, "{rest:?}");

    // At rest all is there: exactly but for the stretch of the rods, whose outline has its own corners.
    let area = 12.0 * (std::f64::consts::TAU / 24.0).sin() * RADIUS * RADIUS;
    let trunk = trunk();
    let side = trunk.volume() - area * LENGTH;
    let lower = piece(&film, "rest_lower").1;
    let end = (lower.bounds().unwrap().1.x - lower.bounds().unwrap().0.x) * area;
    assert!(
        (lower.volume() - side - end).abs() < 1e-5 * trunk.volume(),
        "{} and not {}",
        lower.volume(),
        side + end
    );
    let skin = |p: &&greenstick::geometry::SkinnedMesh| p.name.starts_with("piece_");
    let rods: f64 = film
        .film
        .pieces
        .iter()
        .filter(skin)
        .map(|p| p.mesh.volume())
        .sum();
    let all = rods + lower.volume() + rest.left_out_m3;
    assert!(rest.left_out_m3 > 0.0 && rest.left_out_m3 < 0.05 * trunk.volume());
    assert!(
        (all / trunk.volume() - 1.0).abs() < 0.01,
        "{all} of {}",
        trunk.volume()
    );
    let leaf = &input().nodes[1].mesh;
    assert!((piece(&film, "twig_000").1.volume() / leaf.volume() - 1.0).abs() < 1e-9);
    assert_eq!(film.film.fixed.len(), 1);

    // What the clamp holds stays, the leaf goes with the rods, and neither is bent.
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let mut poses = vec![Pose::IDENTITY; film.film.joints.len()];
    film.motion.poses(frames - 1, &mut poses).unwrap();
    let (lower, twig) = (piece(&film, "rest_lower").0, piece(&film, "twig_000").0);
    film.film.pose_piece(lower, &poses, &mut after);
    let moved = film.film.pieces[lower].mesh.positions.iter().zip(&after);
    let moved = moved.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(moved < 1e-6, "the clamped end moved by {moved} m");
    before.extend(film.film.pieces[twig].mesh.positions.iter().copied());
    film.film.pose_piece(twig, &poses, &mut after);
    for (a, b) in before.iter().zip(&after) {
        let apart = (a.distance(before[0]), b.distance(after[0]));
        assert!((apart.0 - apart.1).abs() < 1e-12, "{apart:?}");
    }
    let far = before[0].distance(after[0]);
    assert!(far > RADIUS, "the leaf moved by {far} m only");
    // As near to the rods as it was, but for how they bend below it.
    let at_rest = |j: usize| film.film.joints[j].rest.translation;
    let near = [
        rod_distance(&film, at_rest, before[0]),
        rod_distance(&film, |j| poses[j].translation, after[0]),
    ];
    assert!((near[0] - near[1]).abs() < 0.5 * RADIUS, "{near:?}");

    let only = run.film(0..frames, &options(false), &context).unwrap();
    assert!(only.film.pieces.iter().all(|p| skin(&p)));
    let still = run.still(frames - 1, &options(true), &context).unwrap();
    let names = still.scene.nodes.iter().map(|n| n.name.as_str());
    let names: Vec<&str> = names.filter(|n| !n.starts_with("piece_")).collect();
    assert_eq!(names, ["rest_lower", "twig_000", "standing_000"]);
}

#[test]
fn a_film_of_drawn_faces_has_all_of_the_input_and_moves_it_with_what_it_hangs_on() {
    let mut run = run().along_x();
    let frames = run.frames();
    let made = film_of_faces(&mut run, 0..frames, &options(true), &Context::quiet());
    let mut film = made.unwrap().skinned;
    let moved = film.at(frames - 1).unwrap();
    // The stone stands still; nothing is lost.
    let fixed: Vec<&str> = (film.film.fixed.iter()).map(|n| n.name.as_str()).collect();
    assert_eq!(fixed, ["stone"]);
    let rest = |name: &str| (*piece(&film, name).1).clone();
    let now = |name: &str| moved.nodes.iter().find(|n| n.name == name).unwrap();
    let trunk = trunk();
    let pieces = film
        .film
        .pieces
        .iter()
        .filter(|p| !p.is_detail && p.name != "leaf");
    let volume: f64 = pieces.map(|p| p.mesh.volume()).sum();
    assert!((volume / trunk.volume() - 1.0).abs() < 1e-6, "{volume}");
    // The side branch grows where the clamp holds the trunk: it stays.
    let (lower, still) = (rest("lower"), &now("lower").mesh);
    let branch = |p: &DVec3| p.y.hypot(p.z) > 2.0 * RADIUS;
    let tips: Vec<usize> = (0..lower.positions.len())
        .filter(|&v| branch(&lower.positions[v]))
        .collect();
    assert!(tips.len() > 40, "{}", tips.len());
    for v in tips {
        let off = lower.positions[v].distance(still.positions[v]);
        assert!(off < 0.2 * RADIUS, "{off}");
    }
    // The leaf goes with the end that is pressed down, and keeps its shape.
    let leaf = piece(&film, "leaf").1;
    let gone = &now("leaf").mesh;
    let far = leaf.positions[0].distance(gone.positions[0]);
    assert!(far > RADIUS, "{far}");
    assert!((gone.volume() / leaf.volume() - 1.0).abs() < 1e-9);
}

#[test]
fn still_halves_stand_where_the_input_has_them_with_what_they_carry() {
    let mut run = run();
    let frames = run.frames();
    let still = run
        .at_rest(frames - 1, &options(true), &Context::quiet())
        .unwrap();
    let nodes = &still.scene.nodes;
    let find = |name: &str| nodes.iter().find(|n| n.name == name).unwrap();
    let input = input();
    for (name, source) in [("twig_000", 1), ("standing_000", 2)] {
        let source = &input.nodes[source];
        let (low, high) = source.mesh.transformed(&source.transform).bounds().unwrap();
        let bounds = find(name).mesh.bounds().unwrap();
        assert!(bounds.0.distance(low) < 1e-12 && bounds.1.distance(high) < 1e-12);
    }
    // The trunk below belongs to the piece that its rods are of.
    let parent = find("rest_lower").parent.unwrap();
    assert!(["lower", "whole"].contains(&nodes[parent].name.as_str()));
    assert_eq!(find("standing_000").parent, None);
}

/// Signed distance of a place from the farthest face of a convex mesh, m: above 0 outside.
fn beyond(shape: &Mesh, p: DVec3) -> f64 {
    let faces = (0..shape.triangles.len()).map(|t| {
        let [a, b, c] = shape.corners(t);
        (b - a).cross(c - a).normalize().dot(p - a)
    });
    faces.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn collision_shapes_are_convex_and_hold_the_pieces_as_far_as_is_told() {
    let mut run = run();
    let context = Context::quiet();
    let frames = run.frames();
    let film = run.film(0..frames, &options(true), &context).unwrap().film;
    let made = collision(&film, &ConvexOptions::default(), &context).unwrap();
    assert_eq!(made.pieces.len(), film.pieces.len());
    for (piece, report) in film.pieces.iter().zip(&made.pieces) {
        let own = format!("UCX_{}_", piece.name);
        let number = |name: &str| {
            name.strip_prefix(&own)
                .and_then(|n| n.parse::<usize>().ok())
        };
        let shapes: Vec<&Mesh> = (made.scene.nodes.iter())
            .filter(|n| number(&n.name).is_some())
            .map(|n| &*n.mesh)
            .collect();
        assert_eq!(shapes.len(), report.shapes, "{}", piece.name);
        assert!(
            shapes
                .iter()
                .all(|s| is_convex(s) && s.positions.len() <= 32)
        );
        let volume: f64 = shapes.iter().map(|s| s.volume()).sum();
        let ratio = volume / piece.mesh.volume();
        assert!(
            (ratio / report.volume_ratio - 1.0).abs() < 1e-6,
            "{ratio} {report:?}"
        );
        let out = piece.mesh.positions.iter().map(|&p| {
            let each = shapes.iter().map(|s| beyond(s, p));
            each.fold(f64::INFINITY, f64::min)
        });
        let farthest = out.fold(0.0, f64::max);
        // The nearest face is no farther than the nearest point.
        assert!(
            farthest <= report.uncovered_m + 1e-9,
            "{farthest} {report:?}"
        );
    }
}

#[test]
fn levels_are_some_of_the_vertices_and_as_near_as_is_told() {
    let mut run = run();
    let context = Context::quiet();
    let frames = run.frames();
    let mut made = run.film(0..frames, &options(true), &context).unwrap();
    let (simpler, report) = level(&mut made, 0.5, &context).unwrap();
    let count = |film: &greenstick::geometry::Film| -> usize {
        film.pieces.iter().map(|p| p.mesh.triangles.len()).sum()
    };
    assert_eq!(report.triangles, [count(&made.film), count(&simpler)]);
    assert!(
        report.triangles[1] < report.triangles[0] * 3 / 4,
        "{report:?}"
    );
    assert_eq!(simpler.fault(), None);
    let mut most = 0.0f64;
    for (before, after) in made.film.pieces.iter().zip(&simpler.pieces) {
        assert!(after.mesh.check().closed, "{}", after.name);
        let ratio = after.mesh.volume() / before.mesh.volume();
        assert!((ratio - 1.0).abs() < 0.0101, "{}: {ratio}", after.name);
        // Each vertex is one of before, with all that it follows.
        let mut at = 0;
        for (v, p) in after.mesh.positions.iter().enumerate() {
            let same = |k: &usize| {
                before.mesh.positions[*k] == *p
                    && before
                        .binding
                        .influences(*k)
                        .eq(after.binding.influences(v))
                    && ["NORMAL", "TEXCOORD_0"].iter().all(|name| {
                        let of = |mesh: &Mesh, v: usize| {
                            mesh.attributes.get(*name).map(|a| a.at(v).to_vec())
                        };
                        of(&before.mesh, *k) == of(&after.mesh, v)
                    })
            };
            let found = (at..before.mesh.positions.len()).find(same);
            at = 1 + found.unwrap_or_else(|| panic!("{}: vertex {v} is new", after.name));
        }
        let tree = Bvh::from_mesh(&after.mesh);
        for &p in &before.mesh.positions {
            let nearest = tree.nearest_on_mesh(&after.mesh, p, f64::INFINITY).unwrap();
            most = most.max(nearest.distance);
        }
    }
    assert!(
        most <= report.error_m && report.error_m > 0.0,
        "{most} {report:?}"
    );
}

#[test]
fn pieces_that_move_as_a_whole_follow_one_joint_and_are_where_their_skin_was() {
    let mut run = run();
    let context = Context::quiet();
    let frames = run.frames();
    // In the first frame nothing has moved yet.
    let film = run.film(0..1, &options(false), &context).unwrap().film;
    assert!(
        film.pieces
            .iter()
            .all(|p| p.binding.used_joints().len() == 1)
    );
    let film = run.film(0..frames, &options(false), &context).unwrap().film;
    assert!(
        film.pieces[0].binding.used_joints().len() > 1,
        "the stem bends"
    );
}
