//! What acts on a bundle from outside: clamps, forces, moments, gravity, damping, wind and snow.

use crate::bundle::Bundle;
use crate::error::LoadError;
use crate::vectors::Vectors;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A place and an orientation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Displacement, m.
    pub translation: DVec3,
    /// Rotation about the clamp's centre.
    pub rotation: DQuat,
}

impl Pose {
    /// Nothing moved.
    pub const REST: Pose = Pose {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
    };
}

/// How a clamp moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// With constant velocity (m/s) and angular velocity (rad/s) from time 0.
    Steady {
        /// Velocity, m/s.
        velocity: DVec3,
        /// Angular velocity about the clamp's centre, rad/s.
        angular: DVec3,
    },
    /// Through poses at given times (s, ascending), straight and evenly between them, at rest before and after.
    Keys(Vec<(f64, Pose)>),
}

impl Motion {
    /// The pose at a time, s.
    pub fn pose(&self, time: f64) -> Pose {
        match self {
            Motion::Fixed => Pose::REST,
            Motion::Steady { velocity, angular } => Pose {
                translation: *velocity * time,
                rotation: rotation_vector(*angular * time),
            },
            Motion::Keys(keys) => {
                let k = keys.partition_point(|(t, _)| *t <= time);
                match (k.checked_sub(1).map(|i| keys[i]), keys.get(k)) {
                    (Some((a, p)), Some(&(b, q))) => {
                        let f = (time - a) / (b - a);
                        let turn = q.rotation * p.rotation.conjugate();
                        Pose {
                            translation: p.translation.lerp(q.translation, f),
                            rotation: rotation_vector(rotation_of(turn) * f) * p.rotation,
                        }
                    }
                    (Some((_, p)), None) => p,
                    (None, Some(&(_, q))) => q,
                    (None, None) => Pose::REST,
                }
            }
        }
    }
}

/// The rotation by a vector's length (rad) about it, with the same bits on every machine.
pub fn rotation_vector(v: DVec3) -> DQuat {
    let angle = v.length();
    if angle == 0.0 {
        return DQuat::IDENTITY;
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = v * (sin / angle);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

/// The vector of a rotation, of a length up to π.
pub fn rotation_of(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let axis = DVec3::new(q.x, q.y, q.z);
    let sin = axis.length();
    if sin == 0.0 {
        return DVec3::ZERO;
    }
    axis * (2.0 * libm::atan2(sin, q.w) / sin)
}

/// Vertices, and the turn of edges, that are held or moved whatever acts on them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Clamp {
    /// Vertices held. Two next to each other hold the rod's direction too.
    pub vertices: Vec<u32>,
    /// Where they are at the pose [`Pose::REST`], m; as many as vertices.
    pub held: Vec<DVec3>,
    /// Which directions of each vertex are held; all three for a grip, one for a sliding support.
    pub axes: [bool; 3],
    /// Edges whose material frame turns with the clamp; used where twist is on. Their vertices should be held too.
    pub edges: Vec<u32>,
    /// First material directors of those edges at [`Pose::REST`] (unit).
    pub directors: Vec<DVec3>,
    /// Point that it turns about, m.
    pub centre: DVec3,
    /// How it moves.
    pub motion: Motion,
}

impl Clamp {
    /// A clamp that holds vertices where they are at rest and, where twist is on, the edges between them.
    pub fn of(bundle: &Bundle, vertices: Vec<u32>, motion: Motion) -> Self {
        let known = |v: u32| ((v as usize) < bundle.vertices()).then_some(v as usize);
        let held: Vec<DVec3> = vertices
            .iter()
            .map(|&v| known(v).map_or(DVec3::ZERO, |v| bundle.rest.get(v)))
            .collect();
        let centre = held.iter().fold(DVec3::ZERO, |a, p| a + *p) / held.len().max(1) as f64;
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
            held,
            axes: [true; 3],
            edges,
            directors,
            centre,
            motion,
        }
    }

    /// Where held vertex `i` is to be at a time (s), m.
    pub fn place(&self, i: usize, time: f64) -> DVec3 {
        let pose = self.motion.pose(time);
        self.centre + pose.rotation * (self.held[i] - self.centre) + pose.translation
    }

    /// Where the material director of held edge `i` is to point at a time (s).
    pub fn director(&self, i: usize, time: f64) -> DVec3 {
        self.motion.pose(time).rotation * self.directors[i]
    }
}

/// How a force or moment changes with time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Ramp {
    /// The same at all times.
    Constant,
    /// From 0 at time 0 evenly to its value at this time (s), constant after.
    Rise(f64),
}

impl Ramp {
    /// The factor at a time, s.
    pub fn at(self, time: f64) -> f64 {
        match self {
            Ramp::Constant => 1.0,
            Ramp::Rise(duration) => (time / duration).clamp(0.0, 1.0),
        }
    }
}

/// A force on a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PointForce {
    /// Vertex.
    pub vertex: u32,
    /// Force, N, of constant direction.
    pub force: DVec3,
    /// How it changes.
    pub ramp: Ramp,
}

/// A moment on an edge: a couple of forces on its vertices, and what is along the edge turns its frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Edge.
    pub edge: u32,
    /// Moment, N m, of constant direction.
    pub moment: DVec3,
    /// How it changes.
    pub ramp: Ramp,
}

/// Drag of moving air on rods: ½ ρ c d |u⊥| u⊥ per length, u⊥ the wind relative to the rod across it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wind {
    /// Velocity of the air, m/s.
    pub velocity: DVec3,
    /// Density of the air, kg/m³.
    pub density: f64,
    /// Drag coefficient (about 1 for a cylinder).
    pub drag: f64,
    /// Width that the wind sees, per rod, m: `None` for the rod's diameter, which for a bundle counts rods in the lee.
    pub width: Option<f64>,
}

/// Everything that acts on a bundle from outside. The default is nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Acceleration of gravity, m/s².
    pub gravity: DVec3,
    /// Damping in proportion to mass: force −c m v, moment −c J ω, with c in 1/s.
    pub damping: f64,
    /// Clamps; where two hold one vertex the last wins.
    pub clamps: Vec<Clamp>,
    /// Forces.
    pub forces: Vec<PointForce>,
    /// Moments.
    pub moments: Vec<Moment>,
    /// Wind.
    pub wind: Option<Wind>,
    /// Snow: weight per length of each rod (N/m) along gravity, or along −z without gravity.
    pub snow: f64,
}

impl Loads {
    /// Checks all against a bundle.
    ///
    /// # Errors
    /// [`LoadError`] for the first that does not fit.
    pub fn check(&self, bundle: &Bundle) -> Result<(), LoadError> {
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
        let scalars = [
            ("damping (1/s)", self.damping),
            ("snow load (N/m)", self.snow),
        ];
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
            if clamp.vertices.is_empty() || clamp.held.len() != clamp.vertices.len() {
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

    /// Adds everything but clamps and damping to forces (N) on vertices and moments (N m) on edges.
    pub fn add_forces(
        &self,
        bundle: &Bundle,
        time: f64,
        position: &Vectors,
        velocity: &Vectors,
        forces: &mut Vectors,
        moments: &mut [f64],
    ) {
        if self.gravity != DVec3::ZERO {
            for i in 0..bundle.vertices() {
                forces.add(i, self.gravity * bundle.mass[i]);
            }
        }
        if self.snow > 0.0 {
            let down = self.gravity.try_normalize().unwrap_or(DVec3::NEG_Z);
            for i in 0..bundle.vertices() {
                forces.add(i, down * (0.5 * self.snow * bundle.both_lengths(i)));
            }
        }
        for f in &self.forces {
            forces.add(f.vertex as usize, f.force * f.ramp.at(time));
        }
        for m in &self.moments {
            let j = m.edge as usize;
            let e = position.get(j + 1) - position.get(j);
            let moment = m.moment * m.ramp.at(time);
            let couple = moment.cross(e) / e.length_squared();
            forces.add(j + 1, couple);
            forces.add(j, -couple);
            moments[j] += moment.dot(e.normalize_or_zero());
        }
        if let Some(wind) = self.wind {
            self.add_wind(bundle, wind, position, velocity, forces);
        }
    }

    fn add_wind(
        &self,
        bundle: &Bundle,
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
