//! Two clamps that bend the wood between them without stretching or compressing it: its neutral axis keeps its length.
//!
//! Under a constant moment each piece of a slender stem turns in inverse proportion to its bending stiffness: a straight
//! prismatic stem becomes a circular arc, a tapered one bends more where it is thin, and a curved one adds its curvature at
//! rest. The positions of the clamps follow from their rotations.

use super::error::SceneError;
use super::keys::ClampKeys;
use crate::loads::{Clamp, Keyframe, Motion, Pose};
use crate::rod_bundle::RodBundle;
use crate::rotation::{from_rotation_vector, to_rotation_vector};
use crate::vectors::Vectors;
use glam::DVec3;
use std::f64::consts::TAU;

/// Pieces into which the stem between the clamps is divided.
const PIECES: usize = 200;
/// Largest angle by which the wood bends from one pose to the next, rad. Between two poses clamps move straight, which strains
/// the wood by a twenty-fourth of its square.
const MAX_POSE_ANGLE: f64 = 0.005;

/// A piece of the neutral axis.
struct Piece {
    /// From its start to its end, m.
    way: DVec3,
    /// Fraction of the whole turn up to its middle.
    turned: f64,
}

/// The neutral axis between two positions.
struct NeutralAxis {
    start: DVec3,
    end: DVec3,
    pieces: Vec<Piece>,
}

/// Where the neutral axis passes a cross-section.
struct NeutralPoint {
    position: DVec3,
    /// Bending stiffness of the cross-section: twice the mean of that about all axes, N m².
    stiffness: f64,
}

impl NeutralAxis {
    fn between(
        bundle: &RodBundle,
        position: &Vectors,
        fraction: &[f64],
        [from, to]: [f64; 2],
    ) -> NeutralAxis {
        let at = |k: usize| from + (to - from) * k as f64 / PIECES as f64;
        let points: Vec<NeutralPoint> = (0..=PIECES)
            .map(|k| neutral_point(bundle, position, fraction, at(k)))
            .collect();
        let mut pieces = Vec::with_capacity(PIECES);
        let mut turned = 0.0;
        for pair in points.windows(2) {
            let way = pair[1].position - pair[0].position;
            let stiffness = pair[0].stiffness + pair[1].stiffness;
            let turn = way.length() * 2.0 / stiffness.max(f64::MIN_POSITIVE);
            pieces.push(Piece {
                way,
                turned: turned + 0.5 * turn,
            });
            turned += turn;
        }
        let whole = turned.max(f64::MIN_POSITIVE);
        pieces.iter_mut().for_each(|p| p.turned /= whole);
        NeutralAxis {
            start: points[0].position,
            end: points[PIECES].position,
            pieces,
        }
    }
}

/// Finds where the neutral axis passes the cross-section at `at`.
fn neutral_point(
    bundle: &RodBundle,
    position: &Vectors,
    fraction: &[f64],
    at: f64,
) -> NeutralPoint {
    struct Crossing {
        position: DVec3,
        stretch: f64,
        bend: f64,
    }
    let mut crossings: Vec<Crossing> = Vec::with_capacity(bundle.rods());
    for rod in 0..bundle.rods() {
        let crossed =
            |&j: &usize| bundle.is_edge(j) && (at - fraction[j]) * (at - fraction[j + 1]) <= 0.0;
        if let Some(j) = bundle.rod(rod).find(crossed) {
            let part = (at - fraction[j]) / (fraction[j + 1] - fraction[j]);
            let part = if part.is_finite() { part } else { 0.0 };
            crossings.push(Crossing {
                position: position.get(j).lerp(position.get(j + 1), part),
                stretch: bundle.stretch[j],
                bend: bundle.bend[j].max(bundle.bend[j + 1]),
            });
        }
    }
    let stretch: f64 = crossings.iter().map(|c| c.stretch).sum();
    let sum = crossings
        .iter()
        .fold(DVec3::ZERO, |s, c| s + c.position * c.stretch);
    let middle = sum / stretch;
    let stiffness = crossings
        .iter()
        .map(|c| c.stretch * c.position.distance_squared(middle) + 2.0 * c.bend)
        .sum();
    NeutralPoint {
        position: middle,
        stiffness,
    }
}

/// Checks that the scene's clamps can use `arc`.
pub(super) fn check(clamps: &[ClampKeys]) -> Result<(), SceneError> {
    let Some(clamp) = clamps.iter().position(|c| c.arc) else {
        return Ok(());
    };
    let refuse = |problem: String| Err(SceneError::Arc { clamp, problem });
    if clamps.len() != 2 {
        return refuse(format!(
            "the scene must have two clamps, and it has {}",
            clamps.len()
        ));
    }
    if let Some(other) = clamps
        .iter()
        .position(|c| c.velocity != [0.0; 3] || c.angular != [0.0; 3])
    {
        return refuse(format!(
            "clamp {other} must be moved by key frames, not by a velocity"
        ));
    }
    if clamps.iter().all(|c| c.key.is_empty()) {
        return refuse("one of the clamps must have key frames that turn it".into());
    }
    Ok(())
}

/// Adds to the motion of clamps with `arc` what preserves the length of the neutral axis between them.
pub(super) fn preserve_length(
    clamps: &mut [Clamp],
    keys: &[ClampKeys],
    bundle: &RodBundle,
    position: &Vectors,
    fraction: &[f64],
) -> Result<(), SceneError> {
    let (Some(number), [one, two]) = (keys.iter().position(|k| k.arc), keys) else {
        return Ok(());
    };
    let [base, end] = if one.from <= two.from { [0, 1] } else { [1, 0] };
    // Rods leave a clamp at vertices, which are at different positions: their mean.
    let clamp_end = |clamp: &Clamp, last: bool| {
        let mut all = vec![false; bundle.vertices()];
        clamp.vertices.iter().for_each(|&v| all[v as usize] = true);
        let ends = clamp.vertices.iter().map(|&v| v as usize).filter(|v| {
            let next = if last { Some(v + 1) } else { v.checked_sub(1) };
            let edge = if last { Some(*v) } else { next };
            edge.is_some_and(|e| bundle.is_edge(e)) && next.is_some_and(|n| !all[n])
        });
        let (sum, count) = ends.fold((0.0, 0.0), |(s, n), v| (s + fraction[v], n + 1.0));
        sum / count
    };
    let range = [
        clamp_end(&clamps[base], true),
        clamp_end(&clamps[end], false),
    ];
    if range[0].is_nan() || range[1].is_nan() || range[0] >= range[1] {
        return Err(SceneError::Arc {
            clamp: number,
            problem: "no wood is free between the two clamps".into(),
        });
    }
    let axis = NeutralAxis::between(bundle, position, fraction, range);
    let mut motions: [Vec<Keyframe>; 2] = Default::default();
    let mut last = DVec3::ZERO;
    for time in times(clamps) {
        let poses = [base, end].map(|c| clamps[c].motion.pose(time));
        let place = |c: usize, pose: Pose, point: DVec3| {
            clamps[c].centre + pose.rotation * (point - clamps[c].centre) + pose.translation
        };
        let turn = nearest_equivalent(
            to_rotation_vector(poses[1].rotation * poses[0].rotation.conjugate()),
            last,
        );
        last = turn;
        let start = place(base, poses[0], axis.start);
        let arc = axis.pieces.iter().fold(start, |at, piece| {
            at + from_rotation_vector(turn * piece.turned) * (poses[0].rotation * piece.way)
        });
        let correction = arc - place(end, poses[1], axis.end);
        // Where both clamps follow, the middle between them stays.
        let shares = match (keys[base].arc, keys[end].arc) {
            (true, true) => [-0.5, 0.5],
            (true, false) => [-1.0, 0.0],
            _ => [0.0, 1.0],
        };
        for k in 0..2 {
            let mut pose = poses[k];
            pose.translation += correction * shares[k];
            motions[k].push(Keyframe { time, pose });
        }
    }
    for (clamp, keys) in [base, end].into_iter().zip(motions) {
        clamps[clamp].motion = Motion::Keyframes(keys);
    }
    Ok(())
}

/// Returns the times of all key frames, and as many between them as the rotations need.
fn times(clamps: &[Clamp]) -> Vec<f64> {
    let mut given: Vec<f64> = clamps
        .iter()
        .flat_map(|c| match &c.motion {
            Motion::Keyframes(keys) => keys.iter().map(|k| k.time).collect(),
            _ => Vec::new(),
        })
        .collect();
    given.sort_by(f64::total_cmp);
    given.dedup();
    let mut all = Vec::new();
    for pair in given.windows(2) {
        let turned: f64 = clamps
            .iter()
            .map(|c| {
                let [a, b] = [pair[0], pair[1]].map(|t| c.motion.pose(t).rotation);
                to_rotation_vector(b * a.conjugate()).length()
            })
            .sum();
        let parts = (turned / MAX_POSE_ANGLE).ceil().max(1.0);
        let mut k = 0.0;
        while k < parts {
            all.push(pair[0] + (pair[1] - pair[0]) * (k / parts));
            k += 1.0;
        }
    }
    all.extend(given.last());
    all
}

/// Returns the rotation vector that is equivalent to `turn` and nearest to `last`.
fn nearest_equivalent(turn: DVec3, last: DVec3) -> DVec3 {
    let angle = turn.length();
    if angle == 0.0 {
        return turn;
    }
    let round = turn * (TAU / angle);
    let times = ((last - turn).dot(round) / round.length_squared()).round();
    turn + round * times
}
