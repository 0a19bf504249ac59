//! What unbalanced forces would do to parts that nothing holds or touches: an impulse on each as a whole.
//!
//! On the long way of what flies the smallest force does work, though all that it could do is to change the momentum of the
//! part. That is known without an iteration: forces within a part cancel, and what is left of the sum of the unbalanced forces, and
//! of their moment, over a step is the impulse that the step lacks. Given to the part's velocities, it makes its momentum that of the
//! loads on it, and takes the work of these forces out of the balance.

use super::balance::{Balance, EquilibriumProblem};
use super::rigid_parts::motion_of_parts;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// Accelerations, m/s², of the vertices of free parts as rigid bodies under the forces that are not balanced; zero of what is held or
/// touched.
pub(super) struct FreeAcceleration {
    acceleration: Vectors,
}

impl FreeAcceleration {
    /// Returns those of a trial state whose forces `balance` has.
    pub fn new(problem: &EquilibriumProblem, state: &State, balance: &Balance) -> Self {
        let (bundle, n) = (problem.bundle, problem.bundle.vertices());
        let part = &balance.parts;
        let mut bound = vec![false; n];
        for &vertex in problem.loads.clamps.iter().flat_map(|c| &c.vertices) {
            bound[part[vertex as usize]] = true;
        }
        for (vertex, _) in balance.springs.iter().flat_map(|s| s.shares()) {
            bound[part[vertex]] = true;
        }
        let mut acceleration = Vectors::zeros(n);
        if problem.inertia.is_none() || bundle.twisting || (0..n).all(|v| bound[part[v]]) {
            return FreeAcceleration { acceleration };
        }
        let unbalanced = |v: usize| {
            let at = balance.dof(v, 0);
            DVec3::from_slice(&balance.residual[at..at + 3]) / bundle.mass[v]
        };
        let unbalanced: Vectors = (0..n).map(unbalanced).collect();
        let motion = motion_of_parts(bundle, (&state.position, &unbalanced), part);
        for v in (0..n).filter(|&v| !bound[part[v]]) {
            let whole = motion[part[v]].velocity_at(state.position.get(v));
            if whole.is_finite() {
                acceleration.set(v, whole);
            }
        }
        FreeAcceleration { acceleration }
    }

    /// Returns the work of the forces that cause it on the way from one state to another, J.
    pub fn work(&self, bundle: &RodBundle, from: &State, to: &State) -> f64 {
        (0..bundle.vertices()).fold(0.0, |sum, v| {
            let way = to.position.get(v) - from.position.get(v);
            sum + bundle.mass[v] * self.acceleration.get(v).dot(way)
        })
    }

    /// Adds the impulse of a step of `dt` seconds to velocities. Returns its own energy, J: by so much less than ½ m |Δv|², with
    /// the change Δv of velocities without it, the method has taken from the motion.
    pub fn add_impulse(&self, bundle: &RodBundle, dt: f64, velocity: &mut Vectors) -> f64 {
        (0..bundle.vertices()).fold(0.0, |energy, v| {
            let change = self.acceleration.get(v) * dt;
            velocity.add(v, change);
            energy + 0.5 * bundle.mass[v] * change.length_squared()
        })
    }
}
