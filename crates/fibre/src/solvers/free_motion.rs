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
        let motion = motion_of_parts(bundle, (&state.position, &state.velocity), &part);
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
