//! Fuzz: strands of torn fibre beside the pieces, which change neither the solids nor their budget.

use greenstick::formats::{Format, LengthUnit, read};
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{CheckOptions, Context, Mesh, Node};
use greenstick::session::{NodeRole, PieceRole};
use greenstick::wood::stem::StemKind;
use greenstick::{Break, BreakRequest, Broken, break_scene, built_in_branch, files};
use std::path::Path;

fn broken(preset: &str, settings: &[&str], triangles: Option<u32>) -> Broken {
    let presets: &[&str] = if preset.is_empty() { &[] } else { &[preset] };
    let request = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break {
            recipe: Recipe::resolve(presets, None, settings).unwrap(),
            triangles,
            ..Break::default()
        })
    };
    break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
}

fn fuzz(broken: &Broken) -> Vec<&Node> {
    let nodes = broken.scene.nodes.iter();
    nodes.filter(|n| n.is_detail).collect()
}

fn triangles(broken: &Broken) -> usize {
    fuzz(broken).iter().map(|n| n.mesh.triangles.len()).sum()
}

#[test]
fn strands_are_closed_thin_and_beside_the_pieces() {
    let (made, bare) = (broken("", &[], None), broken("", &["fuzz=0"], None));
    assert!(fuzz(&bare).is_empty());
    let names: Vec<&str> = fuzz(&made).iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["lower_fuzz", "upper_fuzz"]);
    for (i, role) in [PieceRole::Lower, PieceRole::Upper].into_iter().enumerate() {
        let (piece, node) = (&made.scene.nodes[i], fuzz(&made)[i]);
        // The solid is what it is without fuzz.
        assert!(piece.mesh == bare.scene.nodes[i].mesh);
        assert_eq!(node.parent, Some(i));
        assert_eq!(made.roles[i + 2], NodeRole::Fuzz(role));
        let report = &made.report.pieces[i];
        assert_eq!(report.fuzz_triangles, node.mesh.triangles.len());
        assert!(report.fuzz_triangles > 5_000, "{}", report.fuzz_triangles);
        assert!(report.fuzz_triangles < report.triangles);
        let options = CheckOptions {
            self_intersections: false,
        };
        let check = node.mesh.check_with(options);
        assert!(check.closed && check.oriented, "{check}");
        let share = node.mesh.volume() / piece.mesh.volume();
        assert!(share > 0.0 && share < 1e-3, "{share}");
    }
}

/// Mean over the triangles of a mesh, by their area, of the cosine of their normals to an axis, squared.
fn across(mesh: &Mesh, axis: glam::DVec3) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let normal = (b - a).cross(c - a);
        let own = normal.length();
        if own > 0.0 {
            sum += normal.dot(axis).powi(2) / own;
            area += own;
        }
    }
    sum / area
}

#[test]
fn strands_run_along_the_grain_within_the_bark() {
    // Halves that fit: strands of one lie in the other.
    let made = broken("", &[], None);
    let wood = &made.woods[0];
    let axis = wood.stem.grain.axis().frame(wood.stem.location).tangent;
    for node in fuzz(&made) {
        // Sides of what runs along an axis face away from it: of strands in all directions it would be a third.
        let share = across(&node.mesh, axis);
        assert!(share < 0.1, "{share}");
        let rings = &node.mesh.attributes["_RING"];
        for (v, &p) in node.mesh.positions.iter().enumerate() {
            let grain = wood.stem.grain.to_grain(node.transform.transform_point3(p));
            let ring = wood.stem.rings.address(grain.truncate()).0;
            // No farther out than near the bark, or where it begins, but for its width.
            let begins = f64::from(rings.at(v)[0]);
            assert!(
                ring < begins.max(0.975) + 0.02,
                "{}: {ring}, {begins}",
                node.name
            );
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_strands_and_torn_wood_has_more_than_brash() {
    let one = broken("splintering-tension", &["seed=3"], None);
    let again = broken("splintering-tension", &["seed=3"], None);
    assert!(one.scene == again.scene);
    let other = broken("splintering-tension", &["seed=4"], None);
    assert!(fuzz(&one)[0].mesh != fuzz(&other)[0].mesh);
    let brash = broken("brash", &["fuzz=0.5", "seed=3"], None);
    assert!(
        triangles(&brash) * 3 < triangles(&one),
        "{}",
        triangles(&brash)
    );
    assert!(fuzz(&broken("", &["surface=smooth"], None)).is_empty());
}

#[test]
fn brash_wood_that_was_moved_apart_ends_in_short_fibres() {
    let ends = |separation: f64| {
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(&["brash"], None, &[]).unwrap(),
                separation,
                ..Break::default()
            })
        };
        break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
    };
    let (rest, apart) = (ends(0.0), ends(0.03));
    // Halves that lie in each other leave no room for them.
    let [at_rest, moved] = [&rest, &apart].map(triangles);
    assert!(moved > at_rest + 20 * 500, "{at_rest} {moved}");
    let options = CheckOptions {
        self_intersections: false,
    };
    let wood = &apart.woods[0];
    let axis = wood.stem.grain.axis().frame(wood.stem.location).tangent;
    for (i, node) in fuzz(&apart).into_iter().enumerate() {
        let check = node.mesh.check_with(options);
        assert!(check.closed && check.oriented, "{check}");
        let share = node.mesh.volume() / apart.scene.nodes[i].mesh.volume();
        assert!(share > 0.0 && share < 2e-3, "{share}");
        // They lean, but most of their sides still run along the grain.
        let share = across(&node.mesh, axis);
        assert!(share > 0.02 && share < 0.25, "{share}");
        // What is not of the wood hangs on at the edge of the bark.
        let zones = &node.mesh.attributes["_ZONE"];
        let vertices = node.mesh.positions.len();
        let wooden = (0..vertices).filter(|&v| zones.at(v)[0] <= 2.0).count();
        let bark = (0..vertices).filter(|&v| zones.at(v)[0] == 4.0).count();
        assert!(
            (wooden + bark) * 10 > vertices * 9,
            "{wooden} of {vertices}"
        );
    }
}

/// Strings and straps of bast hang on at the torn edge of bark, and stand out of the stem; halves that fit have none.
#[test]
fn bast_hangs_out_at_the_edge_of_torn_bark() {
    let apart = BreakRequest {
        texture_width: 16,
        ..BreakRequest::single(Break {
            separation: 0.03,
            ..Break::default()
        })
    };
    let apart = break_scene(built_in_branch(), &apart, &Context::quiet()).unwrap();
    // Vertices of strands of bark, and those of them farther out than the skin of the branch.
    let of_bark = |made: &Broken, number: usize| {
        let (wood, node) = (&made.woods[0], fuzz(made)[number]);
        let zones = &node.mesh.attributes["_ZONE"];
        let bark = (0..node.mesh.positions.len()).filter(|&v| zones.at(v)[0] == 4.0);
        let rings = bark.map(|v| {
            let at = node.transform.transform_point3(node.mesh.positions[v]);
            let grain = wood.stem.grain.to_grain(at);
            wood.stem.rings.address(grain.truncate()).0
        });
        let rings: Vec<f64> = rings.collect();
        (rings.len(), rings.iter().filter(|&&r| r > 1.03).count())
    };
    for number in 0..2 {
        let (all, out) = of_bark(&apart, number);
        assert!(all > 400 && out > 0, "{out} of {all}");
        let (rest, _) = of_bark(&broken("", &[], None), number);
        assert!(rest < all / 5, "{rest}");
    }
}

/// Whether a triangle looks to the side of the normal at its first corner.
fn faces_as_its_normal(mesh: &Mesh, t: usize) -> bool {
    let [a, b, c] = mesh.corners(t);
    let normal =
        glam::Vec3::from_slice(mesh.attributes["NORMAL"].at(mesh.triangles[t][0] as usize));
    (b - a).cross(c - a).dot(normal.as_dvec3()) > 0.0
}

/// Plates of bark lift off at a torn edge: outside they go on as the bark that they stand on, its texture included. Halves that fit,
/// brash wood and wood without bark have none.
#[test]
fn bark_lifts_off_in_flaps_that_go_on_as_the_bark_below() {
    let apart = |settings: &[&str], preset: &[&str], kind: Option<StemKind>| {
        let mut request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(preset, None, settings).unwrap(),
                separation: 0.03,
                ..Break::default()
            })
        };
        request.stem.kind = kind;
        break_scene(built_in_branch(), &request, &Context::quiet()).unwrap()
    };
    let outside = |made: &Broken, node: &Node| -> Vec<usize> {
        let mesh = &node.mesh;
        let bark = made.scene.nodes[0].mesh.material(0);
        let of_bark = |&t: &usize| mesh.material(t) == bark;
        (0..mesh.triangles.len()).filter(of_bark).collect()
    };
    let count = |made: &Broken| -> usize {
        let nodes = fuzz(made).into_iter();
        nodes.map(|node| outside(made, node).len()).sum()
    };
    let made = apart(&[], &[], None);
    assert!(count(&made) > 500, "{}", count(&made));
    // Of a coarse face, whose strands take all that they may, too.
    let coarse = apart(&["rings=16", "sectors=48"], &[], None);
    assert!(count(&coarse) > 0);
    assert_eq!(count(&broken("", &[], None)), 0);
    assert_eq!(count(&apart(&[], &["brash"], None)), 0);
    assert_eq!(count(&apart(&[], &[], Some(StemKind::Pole))), 0);
    let stem = &made.woods[0].stem;
    for node in fuzz(&made) {
        let check = node.mesh.check_with(CheckOptions {
            self_intersections: false,
        });
        assert!(check.closed && check.oriented, "{check}");
        let piece = &made.scene.nodes[node.parent.unwrap()];
        // The skin of the piece, by place in the wood, with its texture coordinates.
        let addresses = |mesh: &Mesh, v: u32| {
            let [grain, uv] = ["_GRAIN", "TEXCOORD_0"].map(|a| mesh.attributes[a].at(v as usize));
            let at = glam::DVec2::new(f64::from(grain[0]), f64::from(grain[1])) - stem.rings.pith();
            let angle = at.y.atan2(at.x);
            (
                angle,
                f64::from(grain[2]),
                [f64::from(uv[0]), f64::from(uv[1])],
            )
        };
        let bark = piece.mesh.material(0);
        let skin: Vec<_> = (0..piece.mesh.triangles.len())
            .filter(|&t| piece.mesh.material(t) == bark)
            .map(|t| addresses(&piece.mesh, piece.mesh.triangles[t][0]))
            .collect();
        for t in outside(&made, node) {
            assert!(faces_as_its_normal(&node.mesh, t), "{t} is inside out");
        }
        for t in outside(&made, node).into_iter().step_by(7) {
            let (angle, along, uv) = addresses(&node.mesh, node.mesh.triangles[t][0]);
            let off = |s: &&(f64, f64, [f64; 2])| {
                let turn = (s.0 - angle) / std::f64::consts::TAU;
                ((turn - turn.round()) * std::f64::consts::TAU * stem.radius).hypot(s.1 - along)
            };
            let near = (skin.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
            let near = near.unwrap();
            let around = uv[0] - near.2[0];
            let difference = (around - around.round())
                .abs()
                .max((uv[1] - near.2[1]).abs());
            // A turn of the texture is the girth.
            let metres = difference * std::f64::consts::TAU * stem.radius;
            assert!(metres < 1.6 * off(&near) + 2e-3, "{metres} {}", off(&near));
        }
    }
}

/// Bark of brash wood broke short with it: hardly a string of it stands at the rim.
#[test]
fn brash_bark_has_hardly_a_string() {
    let of_bark = |preset: &[&str]| {
        let request = BreakRequest {
            texture_width: 16,
            ..BreakRequest::single(Break {
                recipe: Recipe::resolve(preset, None, &[]).unwrap(),
                separation: 0.03,
                ..Break::default()
            })
        };
        let made = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
        let count = |node: &Node| {
            let zones = &node.mesh.attributes["_ZONE"];
            let vertices = 0..node.mesh.positions.len();
            vertices.filter(|&v| zones.at(v)[0] == 4.0).count()
        };
        fuzz(&made).into_iter().map(count).sum::<usize>()
    };
    let (torn, brash) = (of_bark(&[]), of_bark(&["brash"]));
    assert!(brash * 8 < torn, "{brash} {torn}");
}

#[test]
fn a_budget_holds_with_strands() {
    for most in [9_000, 30_000] {
        let made = broken("", &[], Some(most));
        let solids: usize = made.report.pieces.iter().map(|p| p.triangles).sum();
        let added = solids + triangles(&made) - made.report.input.triangles;
        assert!(added <= most as usize, "{most}: {added}");
    }
}

#[test]
fn files_of_one_mesh_hold_the_solids_alone() {
    let made = broken("", &["rings=10", "sectors=24"], None);
    let solids: usize = made.report.pieces.iter().map(|p| p.triangles).sum();
    let all = solids + triangles(&made);
    assert!(all > solids);
    for (name, format, count) in [
        ("a.stl", Format::Stl, solids),
        ("a.ply", Format::Ply, solids),
        ("a.off", Format::Off, solids),
        ("a.obj", Format::Obj, all),
        ("a.glb", Format::Glb, all),
    ] {
        let outputs = files::encode(&made.scene, Path::new(name), LengthUnit::Metre).unwrap();
        let companion = |wanted: &str| {
            let found = outputs.iter().find(|o| o.path.ends_with(wanted));
            found
                .map(|o| o.bytes.clone())
                .ok_or(std::io::ErrorKind::NotFound.into())
        };
        let back = read(format, &outputs[0].bytes, name, None, &companion).unwrap();
        let read: usize = back.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
        assert_eq!(read, count, "{name}");
        // They are known for what they are, and whoever breaks the file again does so without them.
        let details = back.nodes.iter().filter(|n| n.is_detail).count();
        assert_eq!(details, if count == all { 2 } else { 0 }, "{name}");
        if format == Format::Glb {
            let again = Break {
                place: "0.3".parse().unwrap(),
                ..Break::default()
            };
            let request = BreakRequest {
                texture_width: 0,
                ..BreakRequest::single(again)
            };
            let twice = break_scene(back, &request, &Context::quiet()).unwrap();
            let named = |name: &&Node| name.is_detail;
            assert_eq!(twice.scene.nodes.iter().filter(named).count(), 2);
            assert!(twice.report.to_string().contains("were left out"));
        }
    }
}

#[test]
fn of_several_breaks_every_face_has_its_strands() {
    let request = BreakRequest {
        texture_width: 0,
        breaks: [0.35, 0.65]
            .map(|at| Break {
                place: format!("{at}").parse().unwrap(),
                ..Break::default()
            })
            .to_vec(),
        ..BreakRequest::default()
    };
    let made = break_scene(built_in_branch(), &request, &Context::quiet()).unwrap();
    let names: Vec<&str> = fuzz(&made).iter().map(|n| n.name.as_str()).collect();
    // The piece between the breaks has two faces.
    assert_eq!(
        names,
        [
            "piece_0_fuzz",
            "piece_1_fuzz",
            "piece_1_fuzz",
            "piece_2_fuzz"
        ]
    );
    for node in fuzz(&made) {
        let piece = &made.scene.nodes[node.parent.unwrap()];
        assert!(node.name.starts_with(&piece.name));
        assert_eq!(node.transform, piece.transform);
    }
}
