//! Bodies and colliding rods: conserved quantities, closed forms, and refusals.

use crate::support::four_rods;
use glam::{DQuat, DVec3, dvec3};
use greenstick_fibre::bodies::{Bodies, Body, BodyError, BodyMotion, ContactOptions, Shape};
use greenstick_fibre::energy;
use greenstick_fibre::store::{EnergyLedger, EnergyRow, stagger_velocities};
use greenstick_fibre::{
    Clamp, ContactStep, Contacts, Explicit, Forces, Implicit, Interactive, Loads, Motion,
    QuasiStatic, Rod, RodBundle, RodMaterial, Solver, State, World,
};
use greenstick_geometry::Context;

/// A plain step of symplectic Euler without twist: these tests are about contacts.
fn step(bundle: &RodBundle, state: &mut State, contacts: &mut Bodies, dt: f64, gravity: DVec3) {
    let mut forces = Forces::zeros(bundle.vertices());
    energy::add_forces(bundle, state, &mut forces);
    let mut velocity = state.velocity.clone();
    for i in 0..bundle.vertices() {
        let a = forces.linear.get(i) / bundle.mass[i] + gravity;
        velocity.add(i, a * dt);
    }
    let step = ContactStep {
        bundle,
        state,
        length: dt,
    };
    contacts
        .resolve(&step, &mut velocity, &Context::quiet())
        .unwrap();
    for i in 0..bundle.vertices() {
        state.position.add(i, velocity.get(i) * dt);
    }
    state.velocity = velocity;
    state.time += dt;
}

fn rod(from: DVec3, to: DVec3, edges: usize) -> Rod {
    let material = RodMaterial::solid(4e-6, 2e7, 1e6, 600.0);
    let vertices = (0..=edges).map(|i| from.lerp(to, i as f64 / edges as f64));
    Rod::new(vertices.collect(), material)
}

fn free(shape: Shape, position: DVec3, velocity: DVec3, angular_velocity: DVec3) -> Body {
    Body {
        motion: BodyMotion::Free {
            density: 500.0,
            velocity,
            angular_velocity,
        },
        restitution: 1.0,
        ..Body::fixed(shape, position)
    }
}

fn two_rods() -> RodBundle {
    let rods = [
        rod(dvec3(-0.05, 0.0, 0.0), dvec3(0.05, 0.0, 0.0), 12),
        rod(dvec3(-0.02, 0.01, -0.05), dvec3(-0.02, 0.01, 0.05), 12),
    ];
    RodBundle::new(&rods, false).unwrap()
}

#[test]
fn rods_and_free_bodies_conserve_momenta_and_energy() {
    let bundle = two_rods();
    for friction in [0.0, 0.4] {
        let mut state = State::at_rest(&bundle);
        for i in 0..13 {
            state.velocity.set(i, dvec3(0.0, 1.0, 0.2));
        }
        let mut bodies = vec![
            free(
                Shape::Box {
                    half: dvec3(0.01, 0.006, 0.02),
                },
                dvec3(0.03, 0.02, 0.004),
                dvec3(0.0, -1.0, 0.0),
                dvec3(3.0, -2.0, 5.0),
            ),
            free(
                Shape::Sphere { radius: 0.006 },
                dvec3(-0.035, 0.012, 0.0),
                dvec3(0.0, -2.0, 0.0),
                DVec3::ZERO,
            ),
        ];
        bodies.iter_mut().for_each(|b| b.friction = friction);
        let options = ContactOptions {
            gravity: DVec3::ZERO,
            rod_restitution: Some(1.0),
        };
        let mut contacts = Bodies::new(
            bodies,
            options,
            &bundle,
            &state,
            &Loads::default(),
            &Context::quiet(),
        )
        .unwrap();
        let about = dvec3(0.3, -0.2, 0.1);
        let momenta = |state: &State, contacts: &Bodies| {
            let (p, l) = contacts.momenta(about);
            (
                p + state.momentum(&bundle),
                l + state.angular_momentum(&bundle, about),
            )
        };
        let total = |state: &State, contacts: &Bodies| {
            energy::energies(&bundle, state).total()
                + contacts.energy()
                + contacts.ledger().dissipated
        };
        let before = (momenta(&state, &contacts), total(&state, &contacts));
        for _ in 0..60_000 {
            step(&bundle, &mut state, &mut contacts, 1e-6, DVec3::ZERO);
        }
        let after = (momenta(&state, &contacts), total(&state, &contacts));
        let ledger = contacts.ledger();
        println!("friction {friction}: {ledger:?}, {before:?} -> {after:?}");
        assert!(ledger.impulses > 6, "{ledger:?}");
        assert!(after.0.0.distance(before.0.0) < 1e-12 * before.0.0.length());
        assert!(after.0.1.distance(before.0.1) < 1e-10 * before.0.1.length());
        assert!((after.1 / before.1 - 1.0).abs() < 2e-3);
        if friction == 0.0 {
            // The only loss is what recovery from overlaps gave.
            assert!(ledger.dissipated.abs() < 1e-3 * before.1, "{ledger:?}");
        } else {
            assert!(ledger.dissipated > 1e-3 * before.1, "{ledger:?}");
        }
    }
}

#[test]
fn a_ball_bounces_and_spins_as_in_the_textbook() {
    // Restitution against a fixed half-space, and sliding friction: v_x falls by μ(1 + e)v_n.
    let bundle =
        RodBundle::new(&[rod(dvec3(5.0, 5.0, 5.0), dvec3(5.1, 5.0, 5.0), 2)], false).unwrap();
    let mut state = State::at_rest(&bundle);
    let (restitution, friction) = (0.6, 0.1);
    let mut floor = Body::fixed(Shape::HalfSpace { normal: DVec3::Y }, DVec3::ZERO);
    let position = dvec3(0.0, 0.03, 0.0);
    let mut ball = free(
        Shape::Sphere { radius: 0.02 },
        position,
        dvec3(3.0, -1.0, 0.0),
        DVec3::ZERO,
    );
    for body in [&mut floor, &mut ball] {
        (body.restitution, body.friction) = (restitution, friction);
    }
    let options = ContactOptions {
        gravity: DVec3::ZERO,
        rod_restitution: None,
    };
    let mut contacts = Bodies::new(
        vec![floor, ball],
        options,
        &bundle,
        &state,
        &Loads::default(),
        &Context::quiet(),
    )
    .unwrap();
    for _ in 0..2000 {
        step(&bundle, &mut state, &mut contacts, 1e-5, DVec3::ZERO);
    }
    let ball = contacts.iter().nth(1).unwrap().1;
    let kick = friction * (1.0 + restitution);
    assert!(
        (ball.velocity - dvec3(3.0 - kick, restitution, 0.0)).length() < 1e-9,
        "{ball:?}"
    );
    // Spin: I ω = r × J with I = 2/5 m r²; the arm is shorter by the overlap of a step.
    let spin = -kick / (0.4 * 0.02);
    assert!(
        (ball.angular_velocity - dvec3(0.0, 0.0, spin)).length() < 1e-3 * spin.abs(),
        "{ball:?}"
    );
}

/// Shapes whose top is a plane or a line at the height `half`, with their orientations.
fn flat_shapes(half: f64) -> [(Shape, DQuat); 5] {
    let corners: Vec<DVec3> = (0..8)
        .map(|i| {
            let sign = |bit: i32| f64::from(i >> bit & 1) * 2.0 - 1.0;
            dvec3(sign(0) * 0.1, sign(1) * half, sign(2) * 0.1)
        })
        .collect();
    let face = |a: u32, b: u32, c: u32, d: u32| [[a, b, c], [a, c, d]];
    let triangles: Vec<[u32; 3]> = [
        face(0, 1, 5, 4),
        face(2, 6, 7, 3),
        face(0, 2, 3, 1),
        face(4, 5, 7, 6),
        face(0, 4, 6, 2),
        face(1, 3, 7, 5),
    ]
    .concat();
    let lying = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    [
        (
            Shape::Box {
                half: dvec3(0.1, half, 0.1),
            },
            DQuat::IDENTITY,
        ),
        (
            Shape::Hull {
                points: corners.clone(),
            },
            DQuat::IDENTITY,
        ),
        (
            Shape::Mesh {
                points: corners,
                triangles,
            },
            DQuat::IDENTITY,
        ),
        (
            Shape::Cylinder {
                half_length: 0.1,
                radius: half,
            },
            lying,
        ),
        (
            Shape::Capsule {
                half_length: 0.1,
                radius: half,
            },
            lying,
        ),
    ]
}

#[test]
fn a_rod_comes_to_rest_on_every_shape_and_on_a_slope_by_friction() {
    let half = 0.02;
    let material = RodMaterial::solid(4e-6, 2e6, 1e6, 600.0);
    let lie = half + 0.5 * material.diameter;
    for (shape, turn) in flat_shapes(half) {
        let name = shape.name();
        let points = (0..5).map(|i| dvec3(0.01 * f64::from(i) - 0.02, lie + 2e-4, 0.0));
        let bundle = RodBundle::new(&[Rod::new(points.collect(), material)], false).unwrap();
        let mut state = State::at_rest(&bundle);
        let body = Body {
            rotation: turn,
            friction: 0.5,
            ..Body::fixed(shape, DVec3::ZERO)
        };
        let options = ContactOptions::default();
        let mut contacts = Bodies::new(
            vec![body],
            options,
            &bundle,
            &state,
            &Loads::default(),
            &Context::quiet(),
        )
        .unwrap();
        // Gravity is tilted by 20°; a friction of 0.5 holds up to 26.6°.
        let (sin, cos) = 20f64.to_radians().sin_cos();
        for _ in 0..20_000 {
            step(
                &bundle,
                &mut state,
                &mut contacts,
                1e-5,
                9.81 * dvec3(sin, -cos, 0.0),
            );
        }
        for i in 0..5 {
            let (p, v) = (state.position.get(i), state.velocity.get(i));
            assert!((p.y - lie).abs() < 0.05 * material.diameter, "{name}: {p}");
            assert!(v.length() < 2e-3, "{name}: {v}");
        }
    }
}

#[test]
fn two_rods_that_cross_exchange_their_momentum() {
    let rods = [
        rod(dvec3(-0.03, 0.0, 0.0), dvec3(0.03, 0.0, 0.0), 1),
        rod(dvec3(0.0, 0.01, -0.03), dvec3(0.0, 0.01, 0.03), 1),
    ];
    let bundle = RodBundle::new(&rods, false).unwrap();
    let run = |rod_restitution: Option<f64>| {
        let mut state = State::at_rest(&bundle);
        for i in 0..2 {
            state.velocity.set(i, DVec3::Y);
        }
        let options = ContactOptions {
            gravity: DVec3::ZERO,
            rod_restitution,
        };
        let mut contacts = Bodies::new(
            Vec::new(),
            options,
            &bundle,
            &state,
            &Loads::default(),
            &Context::quiet(),
        )
        .unwrap();
        for _ in 0..2000 {
            step(&bundle, &mut state, &mut contacts, 1e-5, DVec3::ZERO);
        }
        [0, 1, 2, 3].map(|i| state.velocity.get(i).y)
    };
    for (got, expected) in [
        (run(Some(1.0)), [0.0, 0.0, 1.0, 1.0]),
        (run(Some(0.0)), [0.5; 4]),
        (run(None), [1.0, 1.0, 0.0, 0.0]),
    ] {
        for i in 0..4 {
            assert!((got[i] - expected[i]).abs() < 1e-3, "{got:?} {expected:?}");
        }
    }
}

#[test]
fn bodies_that_overlap_or_have_no_size_are_refused_by_name() {
    let bundle = two_rods();
    let state = State::at_rest(&bundle);
    let assemble = |bodies: Vec<Body>| {
        Bodies::new(
            bodies,
            ContactOptions::default(),
            &bundle,
            &state,
            &Loads::default(),
            &Context::quiet(),
        )
    };
    let message_of = |bodies: Vec<Body>| {
        assemble(bodies)
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    let ball = |x: f64| {
        free(
            Shape::Sphere { radius: 0.01 },
            dvec3(x, 0.1, 0.0),
            DVec3::ZERO,
            DVec3::ZERO,
        )
    };
    let message = message_of(vec![ball(0.0), ball(0.015)]);
    assert!(
        message.contains("bodies 0 and 1 overlap by 0.005"),
        "{message}"
    );
    assert_eq!(message_of(vec![ball(0.0), ball(0.021)]), "");
    let mut block = Body::fixed(
        Shape::Box {
            half: DVec3::splat(0.01),
        },
        DVec3::ZERO,
    );
    block.name = "block".into();
    let refused = |block: &Body, words: &str| {
        let message = message_of(vec![block.clone()]);
        assert!(message.contains(words), "{message}");
    };
    refused(&block, "deep in body \"block\"");
    block.shape = Shape::Box {
        half: dvec3(0.01, -1.0, 0.01),
    };
    refused(
        &block,
        "half side (m) of body 0 is -1, but it must be above 0",
    );
    block.shape = Shape::Hull {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::Y, dvec3(1.0, 1.0, 0.0)],
    };
    refused(&block, "plane");
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    block.shape = Shape::Mesh {
        points,
        triangles: vec![[0, 1, 2]],
    };
    refused(&block, "must be closed");
    block.shape = Shape::HalfSpace { normal: DVec3::Z };
    block.motion = BodyMotion::Free {
        density: 1.0,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    };
    refused(&block, "cannot move freely");
    block.motion = BodyMotion::Prescribed(Motion::Fixed);
    block.restitution = 1.5;
    refused(&block, "restitution of body 0 is 1.5");
}

#[test]
fn a_checkpoint_of_other_bodies_is_refused() {
    let bundle = two_rods();
    let (state, loads) = (State::at_rest(&bundle), Loads::default());
    let assemble = |bodies: Vec<Body>| {
        let options = ContactOptions::default();
        Bodies::new(bodies, options, &bundle, &state, &loads, &Context::quiet()).unwrap()
    };
    let ball = Body::fixed(Shape::Sphere { radius: 0.01 }, dvec3(0.0, 0.1, 0.0));
    let other = assemble(vec![ball]).checkpoint();
    let refused = assemble(Vec::new()).resume(&other, &bundle, &loads);
    let expected = BodyError::Count {
        found: 1,
        expected: 0,
    };
    assert_eq!(refused, Err(expected));
}

#[test]
fn the_energy_balance_closes_while_a_body_presses_on_a_bundle() {
    // A ball bends four bonded rods, clamped at one end, by a seventh of their length: its work is the only energy input.
    let solvers: [(Box<dyn Solver>, f64); 4] = [
        (Box::new(Explicit::new(None)), 0.5),
        (Box::new(Implicit::new(Some(5e-3))), 0.0),
        (Box::new(Interactive::new(Some(5e-3))), 0.0),
        (Box::new(QuasiStatic::new(Some(5e-3))), 0.0),
    ];
    let mut works = Vec::new();
    for (mut solver, lag) in solvers {
        let mut world = World::new(four_rods(false));
        let low = (0..world.bundle.vertices()).filter(|&v| world.bundle.rest.z[v] < 0.011);
        let low = low.map(|v| v as u32).collect();
        world.loads.clamps = vec![Clamp::new(&world.bundle, low, Motion::Fixed)];
        world.loads.damping = 20.0;
        let radius = 0.5 * world.bundle.diameter[0];
        let push = Motion::Steady {
            velocity: DVec3::X * 0.02,
            angular_velocity: DVec3::ZERO,
        };
        let ball = Body {
            motion: BodyMotion::Prescribed(push),
            friction: 0.3,
            ..Body::fixed(
                Shape::Sphere { radius: 0.02 },
                dvec3(-radius - 0.0201, 2.5e-3, 0.05),
            )
        };
        let options = ContactOptions {
            gravity: DVec3::ZERO,
            rod_restitution: None,
        };
        let (bundle, state) = (&world.bundle, &world.state);
        let mut bodies = Bodies::new(
            vec![ball],
            options,
            bundle,
            state,
            &world.loads,
            &Context::quiet(),
        )
        .unwrap();
        let step = solver.step(&world, &Context::quiet()).unwrap();
        if lag > 0.0 {
            stagger_velocities(&mut world, lag * step);
        }
        let mut ledger = EnergyLedger::default();
        let mut worst: f64 = 0.0;
        let mut row = EnergyRow::measure(&world, &bodies, &ledger, lag * step);
        for _ in 0..40 {
            let report = solver
                .advance(&mut world, &mut bodies, 0.01, &Context::quiet())
                .unwrap();
            ledger.add(&report);
            row = EnergyRow::measure(&world, &bodies, &ledger, lag * report.step);
            worst = worst.max(row.balance().abs());
        }
        println!(
            "{}: work {:.4e} J, stored {:.4e} J in rods and {:.1e} J in contacts, {:.1e} J friction, {:.1e} J damped, \
             {:.1e} J dissipated; off by {:.4} % of the work",
            solver.name(),
            row.contact_work,
            row.rods.potential(),
            row.contact,
            row.contact_loss,
            ledger.damped,
            ledger.dissipated,
            100.0 * worst / row.contact_work
        );
        assert!(row.contact_work > 0.0 && worst < 0.01 * row.contact_work);
        // The method dissipates no more than that either.
        assert!(ledger.dissipated.abs() < 0.01 * row.contact_work);
        works.push(row.contact_work);
    }
    for work in &works {
        assert!((work / works[3] - 1.0).abs() < 0.05, "{works:?}");
    }
}
