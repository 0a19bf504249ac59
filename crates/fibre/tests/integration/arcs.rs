//! Clamps that bend the wood between them into an arc, and scenes on stems of other lengths than they were written for.

use greenstick_fibre::energy::strain;
use greenstick_fibre::placement::fill_stem;
use greenstick_fibre::scene::{AssembledScene, BUILT_IN, Scene, assemble};
use greenstick_fibre::store::ForceRow;
use greenstick_fibre::{
    EdgeLengths, FailureCriteria, NoContacts, PlacementOptions, QuasiStatic, RodCount, Solver,
    WoodMaterial,
};
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::{BranchOptions, board, branch, cylinder};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{StemOptions, find_stem};

/// A mesh filled with the scene's number of rods, in the scene.
fn filled(mesh: Mesh, length: f64, scene: &Scene) -> AssembledScene {
    let scene = scene.for_stem(length);
    let whole = "0.5".parse().unwrap();
    let found = find_stem(&[mesh], &whole, &StemOptions::default(), &Context::quiet()).unwrap();
    let ash = Species::find("white ash").unwrap();
    let wood = WoodMaterial::from_species(ash, 12.0, Fallback::Refuse).unwrap();
    let options = PlacementOptions {
        rods: RodCount::Number(scene.rods.number),
        edges: EdgeLengths {
            least: scene.rods.edge[0],
            greatest: scene.rods.edge[1],
        },
        weibull: 12.0,
        ..PlacementOptions::default()
    };
    let placed = fill_stem(&found.stem, &wood, &options, &Context::quiet()).unwrap();
    assemble(&scene, placed.bundle, &placed.along, &[], &Context::quiet()).unwrap()
}

/// The built-in scene, with few rods and without failure.
fn bend() -> Scene {
    let mut scene = Scene::built_in("bend").unwrap();
    scene.rods.number = 24;
    // The arc is that of a continuous stem, from which longer edges deviate more.
    scene.rods.edge = [4e-3, 6e-3];
    scene
}

/// Returns the force on a clamp over the sum of all tension in the middle cross-section, when each end has turned by 11°.
fn relative_pull(made: &mut AssembledScene) -> f64 {
    made.world.failure = FailureCriteria::default();
    made.world.failure.rods_yield = false;
    made.world.failure.rods_break = false;
    let mut solver = QuasiStatic::new(Some(0.05));
    solver
        .advance(&mut made.world, &mut NoContacts, 0.25, &Context::quiet())
        .unwrap();
    let force = ForceRow::take(&mut made.world, &mut made.bodies, 1.0)[1].force;
    let (bundle, state) = (&made.world.bundle, &made.world.state);
    let mut tension = 0.0;
    for rod in 0..bundle.rods() {
        let middle = bundle
            .rod(rod)
            .find(|&j| made.fraction[j + 1] > 0.5)
            .unwrap();
        tension += bundle.stretch[middle] * strain(bundle, state, middle).max(0.0);
    }
    force.length() / tension
}

#[test]
fn a_stem_is_bent_and_not_stretched_whatever_its_length_and_cross_section() {
    let tapered = |length: f64| {
        branch(&BranchOptions {
            length,
            diameter: length / 15.0,
            ..BranchOptions::default()
        })
    };
    for (mesh, length, most) in [
        (board(0.3, 0.03, 0.02), 0.3, 0.01),
        (board(1.2, 0.05, 0.04), 1.2, 0.01),
        (cylinder(0.01, 0.3, 48), 0.3, 0.01),
        (cylinder(0.04, 1.6, 48), 1.6, 0.01),
        (tapered(0.3), 0.3, 0.04),
        (tapered(2.0), 2.0, 0.04),
    ] {
        let mut made = filled(mesh, length, &bend());
        let part = relative_pull(&mut made);
        println!("{length} m: {part}");
        assert!(part < most, "{length} m: {part}");
    }
    // Clamps that only turn stretch it.
    let mut made = filled(cylinder(0.01, 0.3, 48), 0.3, &bend());
    for clamp in &mut made.world.loads.clamps {
        let greenstick_fibre::Motion::Keyframes(keys) = &mut clamp.motion else {
            panic!("{:?}", clamp.motion)
        };
        keys.iter_mut()
            .for_each(|k| k.pose.translation = glam::DVec3::ZERO);
    }
    assert!(relative_pull(&mut made) > 0.2);
}

#[test]
fn clamps_approach_each_other_as_the_chord_of_the_arc_shortens() {
    let made = filled(cylinder(0.01, 0.3, 48), 0.3, &bend());
    let (bundle, clamps) = (&made.world.bundle, &made.world.loads.clamps);
    let rest = &bundle.rest.x;
    let (mut free, rods) = (0.0, bundle.rods() as f64);
    // The neutral axis does not pass through the clamps' centres, which are means of vertices.
    let (mut height, mut weight) = (0.0, 0.0);
    for rod in 0..bundle.rods() {
        let inner = |v: &usize| !clamps.iter().any(|c| c.vertices.contains(&(*v as u32)));
        let (first, last) = (
            bundle.rod(rod).find(inner).unwrap(),
            bundle.rod(rod).rfind(inner).unwrap(),
        );
        height += bundle.stretch[last] * bundle.rest.z[last];
        weight += bundle.stretch[last];
        free += (rest[last + 1] - rest[first - 1]) / rods;
    }
    let off = clamps[0].centre.z + clamps[1].centre.z - 2.0 * height / weight;
    let centres =
        |time: f64| [0, 1].map(|c| clamps[c].centre + clamps[c].motion.pose(time).translation);
    let [a, b] = centres(0.0);
    let whole = a.distance(b);
    for time in [0.07f64, 0.22, 0.48, 0.7] {
        let angle = (45.0 * time).to_radians();
        let chord = free * angle.sin() / angle + (whole - free) * angle.cos() - off * angle.sin();
        let [c, d] = centres(time);
        let found = c.distance(d);
        assert!((found - chord).abs() < 3e-6 * whole, "{found} for {chord}");
        assert!(c.midpoint(d).distance(a.midpoint(b)) < 1e-12);
    }
}

#[test]
fn scenes_scale_with_their_stem() {
    for built_in in BUILT_IN {
        let scene = built_in.scene().unwrap();
        let Some(length) = scene.for_length else {
            assert_eq!(scene.for_stem(7.0), scene, "{}", built_in.name);
            continue;
        };
        assert_eq!(scene.for_stem(length), scene, "{}", built_in.name);
        let larger = scene.for_stem(2.0 * length);
        assert_eq!(larger.for_stem(2.0 * length), larger);
        assert_eq!(Scene::read(&larger.to_toml()).unwrap(), larger);
        assert_eq!(larger.rods.edge[1], 2.0 * scene.rods.edge[1]);
        for (a, b) in larger.body.iter().zip(&scene.body) {
            assert_eq!(a.size[2], 2.0 * b.size[2]);
            assert_eq!((a.diameter, a.gap), (2.0 * b.diameter, 2.0 * b.gap));
            for (a, b) in a.key.iter().zip(&b.key) {
                assert_eq!(a.move_by[2], 2.0 * b.move_by[2]);
            }
        }
        for (a, b) in larger.clamp.iter().zip(&scene.clamp) {
            assert_eq!(a.velocity[0], 2.0 * b.velocity[0]);
        }
        assert_eq!(larger.loads, scene.loads);
    }
}

#[test]
fn an_impossible_arc_is_refused() {
    let two = |one: &str, other: &str| {
        format!("[[clamp]]\nto = 0.1\narc = true\n{one}\n[[clamp]]\nfrom = 0.9\nto = 1.0\n{other}")
    };
    for (text, words) in [
        (
            "[[clamp]]\narc = true".to_owned(),
            "must have two clamps, and it has 1",
        ),
        (two("", ""), "must have key frames"),
        (
            two("", "angular = [0, 5, 0]"),
            "clamp 1 must be moved by key frames",
        ),
    ] {
        let message = Scene::read(&text).unwrap_err().to_string();
        let clamp = message.contains("clamp 0 has arc = true");
        assert!(message.contains(words) && clamp, "{message}");
    }
}
