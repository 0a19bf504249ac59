//! Moving the pieces of a break apart, as one would pull them: along the grain while their splinters lie between each other,
//! then straight on.

use crate::stages::BreakStages;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Points of the axis that a motion is fitted to.
const POINTS: usize = 33;

/// A rigid motion at a steady rate: how fast a point moves and how fast all turns about it, per metre of way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Twist {
    centre: DVec3,
    velocity: DVec3,
    /// Axis times angle, rad/m.
    turn: DVec3,
}

impl Twist {
    /// Returns the motion that moves these points most nearly in their directions (unit), by least squares. It does not turn
    /// points on a line about that line.
    fn along(points: &[(DVec3, DVec3)]) -> Twist {
        let count = points.len().max(1) as f64;
        let centre = points.iter().map(|p| p.0).sum::<DVec3>() / count;
        let velocity = points.iter().map(|p| p.1).sum::<DVec3>() / count;
        let (mut inertia, mut moment, mut spread) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for &(point, direction) in points {
            let r = point - centre;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia += DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer;
            moment += r.cross(direction);
            spread += r.length_squared();
        }
        let axis = velocity.normalize_or_zero();
        inertia += DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z) * spread;
        let turn = if spread > 0.0 {
            inertia.inverse() * moment
        } else {
            DVec3::ZERO
        };
        Twist {
            centre,
            velocity,
            turn,
        }
    }

    /// Returns where the motion takes everything over a way (m): the exponential of the twist (Murray, Li and Sastry 1994, *A
    /// Mathematical Introduction to Robotic Manipulation*, Eq. 2.36).
    fn after(&self, way: f64) -> DAffine3 {
        let turn = self.turn * way;
        let angle = turn.length();
        let rotation = DQuat::from_scaled_axis(turn);
        let straight = self.velocity * way;
        let moved = if angle < 1e-9 {
            straight
        } else {
            let axis = turn / angle;
            let across = axis.cross(straight);
            let (sin, cos) = libm::sincos(angle);
            straight + across * ((1.0 - cos) / angle) + axis.cross(across) * (1.0 - sin / angle)
        };
        DAffine3::from_translation(self.centre + moved)
            * DAffine3::from_quat(rotation)
            * DAffine3::from_translation(-self.centre)
    }
}

/// Returns the motion of the upper piece by a distance (m): along the axis as it is bent within the face, until the face is
/// clear, then straight.
pub(super) fn parting(stages: &BreakStages, distance: f64) -> DAffine3 {
    let stem = &stages.stem.stem().found.stem;
    let axis = stem.grain.axis();
    let (low, high) = stages.heights.heights.range;
    let (low, high) = (stem.location + low, stem.location + high);
    let along: Vec<(DVec3, DVec3)> = (0..POINTS)
        .map(|i| {
            let frame = axis.frame(low + (high - low) * i as f64 / (POINTS - 1) as f64);
            (frame.origin, frame.tangent)
        })
        .collect();
    let within = distance.min(high - low);
    let bent = Twist::along(&along).after(within);
    let onward = bent.transform_vector3(axis.frame(high).tangent);
    DAffine3::from_translation(onward * (distance - within)) * bent
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn arc(radius: f64, upto: f64) -> Vec<(DVec3, DVec3)> {
        let point = |i: i32| {
            let (sin, cos) = libm::sincos(upto * f64::from(i) / 20.0);
            (
                DVec3::new(cos, 0.0, sin) * radius,
                DVec3::new(-sin, 0.0, cos),
            )
        };
        (0..=20).map(point).collect()
    }

    #[test]
    fn wood_that_is_bent_to_an_arc_slides_along_it() {
        let points = arc(0.7, FRAC_PI_4);
        let moved = Twist::along(&points).after(0.3);
        for (point, _) in points {
            let to = moved.transform_point3(point);
            assert!((to.length() - 0.7).abs() < 1e-9, "{to}");
            assert!((to.angle_between(point) * 0.7 - 0.3).abs() < 1e-9);
        }
    }

    #[test]
    fn straight_wood_is_pulled_straight() {
        let points: Vec<(DVec3, DVec3)> = (0..9)
            .map(|i| (DVec3::new(0.1, 0.2, f64::from(i)), DVec3::Z))
            .collect();
        let moved = Twist::along(&points).after(0.3);
        assert!(moved.abs_diff_eq(DAffine3::from_translation(DVec3::Z * 0.3), 1e-15));
        let one = Twist::along(&points[..1]).after(0.3);
        assert!(one.abs_diff_eq(DAffine3::from_translation(DVec3::Z * 0.3), 1e-15));
    }
}
