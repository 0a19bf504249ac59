//! Grips: springs on a weighted sum of the displacements of some vertices.

use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// A grip: a stiff spring that distributes its force over some vertices, and acts on the displacement that does work with it. With
/// one direction that is their mean displacement, and they turn freely, as on the supports of a beam in beam theory.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grip {
    /// Vertices, by their numbers in the unbroken bundle.
    pub vertices: Vec<u32>,
    /// The force on each over that of the spring. Both halves of a broken vertex share it.
    pub weights: Vec<DVec3>,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Velocity of the spring's other end, m/s. At time 0 it is where the vertices are at rest.
    pub speed: f64,
}

impl Grip {
    /// Returns a grip on the mean displacement of some vertices in a direction, with weights of any sum.
    pub fn on_mean(vertices: Vec<u32>, weights: &[f64], direction: DVec3) -> Self {
        let sum: f64 = weights.iter().sum();
        Grip {
            vertices,
            weights: weights.iter().map(|w| direction * (w / sum)).collect(),
            stiffness: 0.0,
            speed: 0.0,
        }
    }

    /// Returns the grip with a spring, and with the speed of its other end.
    #[must_use]
    pub fn with_spring(self, stiffness: f64, speed: f64) -> Self {
        Grip {
            stiffness,
            speed,
            ..self
        }
    }
}

/// A vertex that a grip holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrippedVertex {
    pub vertex: u32,
    /// The force on it over that of the spring.
    pub weight: DVec3,
}

/// A grip on the bundle in its present numbering.
#[derive(Debug, Clone)]
pub(super) struct ResolvedGrip {
    pub vertices: Vec<GrippedVertex>,
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
                weight: weight * (bundle.mass[v] / mass),
            }));
        }
        ResolvedGrip {
            vertices,
            stiffness: grip.stiffness,
            speed: grip.speed,
        }
    }

    /// Returns the displacement on which the spring acts, m.
    pub fn displacement(&self, bundle: &RodBundle, state: &State) -> f64 {
        self.vertices.iter().fold(0.0, |sum, held| {
            let v = held.vertex as usize;
            let displacement = state.position.get(v) - bundle.rest.get(v);
            sum + held.weight.dot(displacement)
        })
    }

    /// Returns the force of the spring, N.
    pub fn force(&self, bundle: &RodBundle, state: &State, time: f64) -> f64 {
        self.stiffness * (self.speed * time - self.displacement(bundle, state))
    }
}
