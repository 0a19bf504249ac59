//! The state of a bundle: everything about it that moves.

use crate::material_frame;
use crate::rod_bundle::RodBundle;
use crate::vectors::Vectors;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Positions, velocities and frames of the rods. Arrays are laid out as in [`RodBundle`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Number of steps that solvers have taken.
    pub step: u64,
    /// Per vertex: position, m.
    pub position: Vectors,
    /// Per vertex: velocity, m/s.
    pub velocity: Vectors,
    /// Per edge: angle from reference director to material director, rad; all 0 without twist.
    pub angle: Vec<f64>,
    /// Per edge: rate of that angle, rad/s.
    pub spin: Vec<f64>,
    /// Per edge: the unit tangent to which the reference director is perpendicular. Empty without twist.
    pub tangent: Vectors,
    /// Per edge: reference director (unit). Empty without twist.
    pub director: Vectors,
    /// Per vertex: reference twist, rad. Empty without twist.
    pub reference_twist: Vec<f64>,
    /// Per edge: plastic strain (negative after yielding in compression).
    pub plastic_strain: Vec<f64>,
}

impl State {
    /// Returns the state of a bundle at rest.
    pub fn at_rest(bundle: &RodBundle) -> Self {
        let n = bundle.vertices();
        let mut state = State {
            time: 0.0,
            step: 0,
            position: bundle.rest.clone(),
            velocity: Vectors::zeros(n),
            angle: vec![0.0; n],
            spin: vec![0.0; n],
            tangent: Vectors::default(),
            director: Vectors::default(),
            reference_twist: Vec::new(),
            plastic_strain: vec![0.0; n],
        };
        if bundle.twisting {
            state.tangent = (0..n).map(|j| state.edge_tangent(bundle, j)).collect();
            state.director = bundle.rest_director.clone();
            state.reference_twist = vec![0.0; n];
            state.transport_frames(bundle);
        }
        state
    }

    /// Returns the edge vector y₁ − y₀, m.
    #[inline]
    pub fn edge(&self, edge: usize) -> DVec3 {
        self.position.get(edge + 1) - self.position.get(edge)
    }

    fn edge_tangent(&self, bundle: &RodBundle, edge: usize) -> DVec3 {
        if bundle.is_edge(edge) {
            self.edge(edge).normalize_or(DVec3::Z)
        } else {
            DVec3::Z
        }
    }

    /// Transports reference directors with their edges to the present positions and updates the reference twist. Without
    /// twist it does nothing.
    pub fn transport_frames(&mut self, bundle: &RodBundle) {
        if !bundle.twisting {
            return;
        }
        for j in 0..bundle.vertices() {
            if !bundle.is_edge(j) {
                continue;
            }
            let t = self.edge_tangent(bundle, j);
            let transported =
                material_frame::parallel_transport(self.director.get(j), self.tangent.get(j), t);
            // Over many steps rounding would tilt directors out of the plane across the edge.
            let director = transported
                .reject_from_normalized(t)
                .normalize_or(t.any_orthonormal_vector());
            self.director.set(j, director);
            self.tangent.set(j, t);
        }
        for i in 0..bundle.vertices() {
            if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
                let frame = |j: usize| (self.tangent.get(j), self.director.get(j));
                self.reference_twist[i] = material_frame::reference_twist(
                    frame(i - 1),
                    frame(i),
                    self.reference_twist[i],
                );
            }
        }
    }

    /// Returns the first material director of an edge; the second is tangent × first. Without twist it is the director at
    /// rest, transported from the edge at rest to the edge now.
    pub(crate) fn material_director(&self, bundle: &RodBundle, edge: usize) -> DVec3 {
        if bundle.twisting {
            return material_frame::rotate_director(
                self.director.get(edge),
                self.tangent.get(edge),
                self.angle[edge],
            );
        }
        let rest = bundle.rest.get((edge + 1).min(bundle.vertices() - 1)) - bundle.rest.get(edge);
        let from = if bundle.is_edge(edge) {
            rest.normalize_or(DVec3::Z)
        } else {
            DVec3::Z
        };
        material_frame::parallel_transport(
            bundle.rest_director.get(edge),
            from,
            self.edge_tangent(bundle, edge),
        )
    }

    /// Returns the momentum, kg m/s.
    pub fn momentum(&self, bundle: &RodBundle) -> DVec3 {
        (0..bundle.vertices()).fold(DVec3::ZERO, |sum, i| {
            sum + self.velocity.get(i) * bundle.mass[i]
        })
    }

    /// Returns the angular momentum of the vertices about `centre` with the spin of the edges about themselves, kg m²/s.
    pub fn angular_momentum(&self, bundle: &RodBundle, centre: DVec3) -> DVec3 {
        (0..bundle.vertices()).fold(DVec3::ZERO, |sum, i| {
            let arm = self.position.get(i) - centre;
            let spin = if bundle.is_edge(i) {
                self.edge_tangent(bundle, i) * (bundle.inertia[i] * self.spin[i])
            } else {
                DVec3::ZERO
            };
            sum + arm.cross(self.velocity.get(i)) * bundle.mass[i] + spin
        })
    }

    /// Returns the kinetic energy of the vertices and of the edges' spin, J.
    pub(crate) fn kinetic_energy(&self, bundle: &RodBundle) -> f64 {
        (0..bundle.vertices()).fold(0.0, |sum, i| {
            let moving = bundle.mass[i] * self.velocity.get(i).length_squared();
            sum + 0.5 * (moving + bundle.inertia[i] * self.spin[i] * self.spin[i])
        })
    }

    /// Whether every number of the motion is finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [&self.position, &self.velocity];
        let parts = vectors.into_iter().flat_map(|v| [&v.x, &v.y, &v.z]);
        parts
            .chain([&self.angle, &self.spin])
            .all(|a| a.iter().all(|v| v.is_finite()))
    }
}
