//! How the connected parts of a bundle move as rigid bodies.

use crate::rod_bundle::RodBundle;
use crate::vectors::Vectors;
use glam::{DMat3, DVec3};

/// What is added to the moments of inertia of a part, as a fraction of their sum: a straight rod has none about itself.
const INERTIA_FLOOR: f64 = 1e-6;

/// The motion of a connected part.
#[derive(Debug, Clone, Copy)]
pub(super) struct RigidPart {
    mass: f64,
    /// Sums of mass times position and velocity, then the centre of mass (m) and its velocity (m/s).
    pub centre: DVec3,
    pub velocity: DVec3,
    angular_momentum: DVec3,
    inertia: DMat3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
    /// Its shortest edge, m.
    pub shortest: f64,
    /// Largest velocity beside that of the rigid body, m/s.
    pub fastest: f64,
}

impl RigidPart {
    const ZERO: RigidPart = RigidPart {
        mass: 0.0,
        centre: DVec3::ZERO,
        velocity: DVec3::ZERO,
        angular_momentum: DVec3::ZERO,
        inertia: DMat3::ZERO,
        angular_velocity: DVec3::ZERO,
        shortest: 0.0,
        fastest: 0.0,
    };

    /// Returns the velocity of the rigid body at a place, m/s.
    pub fn velocity_at(&self, position: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(position - self.centre)
    }

    /// Returns the velocity beside that of the rigid body, m/s.
    pub fn own_velocity(&self, position: DVec3, velocity: DVec3) -> DVec3 {
        velocity - self.velocity_at(position)
    }
}

/// Returns the motion of each part, by the number of its first vertex.
pub(super) fn motion_of_parts(
    bundle: &RodBundle,
    (position, velocity): (&Vectors, &Vectors),
    part: &[usize],
) -> Vec<RigidPart> {
    let n = bundle.vertices();
    let mut parts = vec![RigidPart::ZERO; n];
    for v in 0..n {
        let p = &mut parts[part[v]];
        p.mass += bundle.mass[v];
        p.centre += position.get(v) * bundle.mass[v];
        p.velocity += velocity.get(v) * bundle.mass[v];
    }
    for p in parts.iter_mut().filter(|p| p.mass > 0.0) {
        p.centre /= p.mass;
        p.velocity /= p.mass;
        p.shortest = f64::INFINITY;
    }
    for v in 0..n {
        let p = &mut parts[part[v]];
        let arm = position.get(v) - p.centre;
        let momentum = (velocity.get(v) - p.velocity) * bundle.mass[v];
        p.angular_momentum += arm.cross(momentum);
        let along = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        p.inertia +=
            (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - along) * bundle.mass[v];
        if bundle.is_edge(v) {
            p.shortest = p.shortest.min(bundle.rest_length[v]);
        }
    }
    for p in &mut parts {
        let trace = p.inertia.x_axis.x + p.inertia.y_axis.y + p.inertia.z_axis.z;
        if trace > 0.0 {
            let inertia = p.inertia + DMat3::from_diagonal(DVec3::splat(INERTIA_FLOOR * trace));
            p.angular_velocity = inertia.inverse() * p.angular_momentum;
        }
    }
    for v in 0..n {
        let p = &mut parts[part[v]];
        let own = p.own_velocity(position.get(v), velocity.get(v));
        p.fastest = p.fastest.max(own.length());
    }
    parts
}
