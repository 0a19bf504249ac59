//! Grips: springs on the mean displacement of some vertices.

use crate::bundle::Bundle;
use crate::state::State;
use glam::DVec3;

/// A grip on the mean displacement of some vertices: it spreads its force over them and lets them turn, as a beam's
/// supports do in beam theory. A stiff spring.
#[derive(Debug, Clone, PartialEq)]
pub struct Grip {
    /// Vertices, by their numbers in the unbroken bundle.
    pub vertices: Vec<u32>,
    /// Their weights; both halves of a broken vertex share its.
    pub weights: Vec<f64>,
    /// Direction (unit).
    pub direction: DVec3,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Speed of the spring's other end along the direction, m/s; at time 0 it is where the vertices are at rest.
    pub speed: f64,
}

/// A grip on the bundle as it is now.
#[derive(Debug, Clone)]
pub(super) struct Held {
    /// Vertices with weights whose sum is 1.
    pub vertices: Vec<(u32, f64)>,
    pub direction: DVec3,
    pub stiffness: f64,
    speed: f64,
}

impl Held {
    pub fn displacement(&self, bundle: &Bundle, state: &State) -> f64 {
        self.vertices.iter().fold(0.0, |sum, &(v, w)| {
            let moved = state.position.get(v as usize) - bundle.rest.get(v as usize);
            sum + w * moved.dot(self.direction)
        })
    }

    pub fn force(&self, bundle: &Bundle, state: &State, time: f64) -> f64 {
        self.stiffness * (self.speed * time - self.displacement(bundle, state))
    }
}

/// The grip on a bundle as it is now.
pub(super) fn resolve(grip: &Grip, bundle: &Bundle) -> Held {
    let mut vertices = Vec::new();
    for (&origin, &weight) in grip.vertices.iter().zip(&grip.weights) {
        let copies: Vec<usize> = (0..bundle.vertices())
            .filter(|&v| bundle.origin[v] == origin)
            .collect();
        let mass: f64 = copies.iter().map(|&v| bundle.mass[v]).sum();
        vertices.extend(
            copies
                .iter()
                .map(|&v| (v as u32, weight * bundle.mass[v] / mass)),
        );
    }
    let sum: f64 = vertices.iter().map(|v| v.1).sum();
    vertices.iter_mut().for_each(|v| v.1 /= sum);
    Held {
        vertices,
        direction: grip.direction,
        stiffness: grip.stiffness,
        speed: grip.speed,
    }
}
