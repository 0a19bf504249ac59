//! The state of bodies and of their contacts.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Position and motion of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Centre of mass of a free body, else the shape's origin, m.
    pub centre: DVec3,
    /// Orientation.
    pub rotation: DQuat,
    /// Velocity of the centre, m/s.
    pub velocity: DVec3,
    /// Angular momentum of a free body about its centre, kg m²/s.
    pub angular_momentum: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
}

/// Energy that contacts took and gave so far, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactLedger {
    /// Dissipated by friction and by collisions with a restitution below 1, less what pushing parts out of each other gave.
    pub dissipated: f64,
    /// Work of moved bodies on rods and free bodies.
    pub work: f64,
    /// Number of impulses applied.
    pub impulses: u64,
    /// Energy of overlaps, for solvers to which contacts are springs.
    pub stored: f64,
    /// Present power of moved bodies on these springs, W.
    pub power: f64,
}

/// What a checkpoint holds of bodies.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BodiesState {
    /// Position and motion of every body.
    pub bodies: Vec<BodyState>,
    /// The energy so far.
    pub ledger: ContactLedger,
}

/// What contacts have given a body over some time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BodyImpulse {
    /// Impulse, N s.
    pub linear: DVec3,
    /// Angular impulse about the body's centre, N m s.
    pub angular: DVec3,
}

/// The state to which contacts return where a step fails.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactsState {
    /// What a checkpoint holds.
    pub bodies: BodiesState,
    /// Per body: what it was given since the forces were last taken.
    pub impulses: Vec<BodyImpulse>,
}
