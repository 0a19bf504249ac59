//! A step of the explicit solver allocates nothing, as counted by an allocator of this test.
#![allow(unsafe_code)]

mod support;

use glam::DVec3;
use greenstick_fibre::{
    BondCriterion, Explicit, FailureCriteria, NoContacts, RodBundle, Solver, World,
};
use greenstick_geometry::Context;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use support::{bond_all, soft, straight};

struct Counting;

static COUNT: AtomicU64 = AtomicU64::new(0);

// Safety: all calls are forwarded to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Returns the number of allocations in some steps.
fn allocations(world: &mut World, solver: &mut Explicit, steps: u32) -> u64 {
    let step = solver.step(world, &Context::quiet()).unwrap();
    let before = COUNT.load(Ordering::Relaxed);
    solver
        .advance(
            world,
            &mut NoContacts,
            f64::from(steps) * step,
            &Context::quiet(),
        )
        .unwrap();
    COUNT.load(Ordering::Relaxed) - before
}

#[test]
fn a_step_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(|| {
        let rods: Vec<_> = (0..36)
            .map(|r| {
                let corner = DVec3::new(f64::from(r % 6), f64::from(r / 6), 0.0) * 5e-3;
                straight(corner, 0.06, 11, soft())
            })
            .collect();
        let mut bundle = RodBundle::new(&rods, false).unwrap();
        bond_all(&mut bundle, 6e-3, 40.0, 2e-3);
        assert!(bundle.bonds.len() > 1000);
        let mut world = World::new(bundle);
        world.loads.gravity = DVec3::X * -9.81;
        world.loads.damping = 1.0;
        // Nothing breaks, but everything is checked in every step.
        world.failure = FailureCriteria {
            rods_break: true,
            rods_yield: true,
            bonds: BondCriterion::Stress,
            ..FailureCriteria::default()
        };
        world.bundle.bonds.tension_strength.fill(1e9);
        world.bundle.bonds.shear_strength.fill(1e9);
        let mut solver = Explicit::new(None);
        // The buffers that the first call allocates are reused.
        allocations(&mut world, &mut solver, 10);
        let (few, many) = (
            allocations(&mut world, &mut solver, 20),
            allocations(&mut world, &mut solver, 220),
        );
        assert!(world.events.is_empty());
        assert_eq!(few, many, "200 more steps");
    });
}
