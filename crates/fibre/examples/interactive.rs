//! The thesis's stick (15 cm, 100 rods of 30 edges) of white ash at real stiffness, both ends turned for a second, with
//! the interactive solver: computing time against the time shown. `RAYON_NUM_THREADS` sets the number of threads.
//!
//! `cargo run --release -p greenstick-fibre --example interactive [-- DEGREES [STEP]]`: by 2.5° at each end nothing breaks, by
//! 40° it is broken.

use glam::DQuat;
use greenstick_fibre::placement::fill_stem;
use greenstick_fibre::{
    BondCriterion, Clamp, EventKind, FailureCriteria, Interactive, Keyframe, Motion, NoContacts,
    PlacementOptions, Pose, RodCount, Solver, WoodMaterial, World,
};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::cylinder;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{StemLocation, StemOptions, find_stem};
use std::time::Instant;

/// Returns the stick, whose ends turn by `turned` radians in a second.
fn stick(turned: f64) -> Option<World> {
    let ash = Species::find("white ash").ok()?;
    let wood = WoodMaterial::from_species(ash, 12.0, Fallback::Refuse).ok()?;
    let mesh = cylinder(5e-3, 0.15, 48);
    let options = StemOptions::default();
    let found = find_stem(
        &[mesh],
        &StemLocation::Fraction(0.5),
        &options,
        &Context::quiet(),
    )
    .ok()?;
    let placement = PlacementOptions {
        rods: RodCount::Number(100),
        weibull: 12.0,
        ..PlacementOptions::default()
    };
    let placed = fill_stem(&found.stem, &wood, &placement, &Context::quiet()).ok()?;
    let mut world = World::new(placed.bundle);
    let (low, high) =
        (placed.along.iter()).fold((f64::MAX, f64::MIN), |(l, h), s| (l.min(*s), h.max(*s)));
    let bundle = &world.bundle;
    let end = |from: f64, to: f64| -> Vec<u32> {
        let inside = |v: &usize| {
            let f = (placed.along[*v] - low) / (high - low);
            (from..=to).contains(&f)
        };
        (0..bundle.vertices())
            .filter(inside)
            .map(|v| v as u32)
            .collect()
    };
    let along = {
        let rod = bundle.rod(0);
        (bundle.rest.get(rod.end - 1) - bundle.rest.get(rod.start)).normalize()
    };
    let across = along.any_orthonormal_vector();
    let keys = |turn: f64| {
        let frames = (0..=20).map(|k| {
            let angle = turned * f64::from(k) / 20.0;
            let arc = (high - low) * 0.94;
            // The chord of the arc is shorter than the stem.
            let nearer = if angle > 0.0 {
                0.5 * arc * (1.0 - angle.sin() / angle)
            } else {
                0.0
            };
            let pose = Pose {
                translation: along * (nearer * turn.signum()),
                rotation: DQuat::from_axis_angle(across, angle * turn),
            };
            Keyframe {
                time: f64::from(k) / 20.0,
                pose,
            }
        });
        Motion::Keyframes(frames.collect())
    };
    world.loads.clamps = vec![
        Clamp::new(bundle, end(0.0, 0.06), keys(1.0)),
        Clamp::new(bundle, end(0.94, 1.0), keys(-1.0)),
    ];
    world.loads.damping = 5.0;
    world.failure = FailureCriteria {
        rods_break: true,
        rods_yield: true,
        bonds: BondCriterion::Cohesive,
        ..FailureCriteria::default()
    };
    Some(world)
}

fn main() {
    let number = |k: usize| std::env::args().nth(k).and_then(|s| s.parse::<f64>().ok());
    let (degrees, step) = (number(1).unwrap_or(2.5), number(2));
    let Some(mut world) = stick(degrees.to_radians()) else {
        eprintln!("the stick cannot be built");
        return;
    };
    let mut solver = Interactive::new(step);
    let dt = solver.step(&world, &Context::quiet()).unwrap_or(1.0 / 60.0);
    println!(
        "{} rods, {} vertices, {} bonds, step {dt:.4} s",
        world.bundle.rods(),
        world.bundle.vertices(),
        world.bundle.bonds.len()
    );
    let (mut all, mut worst) = (0.0, 0.0f64);
    while world.state.time < 1.0 {
        let start = Instant::now();
        let report = match solver.advance(&mut world, &mut NoContacts, dt, &Context::quiet()) {
            Ok(report) => report,
            Err(error) => {
                eprintln!("{error}");
                return;
            }
        };
        let took = start.elapsed().as_secs_f64();
        all += took;
        worst = worst.max(took);
        let count = |kind| world.events.iter().filter(|e| e.kind == kind).count();
        println!(
            "{:.3} s: {:5.1} ms, {:?}, {} rods and {} bonds broke, {} yielded, work {:.4} J",
            world.state.time,
            1e3 * took,
            solver.effort(),
            count(EventKind::RodBroke),
            count(EventKind::BondBroke),
            count(EventKind::RodYielded),
            report.work
        );
    }
    println!(
        "1 s of motion in {all:.2} s, at most {:.0} ms for {:.0} ms",
        1e3 * worst,
        1e3 * dt
    );
}
