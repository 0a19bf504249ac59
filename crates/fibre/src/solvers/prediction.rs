//! The state in which the search for an equilibrium with inertia starts: where all that moves would be without forces.
//!
//! Each connected part moves on as a rigid body, which it may do far in a step. Within it what bends may go on bending or swing
//! back many times in the step: how far it goes is left to a line search.

use super::rigid_parts::{RigidPart, motion_of_parts};
use crate::rod_bundle::RodBundle;
use crate::rotation::from_rotation_vector;
use crate::state::State;
use glam::DQuat;

/// Largest displacement of a vertex within its part, in the part's shortest edge.
const MAX_DISPLACEMENT: f64 = 0.5;
/// Largest turn of a material frame, rad.
const MAX_TURN: f64 = 0.5;
/// Where a search for an equilibrium starts.
pub(super) struct Prediction {
    /// The state to which connected parts move as rigid bodies.
    pub state: State,
    /// Per degree of freedom, three at a vertex or with twist four: the displacement beside that of the rigid bodies.
    pub displacement: Vec<f64>,
}

/// Returns the prediction for `dt` seconds after `state` of a bundle with these [connected parts](super::limit_step).
pub(super) fn predict(bundle: &RodBundle, part: &[usize], state: &State, dt: f64) -> Prediction {
    let parts = motion_of_parts(bundle, (&state.position, &state.velocity), part);
    // Implicit Euler turns a rigid body by the angle whose tangent is ω dt.
    let turn = |p: &RigidPart| {
        let axis = p.angular_velocity.normalize_or_zero();
        from_rotation_vector(axis * libm::atan(p.angular_velocity.length() * dt))
    };
    let rotations: Vec<DQuat> = parts.iter().map(turn).collect();
    let block = if bundle.twisting { 4 } else { 3 };
    let mut displacement = vec![0.0; block * bundle.vertices()];
    let mut predicted = state.clone();
    for v in 0..bundle.vertices() {
        let p = &parts[part[v]];
        let (position, velocity) = (state.position.get(v), state.velocity.get(v));
        let limit = MAX_DISPLACEMENT * p.shortest / dt;
        let share = if p.fastest > limit {
            limit / p.fastest
        } else {
            1.0
        };
        let own = p.own_velocity(position, velocity) * (share * dt);
        let to = p.centre + p.velocity * dt + rotations[part[v]] * (position - p.centre);
        let at = block * v;
        if to.is_finite() && own.is_finite() {
            predicted.position.set(v, to);
            displacement[at..at + 3].copy_from_slice(&own.to_array());
        }
        let turn = state.spin[v] * dt;
        if bundle.twisting && turn.abs() <= MAX_TURN {
            displacement[at + 3] = turn;
        }
    }
    predicted.transport_frames(bundle);
    Prediction {
        state: predicted,
        displacement,
    }
}

#[cfg(test)]
mod tests {
    use super::super::limit_step::connected_parts;
    use super::*;
    use crate::rod_bundle::{Rod, RodMaterial};
    use glam::DVec3;

    #[test]
    fn a_body_that_turns_freely_is_predicted_without_strain() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let vertices =
            (0..6).map(|i| DVec3::new(1e-3 * f64::from(i * i), 0.0, 4e-3 * f64::from(i)));
        let bundle = RodBundle::new(&[Rod::new(vertices.collect(), material)], true).unwrap();
        let mut state = State::at_rest(&bundle);
        let (along, turn) = (DVec3::new(1.0, -2.0, 3.0), DVec3::new(40.0, 300.0, -100.0));
        for v in 0..6 {
            let velocity = along + turn.cross(state.position.get(v));
            state.velocity.set(v, velocity);
        }
        let Prediction {
            state: predicted,
            displacement,
        } = predict(&bundle, &connected_parts(&bundle), &state, 2e-3);
        assert!(displacement.iter().all(|d| d.abs() < 1e-7));
        for j in 0..5 {
            let ratio = predicted.edge(j).length() / state.edge(j).length();
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
            let cosine = predicted.edge(j).normalize().dot(state.edge(j).normalize());
            assert!(cosine < 0.95, "{cosine}");
        }
        let mean =
            |s: &State| (0..6).fold(DVec3::ZERO, |c, v| c + s.position.get(v) * bundle.mass[v]);
        let mass: f64 = bundle.mass.iter().sum();
        let moved = (mean(&predicted) - mean(&state)) / mass;
        let start = (0..6).fold(DVec3::ZERO, |c, v| {
            c + state.velocity.get(v) * bundle.mass[v]
        }) / mass;
        assert!((moved - start * 2e-3).length() < 1e-12);
    }
}
