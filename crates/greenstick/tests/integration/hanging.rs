//! Pieces that hang on, as that of a greenstick fracture.

use glam::{DAffine3, DVec3};
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::picture::{Ground, PictureOptions};
use greenstick::wood::primitive;
use greenstick::{
    Break, BreakRequest, break_scene, built_in_branch, picture_of_break, picture_of_scene,
};
use std::collections::BTreeSet;

fn board() -> Scene {
    Scene {
        nodes: vec![Node {
            name: "board".into(),
            transform: DAffine3::from_axis_angle(DVec3::X, 0.4),
            mesh: primitive::board(0.5, 0.06, 0.02).into(),
            parent: None,
            is_detail: false,
        }],
        ..Scene::default()
    }
}

/// Both pieces where they lie, as one mesh.
fn together(nodes: &[Node]) -> Mesh {
    let mut all = Mesh::default();
    for node in nodes {
        let first = all.positions.len() as u32;
        let places = node.mesh.positions.iter();
        all.positions
            .extend(places.map(|&p| node.transform.transform_point3(p)));
        let triangles = node.mesh.triangles.iter();
        all.triangles
            .extend(triangles.map(|t| t.map(|v| v + first)));
    }
    all
}

#[test]
fn a_hanging_piece_touches_the_other_nowhere_and_stays_at_its_hinge() {
    for (scene, seed, angle) in [
        (built_in_branch(), 1, 68.0),
        (built_in_branch(), 2, 25.0),
        (board(), 3, 50.0),
    ] {
        let settings = [format!("seed={seed}"), format!("hang={angle}")];
        let settings = settings.each_ref().map(String::as_str);
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(&["green-stick"], None, &settings).unwrap(),
                ..Break::default()
            })
        };
        let broken = break_scene(scene, &request, &Context::quiet()).unwrap();
        let nodes = &broken.scene.nodes[..2];
        let own = |n: &Node| n.mesh.check().self_intersections.map_or(0, |s| s.crossing);
        let all = together(nodes).check().self_intersections.unwrap();
        assert_eq!(all.crossing, own(&nodes[0]) + own(&nodes[1]), "seed {seed}");

        // The upper piece turned by the angle, and its side at the hinge is still there.
        let hang = broken.report.hang.as_ref().unwrap();
        assert!(hang.angle_degrees >= angle && hang.clear_degrees <= hang.angle_degrees);
        let hinge = DVec3::from_array(hang.hinge_m);
        let nearest = |n: &Node| {
            let places = n.mesh.positions.iter();
            places
                .map(|&p| {
                    let off = n.transform.transform_point3(p) - hinge;
                    off.reject_from(DVec3::from_array(hang.axis)).length()
                })
                .fold(f64::INFINITY, f64::min)
        };
        let radius = broken.woods[0].stem.radius;
        for node in nodes {
            assert!(nearest(node) < 0.15 * radius, "{} is away", node.name);
        }
        let turn = (nodes[1].transform * nodes[0].transform.inverse()).matrix3;
        let cosine = (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0) / 2.0;
        assert!((cosine - hang.angle_degrees.to_radians().cos()).abs() < 1e-9);
    }
}

/// Numbers of the vertices of each shell of a mesh, ascending.
fn shells(mesh: &Mesh) -> Vec<Vec<usize>> {
    let found = mesh.shells();
    let mut shells = vec![BTreeSet::new(); found.count];
    for (corners, shell) in mesh.triangles.iter().zip(found.of_triangle) {
        shells[shell as usize].extend(corners.map(|v| v as usize));
    }
    (shells.into_iter())
        .map(|vertices| vertices.into_iter().collect())
        .collect()
}

/// Laths between the pieces are of many widths, lie beside each other at one end and apart in the middle, and straps of inner bark lie
/// outside of them. A piece that hangs on stays where it is when the pieces are to be moved apart.
#[test]
fn a_hinge_is_of_laths_of_many_widths_and_of_inner_bark_and_parts_do_not_leave_it() {
    let hung = |separation: f64| {
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                separation,
                recipe: Recipe::resolve(&["green-stick"], None, &["seed=4"]).unwrap(),
                ..Break::default()
            })
        };
        break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
    };
    let (made, apart) = (hung(0.0), hung(0.03));
    assert!(made.scene == apart.scene);
    assert!(apart.report.to_string().contains("hangs on"));
    assert!(!made.report.to_string().contains("hangs on"));

    let fuzz = made.scene.nodes.iter().find(|n| n.name == "lower_fuzz");
    let mesh = &fuzz.unwrap().mesh;
    let zones = &mesh.attributes["_ZONE"];
    let radius = made.woods[0].stem.radius;
    let (mut widths, mut straps) = (Vec::new(), 0);
    // How far the ends of whole laths are from each other.
    let mut whole = Vec::new();
    for shell in shells(mesh) {
        // Strands of fuzz have ten vertices at most.
        if shell.len() >= 36 {
            // Those that are torn have no root in the other piece.
            if shell.len() == 40 {
                let middle = |section: usize| {
                    let corners = &shell[4 * section..4 * section + 4];
                    corners.iter().map(|&v| mesh.positions[v]).sum::<DVec3>() / 4.0
                };
                whole.push(middle(1).distance(middle(8)) / radius);
            }
            let [a, b] = [shell[16], shell[17]].map(|v| mesh.positions[v]);
            widths.push(a.distance(b) / radius);
            straps += usize::from(zones.at(shell[0])[0] == 3.0);
        }
    }
    // Nothing bridges the wide part of the gap.
    let longest = whole.iter().copied().fold(0.0, f64::max);
    assert!(whole.len() > 10 && longest < 0.5, "{longest}");
    widths.sort_unstable_by(f64::total_cmp);
    assert!(widths.len() > 60, "{}", widths.len());
    assert!(straps > 10, "{straps}");
    let of = |part: f64| widths[(part * (widths.len() - 1) as f64) as usize];
    assert!(of(0.95) > 5.0 * of(0.1), "{} {}", of(0.95), of(0.1));
}

/// The bark of a piece that hangs faces up, as sawn ends do on a stem that stands.
#[test]
fn a_hanging_piece_is_shown_with_its_bark() {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break {
            recipe: Recipe::resolve(&["green-stick"], None, &[]).unwrap(),
            ..Break::default()
        })
    };
    let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
    let options = PictureOptions {
        width: 180,
        height: 140,
        samples: 4,
        ground: Some(Ground::Plain),
        ..PictureOptions::default()
    };
    let picture = picture_of_break(&broken, &options, &Context::quiet()).unwrap();
    let (row, side) = (3 * picture.width as usize, 3 * 25);
    // Both pieces run out of the upper half of the picture at its sides, beyond the break.
    for columns in [0..side, row - side..row] {
        let rows = picture.rgb.chunks(row).take(picture.height as usize / 2);
        let pixels = rows.flat_map(|row| row[columns.clone()].chunks(3));
        let (mut bark, mut inside) = (0, 0);
        for [red, blue] in pixels.map(|p| [p[0], p[2]].map(f64::from)) {
            // The background is grey, bark nearly so; wood and inner bark are not.
            let is_bare = red - blue > 0.35 * red;
            inside += usize::from(is_bare);
            bark += usize::from(!is_bare && red - blue > 14.0);
        }
        assert!(bark > 1000, "{bark}");
        assert!(inside * 50 < bark, "{inside} of {bark}");
    }
}

/// A break stands on a ground that suits its size, unless the plain backdrop is asked for; what is no break does not.
#[test]
fn a_break_stands_on_a_ground() {
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::default()
    };
    let broken = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
    let options = |ground| PictureOptions {
        width: 90,
        height: 70,
        samples: 1,
        ground,
        ..PictureOptions::default()
    };
    let with = |ground| picture_of_break(&broken, &options(ground), &Context::quiet()).unwrap();
    assert_eq!(with(None), with(Some(Ground::Concrete)));
    // Planks are brown, concrete is nearly grey, and the backdrop is lighter: the edge above the pieces shows which it is.
    let edge = |ground| {
        let picture = with(ground);
        [0, 1, 2].map(|c| f64::from(picture.rgb[3 * 45 + c]))
    };
    let [plain, planks] = [Ground::Plain, Ground::Bench].map(|g| edge(Some(g)));
    let usual = edge(None);
    assert!(plain[1] > usual[1] + 20.0, "{plain:?} {usual:?}");
    let tint = |[red, _, blue]: [f64; 3]| (red - blue) / red;
    assert!(tint(planks) > 1.5 * tint(usual), "{planks:?} {usual:?}");
    let scene =
        |ground| picture_of_scene(&broken.scene, &options(ground), &Context::quiet()).unwrap();
    assert_eq!(scene(None), scene(Some(Ground::Plain)));
}
