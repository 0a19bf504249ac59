//! A rigid frame that follows several joints, by least squares.

use glam::{DMat3, DQuat, DVec3};
use greenstick_geometry::Pose;

/// Largest number of Newton steps that find the rotation. Near it each doubles the number of correct digits.
const MAX_NEWTON_STEPS: usize = 30;
/// Weight of the rods' rotation about themselves beside that of their positions and directions. A single rod has nothing
/// else that shows it; among several their positions do.
const TWIST_WEIGHT: f64 = 0.01;
/// A smaller rotation, rad, ends the Newton steps.
const MIN_ROTATION: f64 = 1e-15;

/// A frame that follows joints: the rigid movement nearest to theirs, by least squares of the positions of their origins and
/// of points on their tangents.
#[derive(Debug, Clone, PartialEq)]
pub struct Follower {
    joints: Vec<u32>,
    rest: Vec<Pose>,
    centre: DVec3,
    /// Distance of the points on the tangents from the joints, m.
    lever: f64,
}

impl Follower {
    /// Returns a frame that follows `joints` of a film whose joints rest at `rest`. `lever` is the distance at which the
    /// directions of joints count as positions, m.
    pub fn new(joints: Vec<u32>, rest: &[Pose], lever: f64) -> Self {
        let rest: Vec<Pose> = joints.iter().map(|&j| rest[j as usize]).collect();
        let mut follower = Follower {
            joints,
            rest,
            centre: DVec3::ZERO,
            lever,
        };
        follower.centre = follower.centroid(follower.rest.iter());
        follower
    }

    /// Returns the frame at rest.
    pub fn at_rest(&self) -> Pose {
        Pose {
            translation: self.centre,
            rotation: DQuat::IDENTITY,
        }
    }

    fn points(&self, pose: &Pose) -> [(DVec3, f64); 3] {
        let on_axis = |d: DVec3| pose.translation + pose.rotation * d * self.lever;
        [
            (pose.translation, 1.0),
            (on_axis(DVec3::Z), 1.0),
            (on_axis(DVec3::X), TWIST_WEIGHT),
        ]
    }

    fn centroid<'a>(&self, poses: impl Iterator<Item = &'a Pose>) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for (p, w) in poses.flat_map(|p| self.points(p)) {
            sum += p * w;
            weight += w;
        }
        sum / f64::max(weight, f64::MIN_POSITIVE)
    }

    /// Returns the frame where the film's joints have these poses.
    pub fn pose(&self, poses: &[Pose]) -> Pose {
        let now = || self.joints.iter().map(|&j| &poses[j as usize]);
        let centre = self.centroid(now());
        let mut rotation = self.mean_rotation(now());
        for _ in 0..MAX_NEWTON_STEPS {
            let (mut inertia, mut tangent) = (DMat3::ZERO, DMat3::ZERO);
            let mut moment = DVec3::ZERO;
            for (rest, pose) in self.rest.iter().zip(now()) {
                for ((p, w), (q, _)) in self.points(rest).into_iter().zip(self.points(pose)) {
                    let (p, q) = (rotation * (p - self.centre), q - centre);
                    let outer = DMat3::from_cols(p * p.x, p * p.y, p * p.z);
                    inertia += (DMat3::IDENTITY * p.length_squared() - outer) * w;
                    let outer = DMat3::from_cols(p * q.x, p * q.y, p * q.z);
                    tangent += (DMat3::from_diagonal(DVec3::splat(p.dot(q))) - outer) * w;
                    moment += p.cross(q) * w;
                }
            }
            // Far from the nearest movement the tangent may lead away from it; the inertia never does.
            let mut turn = tangent.inverse() * moment;
            if !turn.is_finite() || turn.dot(moment) <= 0.0 || turn.length() > 1.0 {
                turn = inertia.inverse() * moment;
            }
            if !turn.is_finite() || turn.length() < MIN_ROTATION {
                break;
            }
            let half = 0.5 * turn;
            let step = DQuat::from_xyzw(half.x, half.y, half.z, 1.0).normalize();
            rotation = (step * rotation).normalize();
        }
        Pose {
            translation: centre,
            rotation,
        }
    }

    /// Returns the mean of the joints' own rotations.
    fn mean_rotation<'a>(&self, poses: impl Iterator<Item = &'a Pose>) -> DQuat {
        let mut sum: Option<DQuat> = None;
        for (rest, pose) in self.rest.iter().zip(poses) {
            let turn = pose.rotation * rest.rotation.conjugate();
            sum = Some(match sum {
                Some(sum) if sum.dot(turn) < 0.0 => sum - turn,
                Some(sum) => sum + turn,
                None => turn,
            });
        }
        let sum = sum.unwrap_or(DQuat::IDENTITY);
        if sum.length_squared() > 1e-12 {
            sum.normalize()
        } else {
            DQuat::IDENTITY
        }
    }
}

/// Sets the poses of followers, which are behind those of the joints that they follow.
pub fn pose_followers(followers: &[Follower], poses: &mut [Pose]) {
    let (joints, behind) = poses.split_at_mut(poses.len() - followers.len());
    for (pose, follower) in behind.iter_mut().zip(followers) {
        *pose = follower.pose(joints);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rods() -> Vec<Pose> {
        let place = |x: f64, y: f64| Pose {
            translation: DVec3::new(x, y, 1.0),
            rotation: DQuat::from_rotation_z(x - y),
        };
        vec![place(0.0, 0.1), place(0.2, 0.0), place(-0.1, -0.2)]
    }

    #[test]
    fn rods_that_move_as_one_carry_exactly() {
        let rest = rods();
        let follower = Follower::new(vec![0, 1, 2], &rest, 0.1);
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.8);
        let shift = DVec3::new(3.0, -1.0, 0.5);
        let moved: Vec<Pose> = (rest.iter())
            .map(|p| Pose {
                translation: turn * p.translation + shift,
                rotation: turn * p.rotation,
            })
            .collect();
        let map = follower.pose(&moved).affine() * follower.at_rest().inverse();
        let p = DVec3::new(0.7, 5.0, -2.0);
        let off = map.transform_point3(p).distance(turn * p + shift);
        assert!(off < 1e-12, "{off}");
    }

    #[test]
    fn no_other_rigid_movement_is_nearer() {
        let rest = rods();
        let follower = Follower::new(vec![0, 1, 2], &rest, 0.1);
        let mut moved = rest.clone();
        for (k, pose) in moved.iter_mut().enumerate() {
            let turn = DQuat::from_axis_angle(DVec3::Y, 0.3 + 0.2 * k as f64);
            pose.rotation = turn * pose.rotation;
            pose.translation = turn * pose.translation + DVec3::X * (0.01 * k as f64);
        }
        let miss = |pose: Pose| {
            let map = pose.affine() * follower.at_rest().inverse();
            let pairs = rest.iter().zip(&moved);
            pairs
                .flat_map(|(a, b)| follower.points(a).into_iter().zip(follower.points(b)))
                .map(|((p, w), (q, _))| w * map.transform_point3(p).distance_squared(q))
                .sum::<f64>()
        };
        let best = follower.pose(&moved);
        let least = miss(best);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for by in [-1e-3, 1e-3] {
                let turned = Pose {
                    rotation: DQuat::from_axis_angle(axis, by) * best.rotation,
                    ..best
                };
                let shifted = Pose {
                    translation: best.translation + axis * by,
                    ..best
                };
                assert!(miss(turned) > least && miss(shifted) > least);
            }
        }
    }
}
