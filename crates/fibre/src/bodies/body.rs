//! Bodies: shapes that stay, are moved, or are free to move (rigid bodies by Newton's and Euler's equations).

use super::error::BodyError;
use super::shape::{Inertia, Shape, Solid};
use super::state::BodyState;
use crate::loads::Motion;
use crate::rotation::{from_rotation_vector, to_rotation_vector};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// How a body moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyMotion {
    /// A prescribed motion, whatever hits the body; its pose turns about the body's position. [`Motion::Fixed`] for a body
    /// that stays.
    Prescribed(Motion),
    /// Free motion.
    Free {
        /// Density, kg/m³.
        density: f64,
        /// Velocity of its centre of mass at the start, m/s.
        velocity: DVec3,
        /// Angular velocity at the start, rad/s.
        angular_velocity: DVec3,
    },
}

/// A body at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Name, for messages; may be empty.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Position of the shape's origin, m.
    pub position: DVec3,
    /// Orientation of the shape.
    pub rotation: DQuat,
    /// Its motion.
    pub motion: BodyMotion,
    /// Coefficient of restitution: the fraction of the approach speed that is left after a collision, 0 to 1.
    pub restitution: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
}

impl Body {
    /// Returns a body that stays, without friction and restitution.
    pub fn fixed(shape: Shape, position: DVec3) -> Self {
        Body {
            name: String::new(),
            shape,
            position,
            rotation: DQuat::IDENTITY,
            motion: BodyMotion::Prescribed(Motion::Fixed),
            restitution: 0.0,
            friction: 0.0,
        }
    }

    fn check(&self, body: usize) -> Result<(), BodyError> {
        let fail = |what, value, right| {
            Err(BodyError::Value {
                body,
                what,
                value,
                right,
            })
        };
        if !self.position.is_finite() {
            return fail("position (m)", f64::NAN, "finite");
        }
        if (self.rotation.length() - 1.0).abs() > 1e-9 || !self.rotation.is_finite() {
            return fail("length of its rotation", self.rotation.length(), "1");
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return fail("restitution", self.restitution, "from 0 to 1");
        }
        if !(self.friction >= 0.0 && self.friction.is_finite()) {
            return fail("friction", self.friction, "0 or more and finite");
        }
        if let BodyMotion::Free {
            density,
            velocity,
            angular_velocity,
        } = self.motion
        {
            if !(density > 0.0 && density.is_finite()) {
                return fail("density (kg/m³)", density, "above 0 and finite");
            }
            if !(velocity.is_finite() && angular_velocity.is_finite()) {
                return fail("velocity", f64::NAN, "finite");
            }
            if let Shape::HalfSpace { .. } = self.shape {
                return fail(
                    "mass of a half-space (kg)",
                    f64::INFINITY,
                    "finite; a half-space cannot move freely",
                );
            }
        }
        Ok(())
    }
}

/// A body in motion.
#[derive(Clone)]
pub(super) struct MovingBody {
    pub body: Body,
    pub solid: Solid,
    /// Inertia of a free body.
    pub inertia: Option<Inertia>,
    pub state: BodyState,
}

impl MovingBody {
    pub fn new(number: usize, body: Body) -> Result<Self, BodyError> {
        body.check(number)?;
        let solid = body.shape.build(number)?;
        let mut state = BodyState {
            centre: body.position,
            rotation: body.rotation,
            velocity: DVec3::ZERO,
            angular_momentum: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        };
        let mut inertia = None;
        if let BodyMotion::Free {
            density,
            velocity,
            angular_velocity,
        } = body.motion
        {
            let i = solid.inertia(density);
            if !(i.mass > 0.0 && i.mass.is_finite() && i.tensor.is_finite()) {
                return Err(BodyError::Value {
                    body: number,
                    what: "mass (kg)",
                    value: i.mass,
                    right: "above 0 and finite; a mesh must be closed, with its triangles counter-clockwise from outside",
                });
            }
            state.centre += body.rotation * i.centre;
            state.velocity = velocity;
            let rotation = DMat3::from_quat(body.rotation);
            state.angular_momentum =
                rotation * (i.tensor * (rotation.transpose() * angular_velocity));
            state.angular_velocity = angular_velocity;
            inertia = Some(i);
        }
        Ok(MovingBody {
            body,
            solid,
            inertia,
            state,
        })
    }

    /// Whether its motion is prescribed, other than rest.
    pub(crate) fn is_driven(&self) -> bool {
        matches!(&self.body.motion, BodyMotion::Prescribed(m) if *m != Motion::Fixed)
    }

    /// Returns the position of the shape's origin, m.
    pub fn origin(&self) -> DVec3 {
        match self.inertia {
            Some(i) => self.state.centre - self.state.rotation * i.centre,
            None => self.state.centre,
        }
    }

    /// Returns a point of the world in the shape's coordinates.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.state.rotation.conjugate() * (p - self.origin())
    }

    /// Returns the velocity of the body at a point, m/s.
    pub(crate) fn velocity_at(&self, p: DVec3) -> DVec3 {
        self.state.velocity + self.state.angular_velocity.cross(p - self.state.centre)
    }

    /// Returns the inverse of the inertia along the world's axes.
    pub(crate) fn inverse_inertia(&self) -> DMat3 {
        match self.inertia {
            Some(i) => {
                let rotation = DMat3::from_quat(self.state.rotation);
                rotation * i.inverse * rotation.transpose()
            }
            None => DMat3::ZERO,
        }
    }

    /// Returns the inverse of the effective mass at `p` along `n` (unit): the change of velocity along `n` by a unit impulse,
    /// 1/kg.
    pub(crate) fn inverse_effective_mass(&self, p: DVec3, n: DVec3) -> f64 {
        match self.inertia {
            Some(i) => {
                let arm = (p - self.state.centre).cross(n);
                1.0 / i.mass + arm.dot(self.inverse_inertia() * arm)
            }
            None => 0.0,
        }
    }

    /// Applies an impulse (N s) at a point.
    pub(crate) fn apply_impulse(&mut self, p: DVec3, impulse: DVec3) {
        if let Some(i) = self.inertia {
            self.state.velocity += impulse / i.mass;
            self.state.angular_momentum += (p - self.state.centre).cross(impulse);
            self.state.angular_velocity = self.inverse_inertia() * self.state.angular_momentum;
        }
    }

    /// Updates the velocity for a step that ends at `time` (s), from the prescribed motion or from gravity.
    pub(crate) fn update_velocity(&mut self, time: f64, step: f64, gravity: DVec3) {
        match &self.body.motion {
            BodyMotion::Prescribed(Motion::Fixed) => {}
            BodyMotion::Prescribed(motion) => {
                let (now, before) = (motion.pose(time), motion.pose(time - step));
                let per = if step > 0.0 { 1.0 / step } else { 0.0 };
                self.state.velocity = (now.translation - before.translation) * per;
                let turn = now.rotation * before.rotation.conjugate();
                self.state.angular_velocity = to_rotation_vector(turn) * per;
            }
            BodyMotion::Free { .. } => self.state.velocity += gravity * step,
        }
    }

    /// Updates the position for a step that ends at `time` (s).
    pub(crate) fn update_position(&mut self, time: f64, step: f64) {
        match &self.body.motion {
            BodyMotion::Prescribed(Motion::Fixed) => {}
            BodyMotion::Prescribed(motion) => {
                let now = motion.pose(time);
                self.state.centre = self.body.position + now.translation;
                self.state.rotation = (now.rotation * self.body.rotation).normalize();
            }
            BodyMotion::Free { .. } => {
                self.state.centre += self.state.velocity * step;
                // The midpoint rule conserves the energy of free rotation to second order; the angular momentum is constant.
                let start = self.state.rotation;
                let half = from_rotation_vector(self.state.angular_velocity * (0.5 * step));
                self.state.rotation = (half * start).normalize();
                let middle = self.inverse_inertia() * self.state.angular_momentum;
                self.state.rotation = (from_rotation_vector(middle * step) * start).normalize();
                self.state.angular_velocity = self.inverse_inertia() * self.state.angular_momentum;
            }
        }
    }

    /// Returns the kinetic energy of a free body, J.
    pub(crate) fn kinetic_energy(&self) -> f64 {
        self.inertia.map_or(0.0, |i| {
            0.5 * (i.mass * self.state.velocity.length_squared()
                + self.state.angular_velocity.dot(self.state.angular_momentum))
        })
    }
}
