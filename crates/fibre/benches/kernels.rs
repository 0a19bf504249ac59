//! Speed of the explicit solver's kernels: vertex-steps and bond-steps a second, by instructions and threads.
//!
//! `cargo bench -p greenstick-fibre`

use glam::DVec3;
use greenstick_fibre::energy::Forces;
use greenstick_fibre::{
    Bond, Bundle, Evaluator, Explicit, Level, NoContacts, Rod, RodMaterial, Solver, State, World,
};
use std::time::Instant;

/// `side` × `side` rods of 30 vertices; with bonds to the four neighbours and two diagonal ones where asked.
fn bundle(side: usize, bonded: bool) -> Bundle {
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
    let mut made = Bundle::new(&rods, false).unwrap();
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
                    });
                }
            }
        }
        made.set_bonds(bonds).unwrap();
    }
    made
}

/// Seconds for one call, the best of several rounds.
fn time(mut work: impl FnMut()) -> f64 {
    let start = Instant::now();
    work();
    let calls = (0.05 / start.elapsed().as_secs_f64()).clamp(1.0, 1e6) as usize;
    (0..7)
        .map(|_| {
            let start = Instant::now();
            (0..calls).for_each(|_| work());
            start.elapsed().as_secs_f64() / calls as f64
        })
        .fold(f64::INFINITY, f64::min)
}

fn in_threads(threads: usize, work: impl FnOnce() -> f64 + Send) -> f64 {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(work)
}

fn main() {
    println!(
        "{:<34}{:>9}{:>9}{:>9}  million a second",
        "", "rods", "1 thread", "2 threads"
    );
    for (bonded, what) in [(false, "vertex-steps"), (true, "bond-steps")] {
        for side in [10, 32, 100] {
            let made = bundle(side, bonded);
            let state = State::at_rest(&made);
            let units = if bonded {
                made.bonds.len()
            } else {
                made.vertices()
            } as f64;
            for level in [Level::Plain, Level::Avx2, Level::Avx512] {
                let forces = |threads| {
                    in_threads(threads, || {
                        let mut evaluator = Evaluator::with_level(&made, level);
                        let mut out = Forces::zeros(made.vertices());
                        time(|| evaluator.forces(&made, &state, &mut out))
                    })
                };
                let [one, two] = [1, 2].map(|t| units / forces(t) * 1e-6);
                println!(
                    "{:<34}{:>9}{one:>9.1}{two:>9.1}",
                    format!("forces, {what}, {level:?}"),
                    side * side
                );
            }
            let steps = |threads| {
                in_threads(threads, || {
                    let mut world = World::new(made.clone());
                    let mut solver = Explicit::new(None);
                    let step = solver.step(&world).unwrap();
                    solver.advance(&mut world, &mut NoContacts, step).unwrap();
                    let count = (3e7 / units).ceil();
                    // What an advance does once is small against its steps.
                    time(|| {
                        solver
                            .advance(&mut world, &mut NoContacts, count * step)
                            .unwrap();
                    }) / count
                })
            };
            let [one, two] = [1, 2].map(|t| units / steps(t) * 1e-6);
            println!(
                "{:<34}{:>9}{one:>9.1}{two:>9.1}",
                format!("explicit steps, {what}"),
                side * side
            );
        }
    }
}
