//! No two breaks are twins: each stem, and each place of one, breaks in a way of its own, which stays the same while the place
//! is moved and the mesh is rounded.

use crate::support;
use crate::support::data::data;
use crate::support::scene;
use greenstick::geometry::{Context, Mesh, Scene};
use greenstick::wood::primitive::{self, BranchOptions};
use greenstick::wood::stem::StemLocation;
use greenstick::{Break, BreakRequest, BreakSession, Broken, built_in_branch};
use std::collections::BTreeSet;

fn at(places: &[StemLocation]) -> BreakRequest {
    let one = |&place: &StemLocation| {
        let mut one = Break {
            place,
            ..Break::default()
        };
        (one.recipe.face.rings, one.recipe.face.sectors) = (10, 24);
        one
    };
    BreakRequest {
        breaks: places.iter().map(one).collect(),
        texture_width: 8,
        ..BreakRequest::default()
    }
}

/// The seed of the break at a place.
fn seed(scene: &Scene, place: StemLocation) -> u64 {
    let mut session = BreakSession::new(scene.clone());
    let stem = session.stem(&at(&[place]), &Context::quiet());
    stem.unwrap_or_else(|e| panic!("{place:?}: {e}")).face.seed
}

fn middle(scene: &Scene) -> u64 {
    seed(scene, StemLocation::Fraction(0.5))
}

fn broken(scene: Scene, request: &BreakRequest) -> Broken {
    let broken = BreakSession::new(scene).broken(request, &Context::quiet());
    broken.unwrap_or_else(|e| panic!("{e}"))
}

fn scaled(mesh: &Mesh, scale: f64) -> Mesh {
    mesh.transformed(&glam::DAffine3::from_scale(glam::DVec3::splat(scale)))
}

fn branch(length: f64) -> Mesh {
    primitive::branch(&BranchOptions {
        length,
        ..BranchOptions::default()
    })
}

#[test]
fn every_stem_breaks_in_its_own_way_with_the_same_seed() {
    let longer = scene(branch(0.62), 1.0);
    let pole = support::scanned_pole();
    let board = greenstick::files::read(&data("homecart_cutting_board.gltf"), None).unwrap();
    let scenes = [built_in_branch(), longer, pole, board];
    let seeds: BTreeSet<u64> = scenes.iter().map(middle).collect();
    assert_eq!(seeds.len(), scenes.len());
    // Two alike in one scene are two stems.
    let mut posts = scene(branch(0.6), 1.0);
    let mut other = posts.nodes[0].clone();
    other.transform.translation.x += 1.0;
    posts.nodes.push(other);
    let points = [0.0, 1.0].map(|x| StemLocation::Point(glam::DVec3::new(x, 0.3, 0.0)));
    let [a, b] = points.map(|point| seed(&posts, point));
    assert_ne!(a, b);
}

#[test]
fn rounding_and_units_do_not_change_a_break() {
    for mesh in [
        branch(0.6),
        primitive::cylinder(0.05, 2.0, 24),
        primitive::board(1.0, 0.12, 0.03),
    ] {
        let seed = middle(&scene(mesh.clone(), 1.0));
        for scale in [1.0 - 1e-9, 1.0 + 1e-9] {
            assert_eq!(middle(&scene(scaled(&mesh, scale), 1.0)), seed);
        }
        // Millimetres in a node that is scaled, and rounded as a file rounds them.
        let mut baked = scaled(&mesh, 1000.0);
        for p in &mut baked.positions {
            *p = p.as_vec3().as_dvec3();
        }
        assert_eq!(middle(&scene(baked, 1e-3)), seed);
    }
}

#[test]
fn a_break_that_is_dragged_keeps_its_field() {
    let branch = built_in_branch();
    let seed_of_branch = middle(&branch);
    for place in 1..20 {
        let place = StemLocation::Fraction(0.05 * f64::from(place));
        assert_eq!(seed(&branch, place), seed_of_branch, "{place:?}");
    }
    let on_bark = StemLocation::Point(glam::DVec3::new(0.03, 0.4, 0.0));
    assert_eq!(seed(&branch, on_bark), seed_of_branch);
}

#[test]
fn places_of_one_stem_are_no_twins_and_the_first_is_as_it_would_be_alone() {
    let places = [0.2, 0.5, 0.8].map(StemLocation::Fraction);
    let several = broken(built_in_branch(), &at(&places)).report;
    let alone = broken(built_in_branch(), &at(&places[..1])).report;
    assert_eq!(several.face.seed, alone.face.seed);
    let further = &several.further_breaks;
    let seeds: BTreeSet<u64> = further.iter().map(|b| b.face.seed).collect();
    assert!(seeds.len() == 2 && !seeds.contains(&several.face.seed));
    // The length is that of the whole stem, whatever was broken off before.
    let length = alone.place.stem_length_m;
    for place in further.iter().map(|b| &b.place).chain([&several.place]) {
        assert_eq!(place.stem_length_m, length);
    }
    let text = several.to_string();
    for b in further {
        assert!(text.contains(&format!("seed {}", b.face.seed)), "{text}");
    }
    assert_eq!(text.matches("place    ").count(), 3, "{text}");
    // What differs is more than a number.
    let range = |b: &greenstick::BreakReport, i: usize| b.further_breaks[i].face.wanted_m;
    assert_ne!(range(&several, 0), range(&several, 1));
}

#[test]
fn a_stem_breaks_at_every_multiple_of_a_length() {
    let trunk = scene(primitive::cylinder(0.05, 2.3, 24), 1.0);
    let request = BreakRequest {
        every: Some(0.5),
        ..at(&[StemLocation::Fraction(0.5)])
    };
    let made = broken(trunk.clone(), &request);
    let report = &made.report;
    let further = report.further_breaks.iter().map(|b| &b.place);
    let places: Vec<f64> = [&report.place]
        .into_iter()
        .chain(further)
        .map(|p| p.length_m)
        .collect();
    assert_eq!(places.len(), 4);
    for (place, wanted) in places.iter().zip([0.5, 1.0, 1.5, 2.0]) {
        assert!((place - wanted).abs() < 1e-3, "{places:?}");
    }
    assert_eq!(report.pieces.len(), 5);
    let volumes: Vec<f64> = report.pieces.iter().map(|p| p.volume_m3.unwrap()).collect();
    let whole = report.input.volume_m3.unwrap();
    assert!((volumes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-6);
    for (volume, length) in volumes.iter().zip([0.5, 0.5, 0.5, 0.5, 0.3]) {
        // Faces are no planes: a piece has as much wood as its length, and a little of its neighbours'.
        assert!(
            (volume / whole * 2.3 / length - 1.0).abs() < 0.25,
            "{volumes:?}"
        );
    }
    let refused = |request: &BreakRequest| {
        let made = BreakSession::new(trunk.clone()).broken(request, &Context::quiet());
        made.unwrap_err().to_string()
    };
    let every = |every| BreakRequest {
        every: Some(every),
        ..request.clone()
    };
    assert!(refused(&every(0.03)).contains("between them, its radius"));
    assert!(refused(&every(0.01)).contains("at most 100"));
    assert!(refused(&every(3.0)).contains("2.300 m long"));
    let both = [0.4, 0.6].map(StemLocation::Fraction);
    let both = BreakRequest {
        every: Some(0.5),
        ..at(&both)
    };
    assert!(refused(&both).contains("one or the other"));
    let close = [0.5, 0.2, 0.51].map(StemLocation::Fraction);
    assert!(refused(&at(&close)).starts_with("breaks 1 and 3 are at 1.1500 and 1.1730 m"));
}

/// A stem that is thickest in its middle, and a little thicker at its base: what is left of it is thicker at the break.
/// The root of a limb that is stuck in the trunk is nearer to the middle of one place than the trunk's own skin.
#[test]
fn a_trunk_with_limbs_breaks_at_every_multiple_of_a_length() {
    let tree = greenstick::files::read(&data("kaykit_Tree_Bare_1_C_Color1.obj"), None).unwrap();
    let request = BreakRequest {
        every: Some(0.5),
        ..at(&[StemLocation::Fraction(0.5)])
    };
    let broken = broken(tree, &request);
    let report = &broken.report;
    let mut places = vec![report.place.length_m];
    places.extend(report.further_breaks.iter().map(|b| b.place.length_m));
    assert!(places.len() >= 8, "{places:?}\n{report}");
    let failed = |note: &String| note.starts_with("no break at") && !note.contains("not free");
    assert!(!report.notes.iter().any(failed), "{report}");
}

#[test]
fn a_stem_that_is_thick_in_its_middle_breaks_from_its_tip_to_its_base() {
    let mut spindle = primitive::cylinder_of(0.04, 2.0, 32, 60);
    for p in &mut spindle.positions {
        let along = p.y / 2.0;
        let foot = if along < 0.25 { 0.08 } else { 0.0 };
        let thick = 1.0 + 0.8 * (along * (1.0 - along) * 4.0) + foot;
        (p.x, p.z) = (p.x * thick, p.z * thick);
    }
    let places = [0.25, 0.75, 0.5].map(StemLocation::Fraction);
    let report = broken(scene(spindle, 1.0), &at(&places)).report;
    let further = report.further_breaks.iter().map(|b| &b.place);
    let all = [&report.place].into_iter().chain(further);
    for (place, wanted) in all.zip([0.5, 1.5, 1.0]) {
        assert!((place.length_m - wanted).abs() < 0.02, "{}", place.length_m);
    }
    let parts: f64 = report.pieces.iter().map(|p| p.volume_m3.unwrap()).sum();
    assert!((parts / report.input.volume_m3.unwrap() - 1.0).abs() < 1e-6);
}

#[test]
fn size_changes_a_break_within_bounds() {
    let of_size = |diameter: f64| {
        let mesh = scaled(&branch(0.6), diameter / 0.04);
        let one = BreakRequest {
            texture_width: 8,
            ..BreakRequest::default()
        };
        let mut session = BreakSession::new(scene(mesh, 1.0));
        let stages = session.stages(&one, &Context::quiet()).unwrap();
        let face = stages.stem.face.clone();
        (face, stages.layout.bundles.bundles.len())
    };
    let [twig, branch, log] = [0.01, 0.04, 0.6].map(of_size);
    // Slivers: fewer in a twig; in a log more, and longer in metres, but not in proportion.
    assert!(twig.0.sliver_count * 3 < branch.0.sliver_count);
    assert!(log.0.sliver_count > 5 * branch.0.sliver_count);
    let slivers = |p: &greenstick::fracture::parameters::BreakParameters, diameter| {
        p.sliver_height * diameter
    };
    let grown = slivers(&log.0, 0.6) / slivers(&branch.0, 0.04);
    assert!(grown > 2.0 && grown < 10.0, "{grown}");
    assert!(
        log.1 > branch.1 && log.1 <= 2 * branch.1,
        "{} {}",
        log.1,
        branch.1
    );
    assert!(twig.1 <= branch.1 * 11 / 10);
}
