//! The fast forces are those of the energies, with the same bits on every processor and any number of threads.

mod support;

use glam::DVec3;
use greenstick_fibre::energy::{Forces, add_forces};
use greenstick_fibre::{Bundle, Evaluator, Explicit, Level, NoContacts, Rod, Solver, World};
use support::{bond_all, four_rods, shaken, soft, straight};

/// Many rods in a square grid, of different numbers of edges.
fn grid(side: usize, edges: usize) -> Bundle {
    let rods: Vec<Rod> = (0..side * side)
        .map(|r| {
            let corner = DVec3::new((r % side) as f64, (r / side) as f64, 0.0) * 5e-3;
            straight(corner, 0.06, edges + r % 5, soft())
        })
        .collect();
    let mut bundle = Bundle::new(&rods, false).unwrap();
    bond_all(&mut bundle, 6e-3, 40.0, 2e-3);
    bundle
}

#[test]
fn fast_forces_are_the_gradients_on_every_level() {
    for bundle in [four_rods(false), four_rods(true), grid(5, 11)] {
        let mut state = shaken(&bundle, 5, 0.3);
        state.plastic_strain[4] = -0.02;
        let mut exact = Forces::zeros(bundle.vertices());
        add_forces(&bundle, &state, &mut exact);
        let largest = exact.linear.iter().map(|f| f.length()).fold(0.0, f64::max);
        let mut first: Option<Forces> = None;
        for level in [Level::Plain, Level::Avx2, Level::Avx512] {
            let mut fast = Forces::zeros(bundle.vertices());
            Evaluator::with_level(&bundle, level).forces(&bundle, &state, &mut fast);
            for i in 0..bundle.vertices() {
                let miss = fast.linear.get(i).distance(exact.linear.get(i));
                assert!(miss < 1e-12 * largest, "{level:?}, vertex {i}: {miss}");
                assert!((fast.moment[i] - exact.moment[i]).abs() < 1e-12);
            }
            let same = first.get_or_insert_with(|| fast.clone());
            assert_eq!(*same, fast, "{level:?}");
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let bundle = grid(20, 12);
    assert!(bundle.vertices() > 4000 && bundle.bonds.len() > 8192);
    let run = |threads: usize| {
        let mut world = World::new(bundle.clone());
        world.state = shaken(&bundle, 3, 0.02);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| Explicit::new(None).advance(&mut world, &mut NoContacts, 2e-3))
            .unwrap();
        world
    };
    let (one, two) = (run(1), run(2));
    assert!(one.state.step > 10);
    assert_eq!(
        serde_json::to_string(&one).unwrap(),
        serde_json::to_string(&two).unwrap()
    );
}
