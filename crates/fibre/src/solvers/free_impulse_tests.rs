//! What flies and vibrates keeps its momentum, and its energy is booked.

use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
use crate::solvers::{Interactive, Solver};
use crate::vectors::Vectors;
use crate::{NoContacts, World};
use glam::DVec3;
use greenstick_geometry::Context;

#[test]
fn what_flies_keeps_its_momentum_however_roughly_forces_are_balanced() {
    let material = RodMaterial::solid(1e-5, 1e10, 1e9, 600.0);
    let vertices = (0..12).map(|i| DVec3::new(0.0, 0.0, 5e-3 * f64::from(i)));
    let bundle = RodBundle::new(&[Rod::new(vertices.collect(), material)], false).unwrap();
    let mut world = World::new(bundle);
    for v in 0..12 {
        let arm = world.state.position.get(v) - DVec3::new(0.0, 0.0, 0.0275);
        let turn = DVec3::new(30.0, 40.0, 0.0).cross(arm);
        let vibration = DVec3::X * (3.0 * (0.9 * v as f64).sin());
        let velocity = DVec3::new(20.0, 0.0, -3.0) + turn + vibration;
        world.state.velocity.set(v, velocity);
    }
    let momentum = |world: &World| -> DVec3 {
        let velocity: &Vectors = &world.state.velocity;
        (0..12)
            .map(|v| velocity.get(v) * world.bundle.mass[v])
            .sum()
    };
    let start = momentum(&world);
    let energy = |world: &World| crate::energy::energies(&world.bundle, &world.state).total();
    let (had, mut taken) = (energy(&world), 0.0);
    let mut solver = Interactive::new(None);
    for _ in 0..3 {
        let done = solver
            .advance(&mut world, &mut NoContacts, 1.0 / 30.0, &Context::quiet())
            .unwrap();
        taken += done.dissipated;
        let off = (momentum(&world) - start).length() / start.length();
        assert!(off < 1e-9, "{off}");
        let off = ((energy(&world) + taken) / had - 1.0).abs();
        assert!(off < 5e-4, "{off}");
    }
}
