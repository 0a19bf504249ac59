//! The joints of a film of drawn faces, and where they are.

use crate::remainder::Follower;
use glam::{DAffine3, DQuat, DVec3};
use greenstick_geometry::{Joint, Pose};
use std::ops::Range;

/// Pieces that reach into each other keep together sideways while they would be no farther apart than the first of these lengths (radii)
/// anywhere, and are free from the second on.
const ASIDE: (f64, f64) = (1.0, 2.0);

/// What a joint follows.
#[derive(Debug, Clone)]
pub(super) struct SectionJoint {
    pub name: String,
    /// Where it is at rest.
    pub rest: Pose,
    /// The follower of all rods of the section, before the face beside it begins to open.
    pub whole: usize,
    /// The first frame in which that has begun.
    pub until: u32,
    /// The follower of the rods of its own.
    pub own: usize,
    /// The joints of its piece about it, with the weights of a mean of their motions, which then is its own: followers of few rods turn
    /// as those do, and wood as thick as they are far apart cannot.
    pub about: Vec<(u32, f64)>,
}

/// Two pieces that reach into each other beside a face. While they do, splinters slide along the beds that they were torn out of,
/// and bend with them: each fibre by itself, so that sections stay plane and the face opens as it would.
#[derive(Debug, Clone)]
pub(super) struct Interlock {
    /// The joints of the lower and the upper piece at the first section beside the face; those of further sections follow.
    pub joints: [u32; 2],
    /// How much the wood of each section moves sideways with the upper piece, 0 to 1.
    pub shares: Vec<f64>,
    /// The sections, counted from the first, in which the wood of both pieces is about as much.
    pub core: Range<usize>,
    /// The direction along the grain at rest.
    pub along: DVec3,
    /// How far they reach into each other, m.
    pub length: f64,
    /// Radius of the stem, m.
    pub radius: f64,
}

/// Joints along the pieces of a film.
///
/// Until the first rod breaks in a face, the joints on both sides follow all rods: both sides then coincide exactly, in every
/// format.
#[derive(Debug, Clone, Default)]
pub(in crate::film) struct SectionJoints {
    pub(super) followers: Vec<Follower>,
    pub(super) joints: Vec<SectionJoint>,
    pub(super) interlocks: Vec<Interlock>,
    /// Those of the joints that the film has, by number.
    shown: Vec<u32>,
}

impl SectionJoints {
    /// Leaves out of the film all joints but `used`, which are ascending.
    pub fn show_only(&mut self, used: Vec<u32>) {
        self.shown = used;
    }

    /// The joints of a film.
    pub fn film_joints(&self) -> impl Iterator<Item = Joint> + '_ {
        self.shown.iter().map(|&joint| {
            let joint = &self.joints[joint as usize];
            Joint {
                name: joint.name.clone(),
                rest: joint.rest,
            }
        })
    }

    /// Returns the poses of the joints in a frame of the film in which the joints of the rods have the poses `rods`.
    pub fn poses(&self, frame: usize, rods: &[Pose]) -> impl Iterator<Item = Pose> + '_ {
        let mut known: Vec<Option<DAffine3>> = vec![None; self.followers.len()];
        let maps = self.joints.iter().map(|joint| {
            let number = joint.follower(frame);
            *known[number].get_or_insert_with(|| {
                let follower = &self.followers[number];
                follower.pose(rods).affine() * follower.at_rest().inverse()
            })
        });
        let maps: Vec<DAffine3> = maps.collect();
        let mut maps: Vec<DAffine3> = (self.joints.iter().zip(&maps))
            .map(|(joint, &map)| {
                let own = joint.about.iter();
                let own = own.filter(|(n, _)| self.joints[*n as usize].is_own(frame));
                let about = own.map(|&(n, weight)| (maps[n as usize], weight));
                match joint.is_own(frame) {
                    true => mean_motion(joint.rest.translation, about).unwrap_or(map),
                    false => map,
                }
            })
            .collect();
        for interlock in &self.interlocks {
            interlock.hold(&self.joints, &mut maps);
        }
        self.shown.iter().map(move |&number| {
            let joint = &self.joints[number as usize];
            let map = maps[number as usize];
            Pose {
                translation: map.transform_point3(joint.rest.translation),
                rotation: (DQuat::from_mat3(&map.matrix3) * joint.rest.rotation).normalize(),
            }
        })
    }
}

impl SectionJoint {
    fn follower(&self, frame: usize) -> usize {
        if self.is_own(frame) {
            self.own
        } else {
            self.whole
        }
    }

    /// Whether it follows the rods of its own in a frame.
    fn is_own(&self, frame: usize) -> bool {
        frame >= self.until as usize
    }
}

impl Interlock {
    /// Moves both pieces to what they have in common.
    fn hold(&self, joints: &[SectionJoint], maps: &mut [DAffine3]) {
        let pair = |k: usize| self.joints.map(|first| first as usize + k);
        // For each section the way from the lower piece to the upper one, along the grain and aside.
        let ways: Vec<(f64, DVec3)> = (0..self.shares.len())
            .map(|k| {
                let [lower, upper] = pair(k);
                let at = joints[lower].rest.translation;
                let way = maps[upper].transform_point3(at) - maps[lower].transform_point3(at);
                let both = maps[lower].matrix3 + maps[upper].matrix3;
                let along = (both * self.along).normalize_or(self.along);
                let drawn = way.dot(along);
                (drawn, way - along * drawn)
            })
            .collect();
        let core = &ways[self.core.clone()];
        let drawn = core.iter().map(|w| w.0).fold(f64::INFINITY, f64::min);
        let aside = core.iter().map(|w| w.1.length()).fold(0.0, f64::max);
        let inside = smooth(1.0 - drawn.max(0.0) / self.length.max(f64::MIN_POSITIVE));
        let held = inside * smooth((ASIDE.1 - aside / self.radius) / (ASIDE.1 - ASIDE.0));
        if held <= 0.0 {
            return;
        }
        for (k, (share, (_, aside))) in self.shares.iter().zip(ways).enumerate() {
            let [lower, upper] = pair(k);
            maps[lower].translation += aside * (held * share);
            maps[upper].translation -= aside * (held * (1.0 - share));
        }
    }
}

/// The mean of rigid motions at a point, if there is any: where they take it, and how they turn.
fn mean_motion(at: DVec3, motions: impl Iterator<Item = (DAffine3, f64)>) -> Option<DAffine3> {
    let (mut place, mut turn, mut total) = (DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), 0.0);
    for (map, weight) in motions {
        place += map.transform_point3(at) * weight;
        let one = DQuat::from_mat3(&map.matrix3);
        let same_side = if turn.dot(one) < 0.0 { -weight } else { weight };
        turn += one * same_side;
        total += weight;
    }
    if total <= 0.0 || turn.length_squared() < 1e-12 * total * total {
        return None;
    }
    let turn = DAffine3::from_quat(turn.normalize());
    let way = place / total - turn.transform_point3(at);
    Some(DAffine3::from_translation(way) * turn)
}

/// A smooth step from 0 to 1.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECTIONS: usize = 9;

    /// Two pieces along x with sections a centimetre apart, which reach into each other from the third to the seventh.
    fn joints() -> (Vec<SectionJoint>, Interlock) {
        let joint = |k: usize| SectionJoint {
            name: String::new(),
            rest: Pose {
                translation: DVec3::X * (0.01 * (k % SECTIONS) as f64),
                ..Pose::IDENTITY
            },
            whole: 0,
            until: 0,
            own: 0,
            about: Vec::new(),
        };
        let interlock = Interlock {
            joints: [0, SECTIONS as u32],
            shares: (0..SECTIONS)
                .map(|k| smooth((k as f64 - 2.0) / 4.0))
                .collect(),
            core: 2..7,
            along: DVec3::X,
            length: 0.04,
            radius: 0.01,
        };
        ((0..2 * SECTIONS).map(joint).collect(), interlock)
    }

    /// The places of the sections of both pieces when the upper one has moved.
    fn places(upper: DAffine3) -> (Vec<DVec3>, Vec<DVec3>) {
        let (joints, interlock) = joints();
        let mut maps = vec![DAffine3::IDENTITY; SECTIONS];
        maps.extend(vec![upper; SECTIONS]);
        interlock.hold(&joints, &mut maps);
        let places = joints.iter().zip(&maps);
        let mut places = places.map(|(joint, map)| map.transform_point3(joint.rest.translation));
        (places.by_ref().take(SECTIONS).collect(), places.collect())
    }

    #[test]
    fn pieces_that_reach_into_each_other_keep_together_sideways_and_bend_smoothly() {
        // By 0.2 about a hinge a radius below the axis, in the middle.
        let hinge = DVec3::new(0.04, 0.0, -0.01);
        let turn = DAffine3::from_rotation_y(0.2);
        let upper = DAffine3::from_translation(hinge) * turn * DAffine3::from_translation(-hinge);
        let (lower, moved) = places(upper);
        let rigid = |k: usize| upper.transform_point3(DVec3::X * (0.01 * k as f64));
        for k in 0..SECTIONS {
            // Splinters are where the other piece is, but for a share of the way: they are drawn out by a twentieth.
            let way = moved[k] - lower[k];
            let along = DVec3::new(0.1_f64.cos(), 0.0, -(0.1_f64.sin()));
            let aside = way - along * way.dot(along);
            let way_of_rigid = rigid(k) - DVec3::X * (0.01 * k as f64);
            // The face opens as it would, by 0.2 times the distance from the hinge.
            let opened = way_of_rigid.dot(along);
            let rigid_aside = way_of_rigid - along * opened;
            let most = 0.01 * rigid_aside.length() + 1e-12;
            assert!(aside.length() < most, "{k}: {aside} of {rigid_aside}");
            assert!((way.dot(along) - opened).abs() < 1e-12);
            assert!((opened - 0.002).abs() < 5e-5, "{k}: {opened}");
        }
        // Each is itself away from the face.
        assert!(lower[..3].iter().all(|p| p.z == 0.0));
        assert!((6..SECTIONS).all(|k| moved[k].distance(rigid(k)) < 1e-12));
        // Both give way between, by no more than a twentieth of the radius past either.
        assert!(lower.iter().all(|p| p.z < 5e-4), "{lower:?}");
    }

    #[test]
    fn the_mean_of_a_motion_is_that_motion_and_of_turns_the_one_between() {
        let about = DVec3::new(0.3, -0.2, 0.1);
        let turn = |angle: f64| {
            DAffine3::from_translation(about)
                * DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle)
                * DAffine3::from_translation(-about)
        };
        let mean = |angles: &[(f64, f64)]| {
            let motions = angles.iter().map(|&(angle, weight)| (turn(angle), weight));
            mean_motion(DVec3::X, motions)
        };
        let same = mean(&[(2.0, 0.3), (2.0, 1.7), (2.0, 0.1)]).unwrap();
        assert!(same.abs_diff_eq(turn(2.0), 1e-14));
        let between = mean(&[(0.9, 1.0), (1.1, 1.0)]).unwrap();
        assert!(between.matrix3.abs_diff_eq(turn(1.0).matrix3, 1e-14));
        let [one, other] = [0.9, 1.1].map(|angle| turn(angle).transform_point3(DVec3::X));
        let place = between.transform_point3(DVec3::X);
        assert!(place.distance((one + other) / 2.0) < 1e-15);
        assert_eq!(mean(&[]), None);
        assert_eq!(mean(&[(1.0, 0.0)]), None);
    }

    #[test]
    fn pieces_that_are_drawn_apart_or_aside_move_by_themselves() {
        for by in [DVec3::X * 0.041, DVec3::Z * 0.021] {
            let (lower, upper) = places(DAffine3::from_translation(by));
            for k in 0..SECTIONS {
                let at = DVec3::X * (0.01 * k as f64);
                assert!(lower[k] == at && upper[k].distance(at + by) < 1e-15);
            }
        }
    }
}
