//! The largest stable step of explicit time steps: 2/ω_max, ω_max found by power iteration on M⁻¹K, with K v from
//! differences of forces.

use crate::bundle::Bundle;
use crate::energy::Forces;
use crate::kernel::Evaluator;
use crate::state::State;
use glam::DVec3;
use greenstick_wood::noise::unit;

/// Iterations. The spectrum of a bundle is dense near its end, so the estimate nears ω_max from below without needing
/// the very mode.
const ITERATIONS: usize = 40;
/// The estimate is raised by this, for what it lies below ω_max after these iterations.
const MARGIN: f64 = 1.03;
/// Displacements for differences of forces, relative to the shortest edge.
const NUDGE: f64 = 1e-6;
/// Place in the hash for the first vector.
const PURPOSE: u64 = 0x57ab_1e57_ab1e;

/// The largest stable step about a state, s; infinite where nothing has stiffness.
pub fn limit(bundle: &Bundle, state: &State, evaluator: &mut Evaluator) -> f64 {
    let n = bundle.vertices();
    let shortest = (0..n)
        .filter(|&j| bundle.is_edge(j))
        .map(|j| bundle.rest_length[j])
        .fold(f64::INFINITY, f64::min);
    let mut direction: Vec<DVec3> = (0..n)
        .map(|i| DVec3::from_array([0, 1, 2].map(|a| unit(PURPOSE, i as i64, a, 0) - 0.5)))
        .collect();
    let mut turn: Vec<f64> = (0..n)
        .map(|j| {
            if bundle.twisting {
                unit(PURPOSE, j as i64, 3, 0) - 0.5
            } else {
                0.0
            }
        })
        .collect();
    // A turn of an edge counts as what it moves the rod's surface by.
    let inverse_inertia = |j: usize| {
        if bundle.is_edge(j) {
            1.0 / bundle.inertia[j]
        } else {
            0.0
        }
    };
    let (mut ahead, mut behind) = (Forces::zeros(n), Forces::zeros(n));
    let (mut plus, mut minus) = (state.clone(), state.clone());
    let mut square = 0.0f64;
    for _ in 0..ITERATIONS {
        let largest = direction
            .iter()
            .fold(0.0f64, |a, v| a.max(v.abs().max_element()));
        let largest = turn.iter().fold(largest, |a, v| a.max(v.abs() * shortest));
        if !(largest > 0.0 && largest.is_finite()) {
            return f64::INFINITY;
        }
        let h = NUDGE * shortest;
        for i in 0..n {
            direction[i] /= largest;
            turn[i] /= largest;
            let (p, move_by) = (state.position.get(i), direction[i] * h);
            plus.position.set(i, p + move_by);
            minus.position.set(i, p - move_by);
            plus.angle[i] = state.angle[i] + turn[i] * h;
            minus.angle[i] = state.angle[i] - turn[i] * h;
        }
        for side in [&mut plus, &mut minus] {
            side.tangent.clone_from(&state.tangent);
            side.director.clone_from(&state.director);
            side.reference_twist.clone_from(&state.reference_twist);
            side.carry_frames(bundle);
        }
        evaluator.forces(bundle, &plus, &mut ahead);
        evaluator.forces(bundle, &minus, &mut behind);
        // Norms in mass, in which M⁻¹K is symmetric.
        let (mut before, mut after) = (0.0, 0.0);
        for i in 0..n {
            let a = (behind.linear.get(i) - ahead.linear.get(i)) / (2.0 * h * bundle.mass[i]);
            before += bundle.mass[i] * direction[i].length_squared();
            after += bundle.mass[i] * a.length_squared();
            direction[i] = a;
            if bundle.twisting {
                let b = (behind.moment[i] - ahead.moment[i]) / (2.0 * h) * inverse_inertia(i);
                before += bundle.inertia[i] * turn[i] * turn[i];
                after += bundle.inertia[i] * b * b;
                turn[i] = b;
            }
        }
        square = square.max((after / before).sqrt());
    }
    if square > 0.0 {
        2.0 / (square.sqrt() * MARGIN)
    } else {
        f64::INFINITY
    }
}
