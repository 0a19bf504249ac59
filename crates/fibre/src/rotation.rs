//! Rotations as vectors: along the axis, as long as the angle.

use glam::{DQuat, DVec3};

/// Returns the rotation about a vector by its length (rad). The result has the same bits on every machine.
pub fn from_rotation_vector(v: DVec3) -> DQuat {
    let angle = v.length();
    if angle == 0.0 {
        return DQuat::IDENTITY;
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = v * (sin / angle);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

/// Returns the vector of a rotation, at most π long.
pub fn to_rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let axis = DVec3::new(q.x, q.y, q.z);
    let sin = axis.length();
    if sin == 0.0 {
        return DVec3::ZERO;
    }
    axis * (2.0 * libm::atan2(sin, q.w) / sin)
}
