//! External loads on a bundle: clamps, forces, moments, gravity, damping and wind.

use crate::error::LoadError;
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::rotation::{from_rotation_vector, to_rotation_vector};
use crate::vectors::Vectors;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A displacement and a rotation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Displacement, m.
    pub translation: DVec3,
    /// Rotation about the centre of what moves.
    pub rotation: DQuat,
}

impl Pose {
    /// No displacement and no rotation.
    pub const REST: Pose = Pose {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
    };
}

/// The pose at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Keyframe {
    /// Time, s; ascending within a motion.
    pub time: f64,
    /// Pose at that time.
    pub pose: Pose,
}

/// The prescribed motion of a clamp or body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// It stays where it is.
    Fixed,
    /// Constant velocity and angular velocity from time 0.
    Steady {
        /// Velocity, m/s.
        velocity: DVec3,
        /// Angular velocity about its centre, rad/s.
        angular_velocity: DVec3,
    },
    /// Poses at given times: straight and at constant rate between them, at rest before the first and after the last.
    Keyframes(Vec<Keyframe>),
}

impl Motion {
    /// Returns the pose at `time` (s).
    pub fn pose(&self, time: f64) -> Pose {
        match self {
            Motion::Fixed => Pose::REST,
            Motion::Steady {
                velocity,
                angular_velocity,
            } => Pose {
                translation: *velocity * time,
                rotation: from_rotation_vector(*angular_velocity * time),
            },
            Motion::Keyframes(keys) => {
                let k = keys.partition_point(|key| key.time <= time);
                match (k.checked_sub(1).map(|i| keys[i]), keys.get(k)) {
                    (Some(before), Some(after)) => {
                        let (p, q) = (before.pose, after.pose);
                        let f = (time - before.time) / (after.time - before.time);
                        let turn = to_rotation_vector(q.rotation * p.rotation.conjugate());
                        Pose {
                            translation: p.translation.lerp(q.translation, f),
                            rotation: from_rotation_vector(turn * f) * p.rotation,
                        }
                    }
                    (Some(last), None) => last.pose,
                    (None, Some(first)) => first.pose,
                    (None, None) => Pose::REST,
                }
            }
        }
    }
}

/// A clamp: vertices, and the twist of edges, whose motion is prescribed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Clamp {
    /// Vertices held. Two neighbours on a rod hold its direction too.
    pub vertices: Vec<u32>,
    /// Per vertex held: its position at [`Pose::REST`], m.
    pub rest_positions: Vec<DVec3>,
    /// Which axes are held: all three for a fixed end, one for a sliding support.
    pub axes: [bool; 3],
    /// Edges whose material frame turns with the clamp, where twist is on. Their vertices should be held too.
    pub edges: Vec<u32>,
    /// Per edge: its first material director at [`Pose::REST`] (unit).
    pub directors: Vec<DVec3>,
    /// Point about which the clamp turns, m.
    pub centre: DVec3,
    /// How it moves.
    pub motion: Motion,
}

/// The force of a clamp on the wood.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClampForce {
    /// Force, N.
    pub force: DVec3,
    /// Moment about the clamp's present centre, N m.
    pub moment: DVec3,
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().fold(DVec3::ZERO, |sum, p| sum + *p) / points.len().max(1) as f64
}

impl Clamp {
    /// Returns a clamp that holds vertices at their positions at rest and, where twist is on, the edges between them.
    pub fn new(bundle: &RodBundle, vertices: Vec<u32>, motion: Motion) -> Self {
        let index = |v: u32| ((v as usize) < bundle.vertices()).then_some(v as usize);
        let rest_positions: Vec<DVec3> = vertices
            .iter()
            .map(|&v| index(v).map_or(DVec3::ZERO, |v| bundle.rest.get(v)))
            .collect();
        let centre = mean(&rest_positions);
        let mut sorted = vertices.clone();
        sorted.sort_unstable();
        let edges: Vec<u32> = sorted
            .windows(2)
            .filter(|p| p[1] == p[0] + 1 && bundle.is_edge(p[0] as usize))
            .map(|p| p[0])
            .collect();
        let directors = edges
            .iter()
            .map(|&j| bundle.rest_director.get(j as usize))
            .collect();
        Clamp {
            vertices,
            rest_positions,
            axes: [true; 3],
            edges,
            directors,
            centre,
            motion,
        }
    }

    /// Returns the position of held vertex `i` at `time` (s), m.
    pub fn position(&self, i: usize, time: f64) -> DVec3 {
        let pose = self.motion.pose(time);
        self.centre + pose.rotation * (self.rest_positions[i] - self.centre) + pose.translation
    }

    /// Returns the material director of held edge `i` at `time` (s).
    pub fn director(&self, i: usize, time: f64) -> DVec3 {
        self.motion.pose(time).rotation * self.directors[i]
    }
}

/// The factor on a force or moment over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Ramp {
    /// 1 at all times.
    Constant,
    /// Linear from 0 at time 0 to 1 at this time (s), then constant.
    Linear(f64),
    /// Linear from 1 at time 0 to 0 at this time (s), then nothing.
    Falling(f64),
}

impl Ramp {
    /// Returns the factor at `time` (s).
    pub fn at(self, time: f64) -> f64 {
        match self {
            Ramp::Constant => 1.0,
            Ramp::Linear(duration) => (time / duration).clamp(0.0, 1.0),
            Ramp::Falling(duration) => (1.0 - time / duration).clamp(0.0, 1.0),
        }
    }
}

/// A force on a vertex, of constant direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PointForce {
    /// Vertex.
    pub vertex: u32,
    /// Force, N.
    pub force: DVec3,
    /// Factor over time.
    pub ramp: Ramp,
}

/// A moment on an edge, of constant direction. It acts as a couple of forces on the edge's vertices; its component along
/// the edge acts on the material frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Edge.
    pub edge: u32,
    /// Moment, N m.
    pub moment: DVec3,
    /// Factor over time.
    pub ramp: Ramp,
}

/// Wind drag on rods: ½ ρ c d |u⊥| u⊥ per length, u⊥ the velocity of the air relative to the rod, across the rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wind {
    /// Velocity of the air, m/s.
    pub velocity: DVec3,
    /// Density of the air, kg/m³.
    pub density: f64,
    /// Drag coefficient (about 1 for a cylinder).
    pub drag: f64,
    /// Width of a rod that the wind acts on, m. `None` takes the rod's diameter, which counts rods in the lee as well.
    pub width: Option<f64>,
    /// Factor on the velocity over time.
    pub ramp: Ramp,
}

/// All external loads on a bundle. The default is none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Acceleration of gravity, m/s².
    pub gravity: DVec3,
    /// Mass-proportional damping: force −c m v, moment −c J ω, with c in 1/s.
    pub damping: f64,
    /// Clamps; where two hold the same vertex the last one wins.
    pub clamps: Vec<Clamp>,
    /// Forces.
    pub forces: Vec<PointForce>,
    /// Moments.
    pub moments: Vec<Moment>,
    /// Wind.
    pub wind: Option<Wind>,
}

impl Loads {
    /// Checks all loads against a bundle.
    ///
    /// # Errors
    /// [`LoadError`] for the first load that does not fit.
    pub fn check(&self, bundle: &RodBundle) -> Result<(), LoadError> {
        let count = bundle.vertices();
        let vertex = |what, vertex: u32| {
            if (vertex as usize) < count {
                Ok(())
            } else {
                Err(LoadError::Vertex {
                    what,
                    vertex,
                    count,
                })
            }
        };
        let edge = |what, edge: u32| {
            if bundle.is_edge(edge as usize) {
                Ok(())
            } else {
                Err(LoadError::Edge { what, edge })
            }
        };
        let finite = |what, v: DVec3| {
            let value = if v.is_finite() {
                return Ok(());
            } else {
                v.x + v.y + v.z
            };
            Err(LoadError::Value {
                what,
                value,
                right: "finite",
            })
        };
        finite("gravity (m/s²)", self.gravity)?;
        let scalars = [("damping (1/s)", self.damping)];
        let wind = self.wind.iter().flat_map(|w| {
            [
                ("density of air (kg/m³)", w.density),
                ("drag coefficient", w.drag),
            ]
        });
        for (what, value) in scalars.into_iter().chain(wind) {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(LoadError::Value {
                    what,
                    value,
                    right: "0 or more and finite",
                });
            }
        }
        for (number, clamp) in self.clamps.iter().enumerate() {
            if clamp.vertices.is_empty() || clamp.rest_positions.len() != clamp.vertices.len() {
                return Err(LoadError::EmptyClamp { clamp: number });
            }
            clamp
                .vertices
                .iter()
                .try_for_each(|&v| vertex("a clamp", v))?;
            clamp.edges.iter().try_for_each(|&e| edge("a clamp", e))?;
        }
        for f in &self.forces {
            vertex("a force", f.vertex)?;
            finite("a force (N)", f.force)?;
        }
        for m in &self.moments {
            edge("a moment", m.edge)?;
            finite("a moment (N m)", m.moment)?;
        }
        Ok(())
    }

    /// Adds all loads but clamps and damping to the forces on vertices (N) and the moments on edges (N m).
    pub fn add_forces(
        &self,
        bundle: &RodBundle,
        time: f64,
        position: &Vectors,
        velocity: &Vectors,
        forces: &mut Forces,
    ) {
        let Forces { linear, moment } = forces;
        if self.gravity != DVec3::ZERO {
            for i in 0..bundle.vertices() {
                linear.add(i, self.gravity * bundle.mass[i]);
            }
        }
        for f in &self.forces {
            linear.add(f.vertex as usize, f.force * f.ramp.at(time));
        }
        for m in &self.moments {
            let j = m.edge as usize;
            let e = position.get(j + 1) - position.get(j);
            let applied = m.moment * m.ramp.at(time);
            let couple = applied.cross(e) / e.length_squared();
            linear.add(j + 1, couple);
            linear.add(j, -couple);
            moment[j] += applied.dot(e.normalize_or_zero());
        }
        if let Some(mut wind) = self.wind {
            wind.velocity *= wind.ramp.at(time);
            self.add_wind(bundle, wind, position, velocity, linear);
        }
    }

    fn add_wind(
        &self,
        bundle: &RodBundle,
        wind: Wind,
        position: &Vectors,
        velocity: &Vectors,
        forces: &mut Vectors,
    ) {
        for rod in 0..bundle.rods() {
            let width = wind.width.unwrap_or(bundle.diameter[rod]);
            for j in bundle.rod(rod).filter(|&j| bundle.is_edge(j)) {
                let e = position.get(j + 1) - position.get(j);
                let length = e.length();
                let own = 0.5 * (velocity.get(j) + velocity.get(j + 1));
                let across = (wind.velocity - own).reject_from(e);
                let force =
                    across * (0.5 * wind.density * wind.drag * width * length * across.length());
                if force.is_finite() {
                    forces.add(j, 0.5 * force);
                    forces.add(j + 1, 0.5 * force);
                }
            }
        }
    }
}
