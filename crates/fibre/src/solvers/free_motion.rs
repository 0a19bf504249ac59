//! The motion of parts that nothing holds, on which the friction inside wood does not act.

use super::limit_step::connected_parts;
use super::rigid_parts::motion_of_parts;
use crate::forces::Forces;
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;

/// The rigid motion of each connected part that no clamp holds. Damping with a factor acts on all velocities; forces of that factor
/// times mass times this motion take it back from what flies or falls, and leave it on vibrations.
#[derive(Debug, Clone)]
pub(super) struct FreeMotion {
    /// What is taken back of the damping, 1/s.
    rate: f64,
    /// Per vertex, m/s; zero of what is held.
    velocity: Vectors,
    /// Per edge: the rate of turn about it, rad/s.
    spin: Vec<f64>,
}

impl FreeMotion {
    /// Returns the motion of the parts of a bundle.
    pub fn new(bundle: &RodBundle, state: &State, loads: &Loads, rate: f64) -> Self {
        let part = connected_parts(bundle);
        let mut held = vec![false; bundle.vertices()];
        for &vertex in loads.clamps.iter().flat_map(|clamp| &clamp.vertices) {
            held[part[vertex as usize]] = true;
        }
        let motion = motion_of_parts(bundle, state, &part);
        let mut velocity = Vectors::zeros(bundle.vertices());
        let mut spin = vec![0.0; bundle.vertices()];
        for v in (0..bundle.vertices()).filter(|&v| !held[part[v]]) {
            let part = &motion[part[v]];
            velocity.set(v, part.velocity_at(state.position.get(v)));
            if bundle.twisting && bundle.is_edge(v) {
                spin[v] = part.angular_velocity.dot(state.tangent.get(v));
            }
        }
        FreeMotion {
            rate,
            velocity,
            spin,
        }
    }

    /// Whether it is that of a bundle with as many vertices: breaks of rods add some.
    pub fn fits(&self, bundle: &RodBundle) -> bool {
        self.spin.len() == bundle.vertices()
    }

    /// What is taken back of the damping, 1/s.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Adds the forces, N, and with twist the moments, N m.
    pub fn add_forces(&self, bundle: &RodBundle, forces: &mut Forces) {
        for v in 0..bundle.vertices() {
            let force = self.velocity.get(v) * (self.rate * bundle.mass[v]);
            forces.linear.set(v, forces.linear.get(v) + force);
            if bundle.twisting {
                forces.moment[v] += self.rate * bundle.inertia[v] * self.spin[v];
            }
        }
    }

    /// Returns the power of the forces at these velocities, W.
    pub fn power(&self, bundle: &RodBundle, velocity: &Vectors) -> f64 {
        (0..bundle.vertices()).fold(0.0, |sum, v| {
            let momentum = self.velocity.get(v) * bundle.mass[v];
            sum + self.rate * momentum.dot(velocity.get(v))
        })
    }

    /// Returns the power of the moments at these rates of turn, W.
    pub fn turning_power(&self, bundle: &RodBundle, spin: &[f64]) -> f64 {
        (0..bundle.vertices()).fold(0.0, |sum, v| {
            sum + self.rate * bundle.inertia[v] * self.spin[v] * spin[v]
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::NoContacts;
    use crate::loads::Loads;
    use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
    use crate::solvers::explicit::Explicit;
    use crate::solvers::solver::Solver;
    use crate::world::World;
    use glam::DVec3;
    use greenstick_geometry::Context;

    /// A rod that flies, turns and vibrates.
    fn world(damping: f64) -> World {
        let material = RodMaterial::solid(1e-5, 1e10, 1e9, 600.0);
        let vertices = (0..7).map(|i| DVec3::new(0.0, 0.0, 5e-3 * f64::from(i)));
        let bundle = RodBundle::new(&[Rod::new(vertices.collect(), material)], false).unwrap();
        let mut world = World::new(bundle);
        world.loads = Loads {
            damping,
            gravity: DVec3::new(0.0, 0.0, -10.0),
            ..Loads::default()
        };
        for v in 0..7 {
            let arm = world.state.position.get(v) - DVec3::new(0.0, 0.0, 0.015);
            let turn = DVec3::new(30.0, 40.0, 0.0).cross(arm);
            let vibration = DVec3::new(0.5 * f64::from((v as i32 % 2) * 2 - 1), 0.0, 0.0);
            world
                .state
                .velocity
                .set(v, DVec3::new(20.0, 0.0, -3.0) + turn + vibration);
        }
        world
    }

    fn momentum(world: &World) -> (DVec3, DVec3) {
        let (bundle, state) = (&world.bundle, &world.state);
        let sum = |of: &dyn Fn(usize) -> DVec3| {
            (0..bundle.vertices()).fold(DVec3::ZERO, |s, v| s + of(v) * bundle.mass[v])
        };
        let mass: f64 = bundle.mass.iter().sum();
        let centre = sum(&|v| state.position.get(v)) / mass;
        let velocity = sum(&|v| state.velocity.get(v)) / mass;
        let spin =
            sum(&|v| (state.position.get(v) - centre).cross(state.velocity.get(v) - velocity));
        (velocity * mass, spin)
    }

    #[test]
    fn what_flies_is_not_braked_and_what_vibrates_in_it_is() {
        let (mut world, context) = (world(1000.0), Context::quiet());
        let mut explicit = Explicit::new(None);
        let (linear, angular) = momentum(&world);
        let kinetic = |w: &World| crate::energy::energies(&w.bundle, &w.state).kinetic;
        let start = kinetic(&world);
        let (mut damped, mut work) = (0.0, 0.0);
        for _ in 0..100 {
            explicit.leave_undamped(&world, Some(1000.0));
            let done = explicit
                .advance(&mut world, &mut NoContacts, 5e-5, &context)
                .unwrap();
            (damped, work) = (damped + done.damped, work + done.work);
        }
        let mass: f64 = world.bundle.mass.iter().sum();
        let (after, turning) = momentum(&world);
        // Of what gravity adds within 50 µs, damping takes a twentieth half of that time.
        let fallen = DVec3::new(0.0, 0.0, -10.0 * 5e-3 * mass);
        assert!((after - linear - fallen).length() < 0.03 * fallen.length());
        assert!(
            (turning - angular).length() < 0.01 * angular.length(),
            "{angular} {turning}"
        );
        // Half of 7 · 0.25 kg m²/s² a kilogram of vertices, less what of it was rigid motion.
        let rigid = start - damped + work;
        assert!(
            (kinetic(&world) / rigid - 1.0).abs() < 1e-3,
            "{} {rigid}",
            kinetic(&world)
        );
        assert!(damped > 0.8 * 0.125 * mass, "{damped}");
    }
}
