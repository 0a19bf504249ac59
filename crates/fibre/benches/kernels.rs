//! Speed of the explicit solver's kernels: vertex-steps and bond-steps per second, by instruction set and number of threads.
//!
//! `cargo bench -p greenstick-fibre [-- FILTER]` runs the lines that contain FILTER, such as `"bond-steps, Avx512"`.

use glam::DVec3;
use greenstick_fibre::{
    Bond, BondCriterion, Explicit, ForceEvaluator, Forces, NoContacts, Rod, RodBundle, RodMaterial,
    SimdLevel, Solver, State, World,
};
use greenstick_geometry::Context;

/// `side` × `side` rods of 30 vertices; where `bonded`, with bonds to the four neighbours and two diagonal ones.
fn bundle(side: usize, bonded: bool) -> RodBundle {
    let n = 30;
    let material = RodMaterial::solid(2.5e-5, 1e10, 1e9, 600.0);
    let rods: Vec<Rod> = (0..side * side)
        .map(|r| {
            let corner = DVec3::new((r % side) as f64, (r / side) as f64, 0.0) * 5e-3;
            Rod::new(
                (0..n)
                    .map(|i| corner + DVec3::Z * (5e-3 * i as f64))
                    .collect(),
                material,
            )
        })
        .collect();
    let mut made = RodBundle::new(&rods, false).unwrap();
    if bonded {
        let near = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)];
        let mut bonds = Vec::new();
        for r in 0..side * side {
            for (dx, dy) in near {
                let (x, y) = ((r % side) as i64 + dx, (r / side) as i64 + dy);
                if x < 0 || y < 0 || x >= side as i64 || y >= side as i64 {
                    continue;
                }
                let other = (y as usize * side + x as usize) * n;
                for i in 0..n {
                    let j = other + i.min(n - 2);
                    let t = if i == n - 1 { 1.0 } else { 0.0 };
                    bonds.push(Bond {
                        vertex: (r * n + i) as u32,
                        edge: j as u32,
                        t,
                        distance: 5e-3 * ((dx * dx + dy * dy) as f64).sqrt(),
                        rest_cosine: 0.0,
                        transverse: 1e4,
                        shear: 0.1,
                        area: 1e-5,
                        tension_strength: 1.0,
                        shear_strength: 1.0,
                        fracture_energy: 1.0,
                        shear_fracture_energy: 1.0,
                        damage: 0.0,
                    });
                }
            }
        }
        made.set_bonds(bonds).unwrap();
    }
    made
}

/// The clock of a measurement.
#[derive(Clone, Copy, PartialEq)]
enum Clock {
    /// That of this thread alone, which stops while other threads have its processor.
    Thread,
    Wall,
}

impl Clock {
    fn seconds(self) -> f64 {
        let id = match self {
            Clock::Thread => rustix::time::ClockId::ThreadCPUTime,
            Clock::Wall => rustix::time::ClockId::Monotonic,
        };
        let now = rustix::time::clock_gettime(id);
        now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
    }
}

/// Returns the seconds of one call: the least of many short repetitions, because other work on the machine only adds.
fn time(clock: Clock, mut work: impl FnMut()) -> f64 {
    let mut sample = |calls: usize| {
        let start = clock.seconds();
        (0..calls).for_each(|_| work());
        (clock.seconds() - start) / calls as f64
    };
    let once = sample(1).min(sample(1));
    let calls = (SAMPLE / once).clamp(1.0, 1e6) as usize;
    let samples = (TOTAL / (once * calls as f64)).clamp(5.0, 400.0) as usize;
    (0..samples)
        .map(|_| sample(calls))
        .fold(f64::INFINITY, f64::min)
}

/// Length of a repetition and of all of them, s.
const SAMPLE: f64 = 4e-4;
const TOTAL: f64 = 0.3;

fn in_threads(threads: usize, work: impl FnOnce() -> f64 + Send) -> f64 {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(work)
}

fn clock(threads: usize) -> Clock {
    if threads == 1 {
        Clock::Thread
    } else {
        Clock::Wall
    }
}

/// Returns the seconds of a force evaluation.
fn forces(made: &RodBundle, level: SimdLevel, threads: usize) -> f64 {
    let state = State::at_rest(made);
    in_threads(threads, || {
        let mut evaluator = ForceEvaluator::with_level(made, level);
        let mut out = Forces::zeros(made.vertices());
        time(clock(threads), || evaluator.forces(made, &state, &mut out))
    })
}

/// Returns the seconds of an explicit step, from runs of different lengths, which excludes what a run does once. Where `cohesive`,
/// bonds are checked for softening as often as in the scenes.
fn steps(made: &RodBundle, threads: usize, cohesive: bool) -> f64 {
    in_threads(threads, || {
        let mut world = World::new(made.clone());
        if cohesive {
            world.failure.bonds = BondCriterion::Cohesive;
            world.failure.check_interval = 8;
        }
        let mut solver = Explicit::new(None);
        let step = solver.step(&world, &Context::quiet()).unwrap();
        let size = made.vertices() + made.bonds.len();
        let count = (4e5 / size as f64).clamp(4.0, 100.0).ceil();
        // Whole numbers of checks.
        let count = 8.0 * (count / 8.0).ceil();
        let mut run = |count: f64| {
            time(clock(threads), || {
                solver
                    .advance(&mut world, &mut NoContacts, count * step, &Context::quiet())
                    .unwrap();
            })
        };
        let (short, long) = (run(1.0), run(1.0 + count));
        (long - short) / count
    })
}

/// Returns gigabytes per second of a = b + s c over arrays larger than the caches (three streams, and the reads that writes
/// cause).
fn stream(threads: usize) -> f64 {
    let n = 1 << 23;
    let (mut a, b, c) = (vec![0.0f64; n], vec![1.0f64; n], vec![2.0f64; n]);
    let seconds = in_threads(threads, || {
        time(clock(threads), || {
            let part = n / threads;
            rayon::scope(|scope| {
                let parts = a.chunks_mut(part).zip(b.chunks(part)).zip(c.chunks(part));
                for ((a, b), c) in parts {
                    let mut work = move || {
                        for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                            *a = b + 3.0 * c;
                        }
                    };
                    if threads == 1 {
                        work();
                    } else {
                        scope.spawn(move |_| work());
                    }
                }
            });
        })
    });
    32.0 * n as f64 / seconds * 1e-9
}

/// Returns the bytes that this process has in memory on Linux; 0 elsewhere.
fn resident_bytes() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split_whitespace().nth(1).and_then(|p| p.parse().ok());
    pages.unwrap_or(0.0) * 4096.0
}

/// Prints the time of a step and the memory of a world and its solver by the number of rods; both are proportional to it.
fn growth() {
    println!(
        "\n{:<34}{:>9}{:>12}{:>12}{:>12}",
        "all bonds, explicit steps", "rods", "ms per step", "us per rod", "kB per rod"
    );
    for side in [100, 173, 316] {
        let before = resident_bytes();
        let made = bundle(side, true);
        let rods = (side * side) as f64;
        let mut world = World::new(made);
        let mut solver = Explicit::new(None);
        let step = solver.step(&world, &Context::quiet()).unwrap();
        let mut run = |count: f64| {
            let clock = Clock::Thread;
            let start = clock.seconds();
            solver
                .advance(&mut world, &mut NoContacts, count * step, &Context::quiet())
                .unwrap();
            clock.seconds() - start
        };
        run(1.0);
        let memory = resident_bytes() - before;
        let least = (0..5).fold(f64::INFINITY, |least, _| least.min(run(9.0) - run(1.0)));
        let a_step = least / 8.0;
        println!(
            "{:<34}{:>9}{:>12.2}{:>12.3}{:>12.1}",
            "",
            side * side,
            1e3 * a_step,
            1e6 * a_step / rods,
            1e-3 * memory / rods
        );
    }
}

fn main() {
    let part = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    println!(
        "memory: {:.1} GB/s on 1 thread, {:.1} on 2",
        stream(1),
        stream(2)
    );
    println!(
        "{:<34}{:>9}{:>10}{:>10}  million per second",
        "", "rods", "1 thread", "2 threads"
    );
    for (bonded, what) in [(false, "vertex-steps"), (true, "bond-steps")] {
        for side in [5, 10, 32, 100] {
            let made = bundle(side, bonded);
            let units = if bonded {
                made.bonds.len()
            } else {
                made.vertices()
            } as f64
                * 1e-6;
            let print = |name: String, by: &dyn Fn(usize) -> f64| {
                if part.as_ref().is_some_and(|p| !name.contains(p.as_str())) {
                    return;
                }
                let [one, two] = [1, 2].map(|t| units / by(t));
                println!("{name:<34}{:>9}{one:>10.1}{two:>10.1}", side * side);
            };
            for level in [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::Avx512] {
                print(format!("forces, {what}, {level:?}"), &|t| {
                    forces(&made, level, t)
                });
            }
            print(format!("explicit steps, {what}"), &|t| {
                steps(&made, t, false)
            });
            if bonded {
                print(format!("cohesive steps, {what}"), &|t| {
                    steps(&made, t, true)
                });
            }
        }
    }
    if part.is_none_or(|p| "growth".contains(p.as_str())) {
        in_threads(1, || {
            growth();
            0.0
        });
    }
}
