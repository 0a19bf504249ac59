//! Grips: springs on the mean displacement of some vertices.

use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// A grip on the mean displacement of some vertices: a stiff spring that distributes its force over them and lets them turn,
/// as the supports of a beam do in beam theory.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grip {
    /// Vertices, by their numbers in the unbroken bundle.
    pub vertices: Vec<u32>,
    /// Their weights. Both halves of a broken vertex share its weight.
    pub weights: Vec<f64>,
    /// Direction (unit).
    pub direction: DVec3,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Velocity of the spring's other end along the direction, m/s. At time 0 it is where the vertices are at rest.
    pub speed: f64,
}

/// A vertex that a grip holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrippedVertex {
    pub vertex: u32,
    /// Its weight; all weights of a grip sum to 1.
    pub weight: f64,
}

/// A grip on the bundle in its present numbering.
#[derive(Debug, Clone)]
pub(super) struct ResolvedGrip {
    pub vertices: Vec<GrippedVertex>,
    pub direction: DVec3,
    pub stiffness: f64,
    speed: f64,
}

impl ResolvedGrip {
    /// Finds the vertices of a grip on a bundle.
    pub fn new(grip: &Grip, bundle: &RodBundle) -> Self {
        let mut vertices = Vec::new();
        for (&origin, &weight) in grip.vertices.iter().zip(&grip.weights) {
            let copies: Vec<usize> = (0..bundle.vertices())
                .filter(|&v| bundle.origin[v] == origin)
                .collect();
            let mass: f64 = copies.iter().map(|&v| bundle.mass[v]).sum();
            vertices.extend(copies.iter().map(|&v| GrippedVertex {
                vertex: v as u32,
                weight: weight * bundle.mass[v] / mass,
            }));
        }
        let sum: f64 = vertices.iter().map(|v| v.weight).sum();
        vertices.iter_mut().for_each(|v| v.weight /= sum);
        ResolvedGrip {
            vertices,
            direction: grip.direction,
            stiffness: grip.stiffness,
            speed: grip.speed,
        }
    }

    /// Returns the mean displacement of the vertices, m.
    pub fn displacement(&self, bundle: &RodBundle, state: &State) -> f64 {
        self.vertices.iter().fold(0.0, |sum, held| {
            let v = held.vertex as usize;
            let displacement = state.position.get(v) - bundle.rest.get(v);
            sum + held.weight * displacement.dot(self.direction)
        })
    }

    /// Returns the force of the spring, N.
    pub fn force(&self, bundle: &RodBundle, state: &State, time: f64) -> f64 {
        self.stiffness * (self.speed * time - self.displacement(bundle, state))
    }
}
