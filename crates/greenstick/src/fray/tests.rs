//! Frayed breaks of the built-in branch and of a board.

use super::*;
use crate::{BreakRequest, break_scene, built_in_branch, prepare};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{CheckOptions, Context, Node, Scene};
use greenstick_wood::primitive;
use greenstick_wood::stem::{StemLocation, StemOptions};

const QUICK: CheckOptions = CheckOptions {
    self_intersections: false,
};

fn board() -> Scene {
    let mesh = primitive::board(0.6, 0.09, 0.03);
    let node = Node {
        name: "board".into(),
        transform: DAffine3::from_scale(DVec3::splat(1e-3)) * DAffine3::from_rotation_x(0.4),
        mesh: mesh
            .transformed(&DAffine3::from_scale(DVec3::splat(1e3)))
            .into(),
        parent: None,
    };
    Scene {
        nodes: vec![node],
        ..Scene::default()
    }
}

fn parameters(settings: &[&str]) -> BreakParameters {
    Recipe::resolve(&["splintering-tension"], None, settings)
        .unwrap()
        .face
}

fn made(scene: Scene, p: &BreakParameters) -> (Prepared, Model, FrayOptions) {
    let place = StemLocation::Fraction(0.5);
    let prepared = prepare(scene, &place, &StemOptions::default(), &Context::quiet()).unwrap();
    let model = prepared.model(p, 1.0, 1).unwrap();
    let options = FrayOptions {
        amount: 0.7,
        part: 0.0,
        material: 1,
    };
    (prepared, model, options)
}

#[test]
fn splinters_are_solids_taken_out_of_the_pieces() {
    let mut hung = [0, 0];
    // How often each piece lost some.
    for (scene, seeds) in [(built_in_branch(), 1..6), (board(), 1..3)] {
        for seed in seeds {
            let p = parameters(&[&format!("seed={seed}")]);
            let (prepared, model, options) = made(scene.clone(), &p);
            let whole = model.lower.volume() + model.upper.volume();
            let rest = at_rest(&prepared, &model, &p, &options).unwrap();
            assert!(!rest.splinters.is_empty(), "seed {seed}");
            let mut sum = 0.0;
            for mesh in [&rest.lower, &rest.upper] {
                let report = mesh.check_with(QUICK);
                assert!(report.is_solid(), "seed {seed}: {report:?}");
                sum += mesh.volume();
            }
            for (mesh, cell) in &rest.splinters {
                let report = mesh.check();
                assert!(report.is_solid(), "seed {seed}, {cell}: {report:?}");
                assert_eq!(report.components, 1);
                assert!(!model.bundles.bundles[*cell as usize].bark);
                sum += mesh.volume();
            }
            let off = sum / whole - 1.0;
            assert!(off.abs() < 1e-9, "seed {seed}: {off}");
            hung[0] += usize::from(rest.lower.volume() < 0.999_999 * model.lower.volume());
            hung[1] += usize::from(rest.upper.volume() < 0.999_999 * model.upper.volume());
        }
    }
    assert!(hung[0] > 0 && hung[1] > 0, "{hung:?}");
}

/// Cosine between vertex normals and triangles, on the mean of the area.
fn fit_of_normals(mesh: &Mesh) -> f64 {
    let normals = &mesh.attributes["NORMAL"];
    let (mut along, mut area) = (0.0, 0.0);
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let face = (b - a).cross(c - a);
        let n = normals.at(corners[0] as usize);
        along += face.dot(DVec3::new(n[0].into(), n[1].into(), n[2].into()));
        area += face.length();
    }
    along / area
}

#[test]
fn bent_pieces_stay_whole_and_splinters_lie_clear_of_the_stem() {
    let p = parameters(&[]);
    let (prepared, model, options) = made(built_in_branch(), &p);
    let rest = at_rest(&prepared, &model, &p, &options).unwrap();
    let made = fray(&prepared, &model, &p, &options).unwrap();
    let radius = prepared.found.stem.radius;
    for (straight, bent) in [(&rest.lower, &made.lower), (&rest.upper, &made.upper)] {
        let report = bent.check_with(QUICK);
        assert!(report.closed && report.oriented, "{report:?}");
        assert_eq!(report.degenerate_triangles, 0);
        let change = bent.volume() / straight.volume() - 1.0;
        assert!(change.abs() < 0.01, "{change}");
        // Vertices keep their order; new ones come last.
        let moves = straight.positions.iter().zip(&bent.positions);
        let most = moves.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(
            most > 0.1 * radius && most < 0.7 * radius,
            "{}",
            most / radius
        );
        // Normals turn along: they fit the triangles as well as before.
        let (before, after) = (fit_of_normals(straight), fit_of_normals(bent));
        assert!(before > 0.9 && after > before - 0.02, "{before} {after}");
    }
    let axis = prepared
        .found
        .stem
        .grain
        .axis()
        .frame(prepared.found.stem.location);
    for (mesh, thrown) in &made.splinters {
        assert!((thrown.matrix3.determinant() - 1.0).abs() < 1e-9);
        let move_to = *thrown * *prepared.transform();
        let most = (mesh.positions.iter())
            .map(|&q| {
                (move_to.transform_point3(q) - axis.origin)
                    .reject_from(axis.tangent)
                    .length()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(most > radius && most < 3.0 * radius, "{}", most / radius);
    }
}

#[test]
fn without_fray_nothing_changes_and_the_same_seed_gives_the_same() {
    let broken = |fray: f64, seed: u64| {
        let request = BreakRequest {
            recipe: Recipe::resolve(&["splintering-tension"], None, &[&format!("seed={seed}")])
                .unwrap(),
            fray,
            texture_width: 16,
            ..BreakRequest::default()
        };
        break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
    };
    let (plain, some) = (broken(0.0, 3), broken(0.7, 3));
    assert_eq!(plain.scene.nodes.len(), 2);
    let p = parameters(&["seed=3"]);
    let (_, model, _) = made(built_in_branch(), &p);
    for (node, mut piece) in plain.scene.nodes.iter().zip([model.lower, model.upper]) {
        greenstick_skin::settle::settle(&mut piece, plain.inner_material);
        assert_eq!(node.mesh.positions, piece.positions);
    }
    let names: Vec<&str> = some.scene.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names[..3], ["lower", "upper", "splinter_000"]);
    assert_eq!(some.report.pieces.len(), names.len());
    assert!(some.report.pieces.iter().all(|p| p.closed));
    let again = broken(0.7, 3);
    let other = broken(0.7, 4);
    for (a, b) in some.scene.nodes.iter().zip(&again.scene.nodes) {
        assert!(a.mesh == b.mesh && a.transform == b.transform);
    }
    assert!(other.scene.nodes[2].mesh != some.scene.nodes[2].mesh);
    let fewer = broken(0.1, 3).scene.nodes.len();
    assert!(fewer > 2 && fewer < names.len());
}

#[test]
fn the_bend_is_one_to_one() {
    let p = parameters(&[]);
    let (prepared, model, _) = made(built_in_branch(), &p);
    let stem = &prepared.found.stem;
    for upper in [false, true] {
        let bend = Bend::new(&prepared, &model, 1.0, 5, upper);
        let worst = bend.least_stretch(stem.location, 3.5 * stem.radius, 6.0 * stem.radius);
        assert!(worst > 0.1, "{worst}");
    }
}
