//! A body: a shape that stays, is moved, or is free to move (a rigid body by Newton and Euler).

use super::BodyError;
use super::shape::{Inertia, Shape, Solid};
use crate::loads::{Motion, rotation_of, rotation_vector};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// How a body moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyMotion {
    /// As given, whatever hits it; its pose turns about the body's place. [`Motion::Fixed`] for a body that stays.
    Given(Motion),
    /// Freely.
    Free {
        /// Density, kg/m³.
        density: f64,
        /// Velocity of its centre of mass at the start, m/s.
        velocity: DVec3,
        /// Angular velocity at the start, rad/s.
        angular: DVec3,
    },
}

/// A body at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Name, for messages; may be empty.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Where the shape's origin is, m.
    pub place: DVec3,
    /// How the shape is turned.
    pub turn: DQuat,
    /// How it moves.
    pub motion: BodyMotion,
    /// Part of the speed of approach that is left after a collision, 0 to 1.
    pub restitution: f64,
    /// Coefficient of (Coulomb) friction.
    pub friction: f64,
}

impl Body {
    /// A body that stays, without friction and restitution.
    pub fn fixed(shape: Shape, place: DVec3) -> Self {
        Body {
            name: String::new(),
            shape,
            place,
            turn: DQuat::IDENTITY,
            motion: BodyMotion::Given(Motion::Fixed),
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
        if !self.place.is_finite() {
            return fail("place (m)", f64::NAN, "finite");
        }
        if (self.turn.length() - 1.0).abs() > 1e-9 || !self.turn.is_finite() {
            return fail("length of its rotation", self.turn.length(), "1");
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
            angular,
        } = self.motion
        {
            if !(density > 0.0 && density.is_finite()) {
                return fail("density (kg/m³)", density, "above 0 and finite");
            }
            if !(velocity.is_finite() && angular.is_finite()) {
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

/// Where a body is and how it moves: what a checkpoint holds of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Centre of mass of a free body, else the shape's origin, m.
    pub centre: DVec3,
    /// Orientation.
    pub turn: DQuat,
    /// Velocity of the centre, m/s.
    pub velocity: DVec3,
    /// Angular momentum of a free body about its centre, kg m²/s.
    pub spin: DVec3,
    /// Angular velocity, rad/s.
    pub angular: DVec3,
}

/// A body in motion.
#[derive(Clone)]
pub(super) struct Moving {
    pub body: Body,
    pub solid: Solid,
    /// Of a free body.
    pub inertia: Option<Inertia>,
    pub state: BodyState,
}

impl Moving {
    pub fn new(number: usize, body: Body) -> Result<Self, BodyError> {
        body.check(number)?;
        let solid = body.shape.build(number)?;
        let mut state = BodyState {
            centre: body.place,
            turn: body.turn,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            angular: DVec3::ZERO,
        };
        let mut inertia = None;
        if let BodyMotion::Free {
            density,
            velocity,
            angular,
        } = body.motion
        {
            let i = solid.inertia(density);
            if !(i.mass > 0.0 && i.mass.is_finite() && i.tensor.is_finite()) {
                return Err(BodyError::Value {
                    body: number,
                    what: "mass (kg)",
                    value: i.mass,
                    right: "above 0 and finite; a mesh must be closed and turned outwards",
                });
            }
            state.centre += body.turn * i.centre;
            state.velocity = velocity;
            let turn = DMat3::from_quat(body.turn);
            state.spin = turn * (i.tensor * (turn.transpose() * angular));
            state.angular = angular;
            inertia = Some(i);
        }
        Ok(Moving {
            body,
            solid,
            inertia,
            state,
        })
    }

    /// Where the shape's origin is, m.
    pub fn origin(&self) -> DVec3 {
        match self.inertia {
            Some(i) => self.state.centre - self.state.turn * i.centre,
            None => self.state.centre,
        }
    }

    /// A point of the world in the shape's coordinates.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.state.turn.conjugate() * (p - self.origin())
    }

    /// Velocity of the body at a point, m/s.
    pub fn velocity_at(&self, p: DVec3) -> DVec3 {
        self.state.velocity + self.state.angular.cross(p - self.state.centre)
    }

    /// Inverse of the inertia along the world's axes.
    pub fn inverse_inertia(&self) -> DMat3 {
        match self.inertia {
            Some(i) => {
                let turn = DMat3::from_quat(self.state.turn);
                turn * i.inverse * turn.transpose()
            }
            None => DMat3::ZERO,
        }
    }

    /// What a unit impulse along `n` (unit) at `p` changes of the velocity along `n` there, 1/kg.
    pub fn yielding(&self, p: DVec3, n: DVec3) -> f64 {
        match self.inertia {
            Some(i) => {
                let arm = (p - self.state.centre).cross(n);
                1.0 / i.mass + arm.dot(self.inverse_inertia() * arm)
            }
            None => 0.0,
        }
    }

    /// Applies an impulse (N s) at a point.
    pub fn push(&mut self, p: DVec3, impulse: DVec3) {
        if let Some(i) = self.inertia {
            self.state.velocity += impulse / i.mass;
            self.state.spin += (p - self.state.centre).cross(impulse);
            self.state.angular = self.inverse_inertia() * self.state.spin;
        }
    }

    /// Takes the velocity of a step that ends at `time` (s), from its motion or from gravity.
    pub fn kick(&mut self, time: f64, step: f64, gravity: DVec3) {
        match &self.body.motion {
            BodyMotion::Given(Motion::Fixed) => {}
            BodyMotion::Given(motion) => {
                let (now, before) = (motion.pose(time), motion.pose(time - step));
                let per = if step > 0.0 { 1.0 / step } else { 0.0 };
                self.state.velocity = (now.translation - before.translation) * per;
                self.state.angular = rotation_of(now.rotation * before.rotation.conjugate()) * per;
            }
            BodyMotion::Free { .. } => self.state.velocity += gravity * step,
        }
    }

    /// Moves on by a step that ends at `time` (s).
    pub fn drift(&mut self, time: f64, step: f64) {
        match &self.body.motion {
            BodyMotion::Given(Motion::Fixed) => {}
            BodyMotion::Given(motion) => {
                let now = motion.pose(time);
                self.state.centre = self.body.place + now.translation;
                self.state.turn = (now.rotation * self.body.turn).normalize();
            }
            BodyMotion::Free { .. } => {
                self.state.centre += self.state.velocity * step;
                // The midpoint rule keeps the energy of free rotation to second order, and L is kept as it is.
                let start = self.state.turn;
                self.state.turn =
                    (rotation_vector(self.state.angular * (0.5 * step)) * start).normalize();
                let middle = self.inverse_inertia() * self.state.spin;
                self.state.turn = (rotation_vector(middle * step) * start).normalize();
                self.state.angular = self.inverse_inertia() * self.state.spin;
            }
        }
    }

    /// Kinetic energy of a free body, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.inertia.map_or(0.0, |i| {
            0.5 * (i.mass * self.state.velocity.length_squared()
                + self.state.angular.dot(self.state.spin))
        })
    }
}
