//! The largest stable step of explicit time steps, 2/ω_max. ω_max comes from power iteration on M⁻¹K, with K v from finite
//! differences of forces.

use crate::evaluator::ForceEvaluator;
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::noise::unit;

/// Power iterations. The spectrum of a bundle is dense near its end, so that the estimate approaches ω_max from below
/// without finding the mode itself.
const ITERATIONS: usize = 40;
/// Factor on the estimate, which lies below ω_max after these iterations.
const UNDERESTIMATE_FACTOR: f64 = 1.03;
/// Displacement of the finite differences, over the shortest edge.
const DIFFERENCE_STEP: f64 = 1e-6;
/// Seed of the first vector.
const SEED: u64 = 0x57ab_1e57_ab1e;

/// Returns the largest stable step about a state, s; infinite where nothing has stiffness.
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(super) fn largest_step(
    bundle: &RodBundle,
    state: &State,
    evaluator: &mut ForceEvaluator,
    context: &Context,
) -> Result<f64, Cancelled> {
    let mut iteration = PowerIteration::new(bundle, state);
    let mut squared_frequency = 0.0f64;
    for _ in 0..ITERATIONS {
        context.check()?;
        if !iteration.normalise() {
            return Ok(f64::INFINITY);
        }
        iteration.displace(bundle, state);
        evaluator.forces(bundle, &iteration.plus, &mut iteration.ahead);
        evaluator.forces(bundle, &iteration.minus, &mut iteration.behind);
        squared_frequency = squared_frequency.max(iteration.next(bundle));
    }
    Ok(if squared_frequency > 0.0 {
        2.0 / (squared_frequency.sqrt() * UNDERESTIMATE_FACTOR)
    } else {
        f64::INFINITY
    })
}

struct PowerIteration {
    /// The vector: displacements of vertices and turns of edges.
    direction: Vec<DVec3>,
    turn: Vec<f64>,
    /// Length of the shortest edge, m.
    shortest: f64,
    /// The states on both sides of the original one, and their forces.
    plus: State,
    minus: State,
    ahead: Forces,
    behind: Forces,
}

impl PowerIteration {
    fn new(bundle: &RodBundle, state: &State) -> Self {
        let n = bundle.vertices();
        let edges = (0..n).filter(|&j| bundle.is_edge(j));
        let random = |i: usize, k: i64| unit(SEED, i as i64, k, 0) - 0.5;
        let turn = |j: usize| if bundle.twisting { random(j, 3) } else { 0.0 };
        PowerIteration {
            direction: (0..n)
                .map(|i| DVec3::from_array([0, 1, 2].map(|a| random(i, a))))
                .collect(),
            turn: (0..n).map(turn).collect(),
            shortest: edges.fold(f64::INFINITY, |l, j| l.min(bundle.rest_length[j])),
            plus: state.clone(),
            minus: state.clone(),
            ahead: Forces::zeros(n),
            behind: Forces::zeros(n),
        }
    }

    /// Scales the vector to a largest component of 1. Returns whether it is finite and not zero.
    fn normalise(&mut self) -> bool {
        let largest = self
            .direction
            .iter()
            .fold(0.0f64, |a, v| a.max(v.abs().max_element()));
        let shortest = self.shortest;
        let largest = (self.turn.iter()).fold(largest, |a, v| a.max(v.abs() * shortest));
        if !(largest > 0.0 && largest.is_finite()) {
            return false;
        }
        self.direction.iter_mut().for_each(|v| *v /= largest);
        self.turn.iter_mut().for_each(|v| *v /= largest);
        true
    }

    /// Displaces both states along the vector.
    fn displace(&mut self, bundle: &RodBundle, state: &State) {
        let h = DIFFERENCE_STEP * self.shortest;
        for i in 0..bundle.vertices() {
            let (p, displacement) = (state.position.get(i), self.direction[i] * h);
            self.plus.position.set(i, p + displacement);
            self.minus.position.set(i, p - displacement);
            self.plus.angle[i] = state.angle[i] + self.turn[i] * h;
            self.minus.angle[i] = state.angle[i] - self.turn[i] * h;
        }
        for side in [&mut self.plus, &mut self.minus] {
            side.tangent.clone_from(&state.tangent);
            side.director.clone_from(&state.director);
            side.reference_twist.clone_from(&state.reference_twist);
            side.transport_frames(bundle);
        }
    }

    /// Replaces the vector v by M⁻¹K v from the forces on both sides. Returns the ratio of their norms, with masses and
    /// moments of inertia as weights, in which M⁻¹K is symmetric.
    fn next(&mut self, bundle: &RodBundle) -> f64 {
        let h = DIFFERENCE_STEP * self.shortest;
        let inverse_inertia = |j: usize| {
            if bundle.is_edge(j) {
                1.0 / bundle.inertia[j]
            } else {
                0.0
            }
        };
        let (ahead, behind) = (&self.ahead, &self.behind);
        let (mut before, mut after) = (0.0, 0.0);
        for i in 0..bundle.vertices() {
            let a = (behind.linear.get(i) - ahead.linear.get(i)) / (2.0 * h * bundle.mass[i]);
            before += bundle.mass[i] * self.direction[i].length_squared();
            after += bundle.mass[i] * a.length_squared();
            self.direction[i] = a;
            if bundle.twisting {
                let b = (behind.moment[i] - ahead.moment[i]) / (2.0 * h) * inverse_inertia(i);
                before += bundle.inertia[i] * self.turn[i] * self.turn[i];
                after += bundle.inertia[i] * b * b;
                self.turn[i] = b;
            }
        }
        (after / before).sqrt()
    }
}
