//! Scenes: the built-in ones, what is refused and how, and a bundle set up in one.

use glam::{DAffine3, DQuat, DVec3, dvec3};
use greenstick_fibre::placement::WoodMaterial;
use greenstick_fibre::scene::{
    AssembledScene, BUILT_IN, BodyKeys, ClampKeys, ForceKeys, KeyFrame, Scene, SolverChoice,
    StemChoice, UpChoice, assemble,
};
use greenstick_fibre::simulate::{FilledStem, fill_scene_stem};
use greenstick_fibre::{
    Forces, Implicit, Motion, NoContacts, Rod, RodBundle, RodMaterial, Solver, World,
};
use greenstick_geometry::{Context, Node};
use greenstick_schema::Parameters;
use greenstick_wood::primitive::cylinder;
use greenstick_wood::stem::StemLocation;

/// Four rods along a slanted line, 20 cm long, 11 vertices each.
fn sticks() -> (RodBundle, Vec<f64>) {
    let along = dvec3(1.0, 2.0, 0.5).normalize();
    let across = along.any_orthonormal_vector();
    let material = RodMaterial::solid(4e-6, 1e9, 1e8, 600.0);
    let mut lengths = Vec::new();
    let rods: Vec<Rod> = (0..4)
        .map(|r| {
            let side =
                across * 2e-3 * f64::from(r & 1) + along.cross(across) * 2e-3 * f64::from(r >> 1);
            let place = |i: i32| DVec3::ONE + side + along * (0.02 * f64::from(i));
            lengths.extend((0..11).map(|i| 0.3 + 0.02 * f64::from(i)));
            Rod::new((0..11).map(place).collect(), material)
        })
        .collect();
    (RodBundle::new(&rods, false).unwrap(), lengths)
}

#[test]
fn built_in_scenes_can_be_read_and_written_without_loss() {
    for built_in in BUILT_IN {
        let scene = built_in
            .scene()
            .unwrap_or_else(|e| panic!("{}: {e}", built_in.name));
        assert!(!scene.about.is_empty(), "{}", built_in.name);
        let again = Scene::read(&scene.to_toml()).unwrap();
        assert_eq!(again, scene, "{}", built_in.name);
    }
    let message = Scene::built_in("three-bloks").unwrap_err().to_string();
    assert!(
        message.contains("did you mean \"three-blocks\""),
        "{message}"
    );
}

#[test]
fn every_key_is_documented_and_its_default_in_range() {
    let page = Scene::reference_markdown();
    let sets = [
        Scene::table(),
        ClampKeys::table(),
        ForceKeys::table(),
        BodyKeys::table(),
        KeyFrame::table(),
    ];
    let keys = sets.concat();
    assert!(keys.len() > 70);
    for k in &keys {
        assert!(!k.doc.is_empty(), "{}", k.key);
        assert!(page.contains(&format!("| `{}` |", k.key)), "{}", k.key);
        assert_eq!(k.read(&k.value), Ok(k.value.clone()), "{}", k.key);
    }
    for list in ["clamp", "clamp.key", "force", "body", "body.key"] {
        assert!(page.contains(&format!("## `[[{list}]]`")), "{list}");
    }
    assert_eq!(Scene::default().check(), Ok(()));
}

#[test]
fn lengths_are_written_in_every_form_that_means_them() {
    let scene = |text: &str| Scene::read(text).unwrap();
    let edges = scene("[rods]\nedge = [\"7 cm\", \"80mm\"]").rods.edge;
    assert_eq!(edges, [0.07, 0.08]);
    assert_eq!(scene("[rods]\nedge = \"7, 8 cm\"").rods.edge, edges);
    assert_eq!(
        scene("[rods]\nspacing = \"3 mm\"").rods.spacing,
        Some(0.003)
    );
    assert_eq!(scene("[rods]\nspacing = \"auto\"").rods.spacing, None);
    let body = |text: &str| scene(&format!("[[body]]\n{text}")).body.remove(0);
    assert_eq!(body("place = \"0, -7.5, 2 cm\"").place, [0.0, -0.075, 0.02]);
    assert_eq!(body("touch = [0, 0, -1]").touch, Some([0.0, 0.0, -1.0]));
    for (text, at) in [
        ("\"0.4\"", StemLocation::Fraction(0.4)),
        ("0.4", StemLocation::Fraction(0.4)),
        ("\"12cm\"", StemLocation::Length(0.12)),
    ] {
        assert_eq!(scene(&format!("[stem]\nat = {text}")).stem.at, at);
    }
}

#[test]
fn errors_have_the_line_and_what_would_be_right() {
    for (text, words) in [
        (
            "durration = 3",
            "line 1, column 1: unknown parameter \"durration\"; did you mean \"duration\"",
        ),
        (
            "\n[stem]\nlenght = \"3 cm\"",
            "line 3, column 1: unknown parameter \"stem.lenght\"; did you mean \"stem.length\"",
        ),
        ("[[bdy]]\nshape = \"box\"", "did you mean \"body\""),
        (
            "[[clamp]]\nfrm = 0.1",
            "line 2, column 1: unknown parameter \"frm\"; did you mean \"from\"",
        ),
        (
            "[[clamp]]\n[[clamp.key]]\ntme = 0.1",
            "unknown parameter \"tme\"; did you mean \"time\"",
        ),
        (
            "[stem]\nlength = 3",
            "line 2, column 10: stem.length is \"3\", but it must be a number with a unit: mm, cm, m",
        ),
        (
            "[stem]\nlength = \"3 feet\"",
            "stem.length has the unit \"feet\"; it takes mm, cm, m",
        ),
        (
            "[stem]\nkind = \"tube\"",
            "stem.kind is \"tube\", but it must be one of branch, cylinder, board, input",
        ),
        ("[stem]\nat = \"1,2\"", "2 coordinates instead of three"),
        (
            "[stem]\npart = [0.5, 0.5]",
            "part is from 0.5 to 0.5, but the first must be below the second",
        ),
        (
            "[wood]\nstiffness = -1.0",
            "wood.stiffness is -1, but it must be from 0.000001 to 100",
        ),
        (
            "duration = nan",
            "duration is NaN, but it must be from 0 to 1000000 s",
        ),
        ("[[body]]\nsize = \"1, -2, 3 cm\"", "size is -0.02"),
        (
            "[[clamp]]\naxes = \"xw\"",
            "axes: \"xw\" does not name directions; expected one or more of x, y and z",
        ),
        (
            "[rods]\nedge = [\"5 mm\", \"4 mm\"]",
            "edge is from 0.005 to 0.004 m, but the first must not be above the second",
        ),
        ("seed = \"x", "line 1"),
    ] {
        let message = Scene::read(text).unwrap_err().to_string();
        assert!(message.contains(words), "{text:?}: {message}");
    }
}

#[test]
fn a_bundle_lies_in_the_scenes_axes_and_bodies_touch_it() {
    let (bundle, along) = sticks();
    let thick = bundle.diameter[0];
    let scene = Scene::read(
        "[contact]\nrods = false\n\
         [[clamp]]\nfrom = 0.0\nto = 0.1\n[[clamp.key]]\ntime = 0\n[[clamp.key]]\ntime = 2\nmove_by = \"0, 0, 1 cm\"\nturn = [0, 90, 0]\n\
         [[body]]\nname = \"floor\"\nshape = \"half-space\"\ntouch = [0, 0, -1]\ngap = \"1 mm\"\n\
         [[body]]\nshape = \"sphere\"\ndiameter = \"2 cm\"\nat = 0.5\ntouch = [0, 0, 1]",
    )
    .unwrap();
    let made = assemble(&scene, bundle, &along, &[], &Context::quiet()).unwrap();
    let bundle = &made.world.bundle;
    assert!((made.length - 0.2).abs() < 1e-12);
    for i in 0..bundle.vertices() {
        let p = bundle.rest.get(i);
        assert!((p.x - 0.2 * made.fraction[i]).abs() < 1e-12, "{p}");
        assert!(p.y.hypot(p.z) < 1.5e-3, "{p}");
    }
    let lowest = bundle.rest.z.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = bundle
        .rest
        .z
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let places: Vec<DVec3> = made.bodies.iter().map(|b| b.1.centre).collect();
    assert!(
        (places[0].z - (lowest - 0.5 * thick - 1e-3)).abs() < 1e-6,
        "{places:?}"
    );
    // The ball touches at most two rods' skins: between top and bottom of a ball on two ridges.
    let top = places[1].z - 0.01 - 0.5 * thick;
    assert!(
        top <= highest + 1e-6 && top > highest - 1e-3,
        "{places:?} {highest}"
    );
    let clamp = &made.world.loads.clamps[0];
    assert_eq!(clamp.vertices.len(), 8);
    let Motion::Keyframes(keys) = &clamp.motion else {
        panic!("{clamp:?}")
    };
    assert!((keys[1].pose.rotation * DVec3::X).distance(DVec3::NEG_Z) < 1e-12);
}

/// The sum of all loads on the sticks in a scene at a time (s), N, and the scene.
fn load_at(text: &str, time: f64) -> (DVec3, AssembledScene) {
    let (bundle, along) = sticks();
    let scene = Scene::read(text).unwrap();
    let made = assemble(&scene, bundle, &along, &[], &Context::quiet()).unwrap();
    let World {
        bundle,
        state,
        loads,
        ..
    } = &made.world;
    let mut forces = Forces::zeros(bundle.vertices());
    loads.add_forces(bundle, time, &state.position, &state.velocity, &mut forces);
    let sum = (0..bundle.vertices()).fold(DVec3::ZERO, |sum, i| sum + forces.linear.get(i));
    (sum, made)
}

#[test]
fn what_lies_under_snow_falls_no_faster_than_it() {
    let wood = sticks().0.total_mass();
    let (weight, length, g) = (250.0, 0.2, 9.81);
    let snow = "[loads]\ngravity = [0, 0, -9.81]\nsnow = 250\n";
    for (text, time, expected) in [
        (format!("{snow}snow_rise = 2"), 0.0, wood * g),
        (
            format!("{snow}snow_rise = 2"),
            1.0,
            wood * g + 0.5 * weight * length,
        ),
        (
            format!("{snow}snow_rise = 2"),
            3.0,
            wood * g + weight * length,
        ),
        (snow.to_owned(), 0.0, wood * g + weight * length),
        ("[loads]\nsnow = 250".to_owned(), 0.0, weight * length),
    ] {
        let (load, made) = load_at(&text, time);
        assert!(
            load.distance(DVec3::NEG_Z * expected) < 1e-9 * expected,
            "{text} at {time}: {load}"
        );
        let mass = made.world.bundle.total_mass();
        assert!(
            (mass / (wood + weight * length / g) - 1.0).abs() < 1e-3,
            "{mass}"
        );
    }
    // Nothing holds it: it falls freely, where 250 N/m on wood of 2 g would give it 2,500 times that.
    let mut world = load_at(snow, 0.0).1.world;
    let mut solver = Implicit::new(Some(1e-3));
    solver
        .advance(&mut world, &mut NoContacts, 0.01, &Context::quiet())
        .unwrap();
    for i in 0..world.bundle.vertices() {
        let velocity = world.state.velocity.get(i);
        assert!(
            velocity.distance(DVec3::NEG_Z * g * 0.01) < 1e-6,
            "{velocity}"
        );
    }
}

#[test]
fn wind_rises_with_its_velocity() {
    let wind = "[loads]\nwind = [0, 10, 0]\nwind_rise = 2\ndrag = 8";
    let full = load_at(wind, 2.0).0;
    // Half a density of 1.2 kg/m³ × 8 × the width of a circle of the rods' area × the length.
    let width = 2.0 * (4.0 * 4e-6 / std::f64::consts::PI).sqrt();
    let expected = DVec3::Y * (0.5 * 1.2 * 8.0 * width * 0.2 * 100.0);
    assert!(full.distance(expected) < 1e-9, "{full} {expected}");
    assert!(load_at(wind, 1.0).0.distance(0.25 * full) < 1e-12);
    assert_eq!(load_at(wind, 0.0).0, DVec3::ZERO);
}

#[test]
fn a_wedge_points_into_the_wood() {
    let text = "[[body]]\nshape = \"wedge\"\nsize = \"8, 4, 2 cm\"\nat = 1\ntouch = [1, 0, 0]";
    let made = load_at(text, 0.0).1;
    // Its edge is at the end of the stem, and lies along y.
    let centre = made.bodies.iter().next().unwrap().1.centre;
    assert!((centre.x - 0.04 - 0.2).abs() < 2e-3, "{centre}");
    let shape = Scene::read(text).unwrap().body[0]
        .body_shape(0, None)
        .unwrap();
    let surface = shape.surface(0, false).unwrap().unwrap();
    let edge: Vec<DVec3> = surface.points.into_iter().filter(|p| p.x < 0.0).collect();
    assert!(
        edge.iter()
            .all(|p| p.z == 0.0 && p.x == -0.04 && p.y.abs() == 0.02),
        "{edge:?}"
    );
    assert_eq!(edge.len(), 2);
}

#[test]
fn scenes_that_do_not_fit_the_bundle_are_refused() {
    for (text, words) in [
        (
            "[[clamp]]\nfrom = 0.41\nto = 0.49",
            "clamp 0 holds nothing: no vertex lies from 0.41 to 0.49",
        ),
        ("[[body]]\nshape = \"box\"", "deep in body 0"),
        (
            "[[body]]\nshape = \"hull\"\nplace = \"0, 0, 9 cm\"",
            "needs the name of a mesh file",
        ),
        (
            "[[body]]\nshape = \"box\"\nplace = \"0, 9, 0 cm\"\ntouch = [0, 0, 1]",
            "never touches the stem",
        ),
        (
            "[[body]]\nplace = \"0, 9, 0 cm\"\nmotion = \"free\"\n[[body]]\nplace = \"0, 10, 0 cm\"",
            "bodies 0 and 1 overlap",
        ),
        (
            "[[clamp]]\n[[clamp.key]]\ntime = 1\n[[clamp.key]]\ntime = 0.5",
            "0.5 s does not",
        ),
    ] {
        let (bundle, along) = sticks();
        let scene = Scene::read(text).unwrap();
        let message = assemble(&scene, bundle, &along, &[], &Context::quiet())
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default();
        assert!(message.contains(words), "{text:?}: {message}");
    }
}

#[test]
fn a_bent_start_has_the_energy_of_the_bent_beam() {
    // Four rods of E A each: ½ κ² L Σ(E I + E A z²) about the arc that keeps the length.
    let (bundle, along) = sticks();
    let scene = Scene::read("[start]\nbend = 12.0").unwrap();
    let (area, bend) = (4e-6, bundle.bend[1]);
    let made = assemble(&scene, bundle, &along, &[], &Context::quiet()).unwrap();
    let kappa = 12f64.to_radians() / 0.2;
    let rest = &made.world.bundle.rest;
    let mut expected = 0.0;
    for r in 0..4 {
        let z = rest.get(r * 11).z;
        expected += 0.5 * kappa * kappa * 0.2 * (1e9 * area * z * z + bend);
    }
    let found =
        greenstick_fibre::energy::energies(&made.world.bundle, &made.world.state).potential();
    // Of 10 edges the curvature is at 9 vertices, and chords are shorter than arcs.
    assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
}

#[test]
fn every_solver_takes_the_scenes_that_it_can_and_refuses_the_others_with_a_reason() {
    for built_in in BUILT_IN {
        for solver in SolverChoice::ALL {
            let scene = Scene {
                solver,
                ..built_in.scene().unwrap()
            };
            let held = [
                "bend",
                "twist",
                "pull",
                "strip",
                "snow",
                "gust",
                "green-twig",
            ];
            let still = !held.contains(&built_in.name);
            let message = scene.check().map_err(|e| e.to_string());
            if solver == SolverChoice::QuasiStatic && still {
                let message = message.unwrap_err();
                assert!(
                    message.contains("quasi-static solver cannot be used here: it has no inertia"),
                    "{}: {message}",
                    built_in.name
                );
            } else {
                assert_eq!(message, Ok(()), "{}", built_in.name);
                assert_eq!(scene.make_solver().name(), solver.word());
                assert_eq!(Scene::read(&scene.to_toml()).unwrap().solver, solver);
            }
        }
    }
    let message = Scene::read("solver = \"implicit\"\n[[body]]\nmotion = \"free\"").unwrap_err();
    assert!(
        message.to_string().contains("body 0 moves freely"),
        "{message}"
    );
}

#[test]
fn edges_are_shorter_where_a_scene_says_so_and_nowhere_else() {
    let filled = |fine: Option<[f64; 2]>| {
        let mut scene = Scene::built_in("pull").unwrap();
        (scene.rods.fine, scene.rods.fineness) = (fine, 2.0);
        fill_scene_stem(&scene, None, &Context::quiet()).unwrap()
    };
    let (even, fine) = (filled(None), filled(Some([0.4, 0.6])));
    let bundle = &fine.placed.bundle;
    // Edges of 5 to 7 mm on 15 cm; those of a rod are stretched together to end at its end.
    let (mut near, mut far) = (0, 0);
    for j in (0..bundle.vertices()).filter(|&j| bundle.is_edge(j)) {
        let middle = 0.5 * (fine.placed.along[j] + fine.placed.along[j + 1]);
        let place = middle - fine.stem.usable.0;
        let length = bundle.rest_length[j];
        if (0.065..0.085).contains(&place) {
            near += 1;
            assert!((2.2e-3..3.8e-3).contains(&length), "{length} at {place}");
        } else if !(0.05..0.1).contains(&place) {
            far += 1;
            assert!((4.4e-3..7.6e-3).contains(&length), "{length} at {place}");
        }
    }
    assert!(near > 300 && far > 600, "{near} {far}");
    let masses = [&even, &fine].map(|f| f.placed.bundle.total_mass());
    assert!((masses[1] / masses[0] - 1.0).abs() < 1e-9, "{masses:?}");
    // Twice as many edges, the weakest of each rod as strong as before: 2^(1/12), 6 %, weaker otherwise.
    let weakest = |filled: &FilledStem| {
        let (bundle, along) = (&filled.placed.bundle, &filled.placed.along);
        let of_rod = |rod: usize| {
            let within = |v: &usize| (0.062..0.088).contains(&(along[*v] - filled.stem.usable.0));
            let limits = bundle
                .rod(rod)
                .filter(within)
                .map(|v| bundle.tension_limit[v]);
            limits.fold(f64::INFINITY, f64::min)
        };
        (0..bundle.rods()).map(of_rod).sum::<f64>() / bundle.rods() as f64
    };
    let ratio = weakest(&fine) / weakest(&even);
    println!("the weakest of each rod is {ratio} times as strong");
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}

#[test]
fn brash_wood_is_as_much_weaker_in_tension_and_in_nothing_else() {
    let filled = |brash: f64| {
        let mut scene = Scene::built_in("pull").unwrap();
        scene.wood.brash = brash;
        fill_scene_stem(&scene, None, &Context::quiet()).unwrap()
    };
    let (sound, brash) = (filled(0.0), filled(0.5));
    assert_eq!(brash.wood.tension, 0.5 * sound.wood.tension);
    let others = WoodMaterial {
        tension: sound.wood.tension,
        ..brash.wood
    };
    assert_eq!(others, sound.wood);
    let limits = |filled: &FilledStem| filled.placed.bundle.tension_limit.iter().sum::<f64>();
    let part = limits(&brash) / limits(&sound);
    assert!((0.4..0.6).contains(&part), "{part}");
}

/// A round stem along y of a length (m), turned.
fn standing(length: f64, turn: DQuat) -> greenstick_geometry::Scene {
    let mesh = cylinder(0.02 * length, length, 24);
    greenstick_geometry::Scene {
        nodes: vec![Node::new("stem", DAffine3::from_quat(turn), mesh)],
        ..Default::default()
    }
}

#[test]
fn loads_act_on_an_input_as_it_stands() {
    let mut scene = Scene::built_in("gust").unwrap();
    scene.stem.kind = StemChoice::Input;
    (scene.loads.snow, scene.loads.snow_rise) = (100.0, 2.0);
    // Upright, leaning in two directions, level both ways.
    for (about, degrees) in [
        (0.0, 90.0),
        (0.0, 55.0),
        (130.0, 60.0),
        (0.0, 0.0),
        (0.0, 180.0),
    ] {
        for up in [UpChoice::Y, UpChoice::Z] {
            let vertical = match up {
                UpChoice::Y => DVec3::Y,
                UpChoice::Z => DVec3::Z,
            };
            let z_up = DQuat::from_rotation_arc(DVec3::Z, vertical);
            scene.stem.up = Some(up);
            let about = DQuat::from_rotation_z(f64::to_radians(about));
            let turn = z_up * about * DQuat::from_rotation_x(f64::to_radians(degrees));
            let mut lean = |inclination: Option<f64>| {
                scene.stem.inclination = inclination;
                let input = standing(2.0, turn);
                let filled = fill_scene_stem(&scene, Some(&input), &Context::quiet()).unwrap();
                let noted = filled.notes.iter().any(|n| n.contains("as in the input"));
                assert_eq!(noted, inclination.is_none(), "{:?}", filled.notes);
                let (bundle, along) = (filled.placed.bundle, &filled.placed.along);
                assemble(&scene, bundle, along, &[], &Context::quiet()).unwrap()
            };
            let made = lean(None);
            let to_world = made.scene_from_stem.matrix3.transpose();
            let gravity = to_world * made.world.loads.gravity;
            let off = (gravity + 9.81 * vertical).length();
            assert!(off < 1e-9, "{gravity}");
            // What is held up of the snow at first is held against gravity.
            let held: DVec3 = made.world.loads.forces.iter().map(|f| f.force).sum();
            let held = to_world * held / (100.0 * made.length);
            assert!((held - vertical).length() < 1e-6, "{held}");
            let wind = to_world * made.world.loads.wind.unwrap().velocity;
            let axis = (turn * DVec3::Y).reject_from_normalized(vertical);
            assert!(
                (wind.length() - 45.0).abs() < 1e-9 && wind.dot(vertical).abs() < 1e-9,
                "{wind}"
            );
            assert!(wind.dot(axis).abs() < 1e-6, "{wind} {axis}");
            // The same angle by hand.
            let level = lean(Some(0.0)).world.loads.gravity;
            assert!((level - dvec3(0.0, 0.0, -9.81)).length() < 1e-12, "{level}");
            let rise = made.scene_from_stem.matrix3.transpose() * DVec3::X;
            let by_hand = lean(Some(libm::asin(rise.dot(vertical)).to_degrees()));
            let along = by_hand.world.loads.gravity.x;
            assert!((along + 9.81 * rise.dot(vertical)).abs() < 1e-9, "{along}");
        }
    }
}

#[test]
fn a_mesh_in_millimetres_that_is_read_as_metres_is_refused_by_its_length() {
    let mut scene = Scene::built_in("pull").unwrap();
    scene.stem.kind = StemChoice::Input;
    let fill = |length| {
        fill_scene_stem(
            &scene,
            Some(&standing(length, DQuat::IDENTITY)),
            &Context::quiet(),
        )
    };
    assert!(fill(1.9).is_ok());
    let message = fill(1900.0).unwrap_err().to_string();
    assert!(
        message.contains("1.894e3 m") && message.contains("0.001 to 200 m"),
        "{message}"
    );
}
