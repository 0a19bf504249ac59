//! Frayed breaks of the built-in branch and of a board.

use crate::support::{pieces, scene, stages};
use glam::{DAffine3, DVec2, DVec3};
use greenstick::fracture::parameters::BreakParameters;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::repair::snap_to_f32;
use greenstick::geometry::{CheckOptions, Context, Mesh, Scene};
use greenstick::session::BreakStages;
use greenstick::skin::fray::FrayedBreak;
use greenstick::wood::{noise, primitive};
use greenstick::{Break, BreakRequest, BreakSession, break_scene, built_in_branch};

const QUICK: CheckOptions = CheckOptions {
    self_intersections: false,
};

fn board() -> Scene {
    let mesh = primitive::board(0.6, 0.09, 0.03);
    let millimetres = DAffine3::from_scale(DVec3::splat(1e3));
    let mut scene = scene(mesh.transformed(&millimetres), 1e-3);
    scene.nodes[0].transform *= DAffine3::from_rotation_x(0.4);
    scene
}

fn parameters(settings: &[&str]) -> BreakParameters {
    Recipe::resolve(&["splintering-tension"], None, settings)
        .unwrap()
        .face
}

/// A break that is to be frayed, and its pieces.
struct Made {
    stages: BreakStages,
    pieces: [Mesh; 2],
    context: Context,
}

impl Made {
    fn new(scene: Scene, p: &BreakParameters) -> Self {
        let stages = stages(&mut BreakSession::new(scene), 0.5, p);
        let pieces = pieces(&stages, p);
        Made {
            stages,
            pieces,
            context: Context::quiet(),
        }
    }

    fn frayed(&self, p: &BreakParameters, amount: f64) -> FrayedBreak<'_> {
        FrayedBreak {
            stem: self.stages.stem.stem(),
            layout: &self.stages.layout,
            heights: &self.stages.heights.heights,
            inner: self.stages.inner_wood(p),
            pieces: self.pieces.each_ref(),
            amount,
            separation: 0.0,
            seed: p.seed,
            context: &self.context,
        }
    }
}

/// Much.
const AMOUNT: f64 = 0.7;

#[test]
fn splinters_are_solids_taken_out_of_the_pieces() {
    let mut hung = [0, 0];
    // How often each piece lost some.
    for (scene, seeds) in [(built_in_branch(), 1..6), (board(), 1..3)] {
        for seed in seeds {
            let p = parameters(&[&format!("seed={seed}")]);
            let made = Made::new(scene.clone(), &p);
            let [lower, upper] = made.pieces.each_ref().map(Mesh::volume);
            let rest = made.frayed(&p, AMOUNT).loosened().unwrap();
            assert!(!rest.splinters.is_empty(), "seed {seed}");
            let mut sum = 0.0;
            for mesh in &rest.pieces {
                let report = mesh.check_with(QUICK);
                assert!(report.is_solid(), "seed {seed}: {report:?}");
                sum += mesh.volume();
            }
            for splinter in &rest.splinters {
                let (mesh, cell) = (&splinter.mesh, splinter.cell);
                let report = mesh.check();
                assert!(report.is_solid(), "seed {seed}, {cell}: {report:?}");
                assert_eq!(report.components, 1);
                assert!(!made.stages.layout.bundles.bundles[cell as usize].bark);
                sum += mesh.volume();
            }
            let off = sum / (lower + upper) - 1.0;
            assert!(off.abs() < 1e-9, "seed {seed}: {off}");
            hung[0] += usize::from(rest.pieces[0].volume() < 0.999_999 * lower);
            hung[1] += usize::from(rest.pieces[1].volume() < 0.999_999 * upper);
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
    let broken = Made::new(built_in_branch(), &p);
    let frayed = broken.frayed(&p, AMOUNT);
    let rest = frayed.loosened().unwrap();
    let made = frayed.fray().unwrap();
    let stem = &frayed.stem.found.stem;
    let radius = stem.radius;
    for (straight, bent) in rest.pieces.iter().zip(&made.pieces) {
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
    let axis = stem.grain.axis().frame(stem.location);
    for (mesh, thrown) in &made.splinters {
        assert!((thrown.matrix3.determinant() - 1.0).abs() < 1e-9);
        let move_to = *thrown * *frayed.stem.transform();
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
        let settings = [&*format!("seed={seed}")];
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(&["splintering-tension"], None, &settings).unwrap(),
                fray,
                ..Break::default()
            })
        };
        break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
    };
    // The face of this seed is sound as it is; others lose a few edges when they are rounded to a file's precision.
    let (plain, some) = (broken(0.0, 5), broken(0.7, 5));
    let pieces = |broken: &greenstick::Broken| {
        let nodes = broken.scene.nodes.iter().filter(|n| !n.is_detail);
        nodes.cloned().collect::<Vec<_>>()
    };
    assert_eq!(pieces(&plain).len(), 2);
    let p = parameters(&["seed=5"]);
    let made = Made::new(built_in_branch(), &p);
    for (node, mut piece) in plain.scene.nodes.iter().zip(made.pieces) {
        snap_to_f32(&mut piece, plain.woods[0].material);
        // What bark shows doubles vertices behind them.
        let count = piece.positions.len();
        assert!(node.mesh.positions[..count] == piece.positions);
    }
    let some_pieces = pieces(&some);
    let names: Vec<&str> = some_pieces.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names[..3], ["lower", "upper", "splinter_000"]);
    assert_eq!(some.report.pieces.len(), names.len());
    assert!(some.report.pieces.iter().all(|p| p.closed));
    let again = broken(0.7, 5);
    let other = broken(0.7, 4);
    for (a, b) in some.scene.nodes.iter().zip(&again.scene.nodes) {
        assert!(a.mesh == b.mesh && a.transform == b.transform);
    }
    assert!(other.scene.nodes[2].mesh != some.scene.nodes[2].mesh);
    let fewer = pieces(&broken(0.1, 5)).len();
    assert!(fewer > 2 && fewer < names.len());
}

#[test]
fn the_bend_is_one_to_one() {
    let p = parameters(&[]);
    let made = Made::new(built_in_branch(), &p);
    let frayed = made.frayed(&p, 1.0);
    let stem = &frayed.stem.found.stem;
    for upper in [false, true] {
        // The least determinant of the map's derivative at places about the break.
        let bend = frayed.bend(upper);
        let h = 1e-6 * stem.radius;
        let mut worst = f64::INFINITY;
        for i in 0..20_000 {
            let unit = |k: i64| 2.0 * noise::unit(77, i, k, 0) - 1.0;
            let across =
                frayed.stem.square.middle + DVec2::new(unit(0), unit(1)) * 3.5 * stem.radius;
            let at = across.extend(stem.location + unit(2) * 6.0 * stem.radius);
            let column = |e: DVec3| (bend.moved(at + e * h) - bend.moved(at - e * h)) / (2.0 * h);
            let [x, y, z] = DVec3::AXES.map(column);
            worst = worst.min(glam::DMat3::from_cols(x, y, z).determinant());
        }
        assert!(worst > 0.1, "{worst}");
    }
}
