//! One suite for all solvers, and one bending scene in which they are compared.

use crate::support::{four_rods, soft, straight};
use glam::DVec3;
use greenstick_fibre::energy;
use greenstick_fibre::placement::fill_stem;
use greenstick_fibre::{
    BondCriterion, Clamp, EdgeLengths, EventKind, Explicit, FailureCriteria, Forces, Implicit,
    Interactive, Keyframe, Motion, NoContacts, PlacementOptions, PointForce, Pose, QuasiStatic,
    Ramp, RodBundle, RodCount, Solver, SolverError, WoodMaterial, World,
};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::board;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{StemKind, StemLocation, StemOptions, find_stem};

/// All solvers, with steps of `step` where they take one.
fn solvers(step: Option<f64>) -> Vec<Box<dyn Solver>> {
    vec![
        Box::new(Explicit::new(None)),
        Box::new(Implicit::new(step)),
        Box::new(Interactive::new(step)),
        Box::new(QuasiStatic::new(step)),
    ]
}

#[test]
fn a_bundle_at_rest_stays_where_it_is() {
    for twisting in [false, true] {
        for mut solver in solvers(None) {
            let mut world = World::new(four_rods(twisting));
            world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed)];
            solver
                .advance(&mut world, &mut NoContacts, 0.01, &Context::quiet())
                .unwrap();
            for i in 0..world.bundle.vertices() {
                let moved = world.state.position.get(i) - world.bundle.rest.get(i);
                assert!(moved.length() < 1e-11, "{}: {moved}", solver.name());
            }
            assert_eq!((world.state.time, world.events.len()), (0.01, 0));
        }
    }
}

#[test]
fn a_cantilever_bends_as_beams_do_and_clamps_are_where_they_should_be() {
    for twisting in [false, true] {
        for mut solver in solvers(Some(0.02)) {
            let (edges, length) = (20, 0.2);
            let rod = straight(DVec3::ZERO, length, edges, soft());
            let mut world = World::new(RodBundle::new(&[rod], twisting).unwrap());
            let lift = Motion::Keyframes(vec![
                Keyframe {
                    time: 0.0,
                    pose: Pose::REST,
                },
                Keyframe {
                    time: 0.5,
                    pose: Pose {
                        translation: DVec3::Y * 0.03,
                        ..Pose::REST
                    },
                },
            ]);
            world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], lift)];
            let force = 1e-4;
            world.loads.forces = vec![PointForce {
                vertex: edges as u32,
                force: DVec3::X * force,
                ramp: Ramp::Linear(0.5),
            }];
            world.loads.damping = 12.0;
            solver
                .advance(&mut world, &mut NoContacts, 2.0, &Context::quiet())
                .unwrap();
            // Free from the middle of the clamped edge.
            let free = length - 0.5 * length / edges as f64;
            let expected = force * free.powi(3) / (3.0 * soft().bend);
            let tip = world.state.position.get(edges);
            assert!(
                (tip.x / expected - 1.0).abs() < 0.01,
                "{} {twisting}: {} for {expected}",
                solver.name(),
                tip.x
            );
            let held = world.state.position.get(0);
            assert!((held - DVec3::Y * 0.03).length() < 1e-12, "{held}");
        }
    }
}

#[test]
fn the_same_run_twice_gives_the_same_bits() {
    for k in 0..4 {
        let run = || {
            let mut world = scene();
            solvers(Some(2e-3))[k]
                .advance(&mut world, &mut NoContacts, 5e-3, &Context::quiet())
                .unwrap();
            world.state
        };
        assert_eq!(run(), run());
    }
}

#[test]
fn durations_and_steps_out_of_range_are_refused() {
    for mut solver in solvers(None) {
        let mut world = World::new(four_rods(false));
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let refused = solver.advance(&mut world, &mut NoContacts, bad, &Context::quiet());
            assert!(matches!(refused, Err(SolverError::Value { .. })));
        }
    }
    for mut solver in solvers(Some(-1.0)).into_iter().skip(1) {
        let world = World::new(four_rods(false));
        assert!(matches!(
            solver.step(&world, &Context::quiet()),
            Err(SolverError::Value { .. })
        ));
    }
}

#[test]
fn a_loose_bundle_has_no_equilibrium_under_a_force() {
    let mut world = World::new(four_rods(false));
    world.loads.gravity = DVec3::NEG_Z * 9.8;
    let before = world.state.clone();
    let result =
        QuasiStatic::new(None).advance(&mut world, &mut NoContacts, 1.0, &Context::quiet());
    assert!(matches!(result, Err(SolverError::NotConverged { .. })));
    assert_eq!(world.state, before);
}

/// Approximate deflection of the free end at which the board below breaks, m.
const DEFLECTION_AT_BREAK: f64 = 6e-3;

/// A small oak board, clamped at one end.
fn scene() -> World {
    let oak = Species::find("white oak").unwrap();
    let wood = WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap();
    let options = StemOptions {
        kind: Some(StemKind::Board),
        ..StemOptions::default()
    };
    let mesh = board(0.13, 0.01, 0.01);
    let stem = find_stem(
        &[mesh],
        &StemLocation::Fraction(0.5),
        &options,
        &Context::quiet(),
    )
    .unwrap()
    .stem;
    let placement = PlacementOptions {
        rods: RodCount::Number(9),
        edges: EdgeLengths::even(5e-3),
        range: Some((0.005, 0.125)),
        ..PlacementOptions::default()
    };
    let bundle = fill_stem(&stem, &wood, &placement, &Context::quiet())
        .unwrap()
        .bundle;
    let held: Vec<u32> = (0..bundle.rods())
        .flat_map(|r| [bundle.rod(r).start as u32, bundle.rod(r).start as u32 + 1])
        .collect();
    let mut world = World::new(bundle);
    world.loads.clamps = vec![Clamp::new(&world.bundle, held, Motion::Fixed)];
    world.failure = FailureCriteria {
        rods_break: true,
        rods_yield: true,
        bonds: BondCriterion::Stress,
        ..FailureCriteria::default()
    };
    world
}

#[test]
fn neither_threads_nor_a_new_solver_change_a_bit_of_stateless_solvers() {
    let makers: [fn() -> Box<dyn Solver>; 3] = [
        || Box::new(Implicit::new(Some(0.02))),
        || Box::new(Interactive::new(Some(0.02))),
        || Box::new(QuasiStatic::stateless(Some(0.02))),
    ];
    for make in makers {
        let run = |threads: usize, new_solver: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let mut world = scene();
                pull_ends(&mut world, 0.02);
                let mut solver = make();
                for _ in 0..20 {
                    if new_solver {
                        solver = make();
                    }
                    solver
                        .advance(&mut world, &mut NoContacts, 0.02, &Context::quiet())
                        .unwrap();
                }
                world
            })
        };
        let (one, two) = (run(1, false), run(2, true));
        assert!(
            one.events
                .iter()
                .any(|e| e.kind == EventKind::BondBroke || e.kind == EventKind::RodBroke)
        );
        assert!(one == two, "{}", make().name());
    }
}

/// Moves the free ends of the scene's rods sideways at a speed, m/s. Returns their vertices.
fn pull_ends(world: &mut World, speed: f64) -> Vec<u32> {
    let ends: Vec<u32> = (0..world.bundle.rods())
        .map(|r| world.bundle.rod(r).end as u32 - 1)
        .collect();
    let motion = Motion::Steady {
        velocity: DVec3::Y * speed,
        angular_velocity: DVec3::ZERO,
    };
    world.loads.clamps.push(Clamp {
        axes: [false, true, false],
        ..Clamp::new(&world.bundle, ends.clone(), motion)
    });
    ends
}

/// Bends the scene over `time` seconds until something breaks. Returns the force at that time, N, to a hundredth of the way.
fn force_at_first_break(solver: &mut dyn Solver, time: f64) -> f64 {
    let mut world = scene();
    let ends = pull_ends(&mut world, DEFLECTION_AT_BREAK / time);
    let mut forces = Forces::zeros(world.bundle.vertices());
    let mut last = 0.0;
    for _ in 0..300 {
        solver
            .advance(&mut world, &mut NoContacts, time / 100.0, &Context::quiet())
            .unwrap();
        if world.events.iter().any(|e| e.kind != EventKind::RodYielded) {
            return last;
        }
        forces.clear();
        energy::add_forces(&world.bundle, &world.state, &mut forces);
        last = -ends
            .iter()
            .map(|&v| forces.linear.get(v as usize).y)
            .sum::<f64>();
    }
    panic!("{}: nothing broke at {last} N", solver.name());
}

#[test]
fn solvers_agree_on_the_force_at_first_break() {
    let reference = force_at_first_break(&mut QuasiStatic::new(None), 0.012);
    let explicit = force_at_first_break(&mut Explicit::new(None), 0.012);
    let implicit = force_at_first_break(&mut Implicit::new(Some(1.0 / 240.0)), 0.5);
    let interactive = force_at_first_break(&mut Interactive::new(Some(1.0 / 60.0)), 1.0);
    println!(
        "quasi-static {reference} N, explicit {explicit} N, implicit {implicit} N, interactive {interactive} N"
    );
    let forces = [reference, explicit, implicit, interactive];
    for a in forces {
        for b in forces {
            assert!((a / b - 1.0).abs() < 0.1, "{forces:?}");
        }
    }
}

#[test]
fn the_load_at_the_onset_of_a_crack_hardly_depends_on_the_step() {
    let [long, short] = [0.5, 0.05].map(|step| {
        let mut world = scene();
        pull_ends(&mut world, DEFLECTION_AT_BREAK);
        let mut solver = Interactive::new(Some(step));
        while world.onsets.is_empty() {
            assert!(world.state.time < 2.0);
            solver
                .advance(&mut world, &mut NoContacts, step, &Context::quiet())
                .unwrap();
        }
        world.onsets[0].clamps[1].force.y
    });
    assert!((long / short - 1.0).abs() < 0.05, "{long} N and {short} N");
}

#[test]
fn a_small_load_on_all_vertices_is_balanced() {
    // On a free rod in tension, a weight that is at each vertex half of what the interactive solver may leave unbalanced there.
    // It sinks as implicit Euler has it. No clamp moves, which would make the solver iterate.
    let (edges, tension, damping, dt) = (40, 1.0, 5000.0, 1.0 / 30.0);
    let rod = straight(DVec3::ZERO, 0.2, edges, soft());
    let mut world = World::new(RodBundle::new(&[rod], false).unwrap());
    world.failure = FailureCriteria::default();
    let pull = |vertex: usize, force: f64| PointForce {
        vertex: vertex as u32,
        force: DVec3::Z * force,
        ramp: Ramp::Constant,
    };
    world.loads.forces = vec![pull(0, -tension), pull(edges, tension)];
    world.loads.damping = damping;
    let mut solver = Interactive::new(Some(dt));
    solver
        .advance(&mut world, &mut NoContacts, 1.0, &Context::quiet())
        .unwrap();
    let gravity = 0.005 * tension / world.bundle.mass[1];
    world.loads.gravity = DVec3::Y * -gravity;
    solver
        .advance(&mut world, &mut NoContacts, 2.0, &Context::quiet())
        .unwrap();
    let (mut velocity, mut fallen) = (0.0, 0.0);
    for _ in 0..60 {
        velocity = (velocity + gravity * dt) / (1.0 + damping * dt);
        fallen += velocity * dt;
    }
    assert!(fallen > 0.05, "{fallen}");
    for y in &world.state.position.y {
        assert!((-y / fallen - 1.0).abs() < 0.01, "{y} for {fallen}");
    }
}
