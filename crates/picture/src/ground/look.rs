//! What a ground looks like at one place.

use glam::{Vec2, Vec3};

/// What the ground looks like at a place.
pub(crate) struct GroundSurface {
    /// Linear reflectance.
    pub color: Vec3,
    /// Rise of its relief along the axes of the pattern, m per m.
    pub slope: Vec2,
}
