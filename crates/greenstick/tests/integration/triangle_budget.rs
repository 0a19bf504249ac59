//! Budgets of triangles: breaks of all kinds keep them, stay closed and do not cross, and say where they cannot.

use crate::support::data::data;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Context, Scene};
use greenstick::{Break, BreakRequest, BreakSession, Broken, Error, break_scene, built_in_branch};

fn request(settings: &[&str], presets: &[&str], triangles: Option<u32>, fray: f64) -> BreakRequest {
    BreakRequest {
        texture_width: 0,
        ..BreakRequest::single(Break {
            recipe: Recipe::resolve(presets, None, settings).unwrap(),
            triangles,
            fray,
            ..Break::default()
        })
    }
}

fn broken(scene: Scene, request: &BreakRequest) -> Result<Broken, Error> {
    break_scene(scene, request, &Context::quiet())
}

/// Triangles of the pieces beyond those of the input.
fn added(broken: &Broken) -> usize {
    let pieces = broken.report.pieces.iter();
    pieces.map(|p| p.triangles).sum::<usize>() - broken.report.input.triangles
}

fn is_sound(broken: &Broken, what: &str) {
    for (node, piece) in broken.scene.nodes.iter().zip(&broken.report.pieces) {
        let check = node.mesh.check();
        assert_eq!(check.triangles, piece.triangles);
        assert!(
            check.closed && check.oriented,
            "{what}, {}: {check}",
            node.name
        );
        let crossing = check.self_intersections.as_ref().map(|s| s.crossing);
        assert_eq!(crossing, Some(0), "{what}, {}: {check}", node.name);
    }
}

#[test]
fn breaks_of_all_kinds_keep_a_budget_and_use_most_of_it() {
    // Spiral grain has levels in the skin, and fraying needs the skin in small triangles.
    for (name, settings, presets, fray, small) in [
        ("smooth", &["surface=smooth"][..], &[][..], 0.0, 5_000),
        ("fibrous", &[], &[], 0.0, 5_000),
        ("frayed", &[], &[], 0.5, 18_500),
        ("twist", &[], &["twist"], 0.0, 14_000),
    ] {
        let free = request(settings, presets, None, fray);
        let free = added(&broken(built_in_branch(), &free).unwrap());
        for most in [small, 20_000] {
            let asked = request(settings, presets, Some(most), fray);
            let made = broken(built_in_branch(), &asked);
            let made = made.unwrap_or_else(|e| panic!("{name}, {most}: {e}"));
            let (what, added) = (format!("{name}, {most}"), added(&made));
            assert!(added <= most as usize, "{what}: {added}");
            let enough = free.min((0.6 * f64::from(most)) as usize);
            assert!(added >= enough, "{what}: {added} of {free}");
            is_sound(&made, &what);
            let noted = made
                .report
                .notes
                .iter()
                .any(|n| n.contains("within its triangles"));
            assert_eq!(noted, free > most as usize, "{what}");
        }
    }
}

#[test]
fn a_budget_holds_on_a_tree_of_large_triangles_and_for_what_is_drawn() {
    let scene = greenstick::files::read(&data("kaykit_Tree_Bare_1_C_Color1.obj"), None).unwrap();
    let asked = request(&[], &["twist"], Some(20_000), 0.0);
    let mut session = BreakSession::new(scene);
    let made = session.broken(&asked, &Context::quiet()).unwrap();
    let pieces: usize = made.report.pieces.iter().map(|p| p.triangles).sum();
    // The whole tree has fewer than 2,000.
    assert!(pieces < 22_000, "{pieces}");
    let stages = session.stages(&asked, &Context::quiet()).unwrap();
    let drawn = stages.layout.bundles.bundles.len();
    assert_eq!(drawn, made.report.face.bundles);
}

#[test]
fn a_budget_that_is_too_small_says_the_least() {
    for presets in [&[][..], &["twist"]] {
        let refused = broken(built_in_branch(), &request(&[], presets, Some(40), 0.0)).unwrap_err();
        let text = refused.to_string();
        assert!(
            text.starts_with("40 triangles are too few for this break"),
            "{text}"
        );
        let least: u32 = text.rsplit(' ').next().unwrap().parse().unwrap();
        let asked = request(&[], presets, Some(least), 0.0);
        let made = broken(built_in_branch(), &asked).unwrap();
        assert!(added(&made) <= least as usize, "{} {text}", added(&made));
        is_sound(&made, &text);
    }
}
