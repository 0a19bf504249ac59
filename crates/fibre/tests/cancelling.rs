//! Every solver can be sent to another thread, and stops there soon after it is cancelled, with the world as after its last
//! complete step.

use glam::DVec3;
use greenstick_fibre::placement::fill_stem;
use greenstick_fibre::store::MemoryRun;
use greenstick_fibre::{
    Bodies, Clamp, EdgeLengths, Explicit, ForceEvaluator, Implicit, Interactive, Keyframe, Motion,
    NoContacts, PlacementOptions, Pose, QuasiStatic, RodCount, Solver, SolverError, WoodMaterial,
    World,
};
use greenstick_geometry::{CancelToken, Context};
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::board;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{StemKind, StemLocation, StemOptions, find_stem};
use std::sync::mpsc::channel;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The longest that a cancelled solver may go on.
const MAX_DELAY: Duration = Duration::from_millis(100);
/// A delay that another program on the machine may have caused is measured anew, this often in all.
const TRIALS: usize = 4;
/// Solvers are measured one at a time.
static MEASURING: Mutex<()> = Mutex::new(());

/// Returns the time that this process has spent on processors, which on a busy machine says more than a clock; `None` where
/// the system does not tell.
fn processor_time() -> Option<Duration> {
    let mut nanoseconds = 0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let Ok(text) = std::fs::read_to_string(task.ok()?.path().join("schedstat")) else {
            continue;
        };
        nanoseconds += text.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(nanoseconds))
}

#[test]
fn solvers_and_what_they_move_can_be_sent_to_other_threads() {
    fn is_send<T: Send>() {}
    is_send::<Explicit>();
    is_send::<Implicit>();
    is_send::<Interactive>();
    is_send::<QuasiStatic>();
    is_send::<Box<dyn Solver>>();
    is_send::<World>();
    is_send::<Bodies>();
    is_send::<ForceEvaluator>();
    is_send::<MemoryRun>();
}

/// Returns an oak column of many rods, whose upper clamp shortens it by a millimetre within a second: far beyond the load at
/// which it buckles.
fn buckling_column(rods: u32) -> World {
    column(rods, -1e-3)
}

/// Returns an oak column, whose upper clamp lengthens it by `by` (m) within a second.
fn column(rods: u32, by: f64) -> World {
    let oak = Species::find("white oak").unwrap();
    let wood = WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap();
    let options = StemOptions {
        kind: Some(StemKind::Board),
        ..StemOptions::default()
    };
    let (mesh, quiet) = (board(0.4, 0.01, 0.01), Context::quiet());
    let middle = StemLocation::Fraction(0.5);
    let stem = find_stem(&[mesh], &middle, &options, &quiet).unwrap().stem;
    let placement = PlacementOptions {
        rods: RodCount::Number(rods),
        edges: EdgeLengths::even(4e-3),
        range: Some((0.01, 0.39)),
        ..PlacementOptions::default()
    };
    let placed = fill_stem(&stem, &wood, &placement, &quiet).unwrap();
    let mut world = World::new(placed.bundle);
    let ends = |of: fn(std::ops::Range<usize>) -> [usize; 2]| -> Vec<u32> {
        let vertices = (0..world.bundle.rods()).flat_map(|rod| of(world.bundle.rod(rod)));
        vertices.map(|v| v as u32).collect()
    };
    let (lower, upper) = (
        ends(|rod| [rod.start, rod.start + 1]),
        ends(|rod| [rod.end - 2, rod.end - 1]),
    );
    let rod = world.bundle.rod(0);
    let along = world.bundle.rest.get(rod.end - 1) - world.bundle.rest.get(rod.start);
    let key = |time: f64, by: f64| Keyframe {
        time,
        pose: Pose {
            translation: along.normalize() * by,
            ..Pose::REST
        },
    };
    let lengthen = Motion::Keyframes(vec![key(0.0, 0.0), key(1.0, by)]);
    world.loads.gravity = DVec3::new(0.3, 0.2, 0.1);
    world.loads.clamps = vec![
        Clamp::new(&world.bundle, lower, Motion::Fixed),
        Clamp::new(&world.bundle, upper, lengthen),
    ];
    world
}

/// Runs a solver on a thread of its own and cancels it after `wait`. Returns what is left of the world, and how long the
/// solver went on; `None` for the time where it was done before.
fn cancel_after(
    mut solver: Box<dyn Solver>,
    mut world: World,
    wait: Duration,
) -> (World, Option<Duration>) {
    let token = CancelToken::default();
    let context = Context::silent(token.clone());
    let (sender, receiver) = channel();
    let worker = thread::spawn(move || {
        let result = solver.advance(&mut world, &mut NoContacts, 1.0, &context);
        sender
            .send((result, Instant::now(), processor_time()))
            .unwrap();
        world
    });
    thread::sleep(wait);
    let before = processor_time();
    let cancelled = Instant::now();
    token.cancel();
    let (result, stopped, after) = receiver.recv().unwrap();
    let delay = stopped.duration_since(cancelled);
    let busy = after.zip(before).map(|(a, b)| a.saturating_sub(b));
    let delay = busy.map_or(delay, |busy| busy.min(delay));
    let world = worker.join().unwrap();
    match result {
        Err(SolverError::Cancelled(_)) => (world, Some(delay)),
        other => {
            other.unwrap();
            (world, None)
        }
    }
}

/// Cancels solvers after several times, and checks that each stops soon. Returns the worlds that were left.
fn cancel_at_several_times(
    make: impl Fn() -> Box<dyn Solver>,
    start: &World,
    times: [u64; 4],
) -> Vec<World> {
    let _alone = MEASURING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut left = Vec::new();
    for milliseconds in times {
        let wait = Duration::from_millis(milliseconds);
        let mut shortest = Duration::MAX;
        for _ in 0..TRIALS {
            let (world, delay) = cancel_after(make(), start.clone(), wait);
            let delay = delay.unwrap_or_else(|| panic!("done within {wait:?}"));
            left.push(world);
            shortest = shortest.min(delay);
            if shortest <= MAX_DELAY {
                break;
            }
        }
        assert!(
            shortest <= MAX_DELAY,
            "{} went on for {shortest:?} when cancelled after {wait:?}",
            make().name()
        );
        println!("{} {wait:?}: {shortest:?}", make().name());
    }
    left
}

/// Returns the world when a solver has told that it is at `time` (s) of the second that it is to advance by.
fn stopped_at(mut solver: Box<dyn Solver>, mut world: World, time: f64) -> World {
    let token = CancelToken::default();
    let cancelled = token.clone();
    let context = Context::new(token, move |progress| {
        if progress.overall >= time {
            cancelled.cancel();
        }
    });
    let result = solver.advance(&mut world, &mut NoContacts, 1.0, &context);
    assert!(matches!(result, Err(SolverError::Cancelled(_))));
    world
}

#[test]
fn a_long_quasi_static_solve_stops_at_once_and_leaves_the_world_after_its_last_whole_step() {
    let start = buckling_column(250);
    for make in [
        || Box::new(QuasiStatic::new(Some(1.0))) as Box<dyn Solver>,
        || Box::new(QuasiStatic::stateless(Some(1.0))) as Box<dyn Solver>,
    ] {
        for world in cancel_at_several_times(make, &start, [5, 60, 400, 1500]) {
            let time = world.state.time;
            // Only a fast machine completes a step in the longest of these times.
            let whole = if time > 0.0 {
                stopped_at(make(), start.clone(), time)
            } else {
                start.clone()
            };
            assert!(world == whole, "step {}, {time} s", world.state.step);
        }
    }
}

#[test]
fn a_quasi_static_solve_that_is_stopped_between_steps_goes_on_as_if_it_had_not_been() {
    let start = column(6, 1e-4);
    let make = || Box::new(QuasiStatic::stateless(Some(0.2))) as Box<dyn Solver>;
    let mut whole = start.clone();
    let context = Context::quiet();
    make()
        .advance(&mut whole, &mut NoContacts, 1.0, &context)
        .unwrap();
    let mut world = stopped_at(make(), start.clone(), 0.5);
    assert!(world.state.step > 0 && world.state.time < 1.0);
    let left = 1.0 - world.state.time;
    make()
        .advance(&mut world, &mut NoContacts, left, &context)
        .unwrap();
    for v in 0..whole.bundle.vertices() {
        let off = world.state.position.get(v) - whole.state.position.get(v);
        assert!(off.length() < 1e-9, "{off} at vertex {v}");
    }
}

#[test]
fn implicit_solvers_stop_at_once() {
    let start = buckling_column(400);
    cancel_at_several_times(
        || Box::new(Implicit::new(Some(0.05))),
        &start,
        [5, 60, 400, 900],
    );
    let start = buckling_column(400);
    let make = || Box::new(Interactive::new(Some(0.02))) as Box<dyn Solver>;
    cancel_at_several_times(make, &start, [1, 5, 20, 60]);
}

#[test]
fn the_explicit_solver_stops_after_a_whole_step() {
    let start = buckling_column(60);
    for world in
        cancel_at_several_times(|| Box::new(Explicit::new(None)), &start, [5, 60, 200, 500])
    {
        let (steps, time) = (world.state.step, world.state.time);
        if steps == 0 {
            assert!(world.state == start.state);
            continue;
        }
        let mut reference = start.clone();
        Explicit::new(Some(time / steps as f64))
            .advance(&mut reference, &mut NoContacts, time, &Context::quiet())
            .unwrap();
        assert_eq!(reference.state.step, steps);
        for v in 0..world.bundle.vertices() {
            let off = world.state.position.get(v) - reference.state.position.get(v);
            assert!(off.length() < 1e-10, "{off} after {steps} steps");
        }
    }
}
