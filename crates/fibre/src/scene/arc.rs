//! Two clamps that bend the wood between them and neither stretch nor press it: the wood's neutral line keeps its length.
//!
//! Under a moment that is the same all along, each piece of a slender stem turns by what its bending stiffness allows: a
//! straight stem of one section becomes a circular arc, one that tapers is bent more where it is thin, and what is curved
//! at rest keeps that curvature besides. Where the clamps are to be follows from how they are turned.

use super::{ClampKeys, SceneError};
use crate::bundle::Bundle;
use crate::loads::{Clamp, Motion, Pose, rotation_of, rotation_vector};
use crate::vectors::Vectors;
use glam::DVec3;
use std::f64::consts::TAU;

/// Pieces of the stem between the clamps.
const PIECES: usize = 200;
/// Most that the wood is bent from one pose to the next, rad. Between two poses clamps move straight, which strains the
/// wood by a twenty-fourth of its square.
const POSE: f64 = 0.005;

/// The neutral line between two places.
struct Line {
    start: DVec3,
    end: DVec3,
    /// Of each piece: the way along it, and what part of the whole turn it has turned by in its middle.
    pieces: Vec<(DVec3, f64)>,
}

impl Line {
    fn between(
        bundle: &Bundle,
        position: &Vectors,
        fraction: &[f64],
        (from, to): (f64, f64),
    ) -> Line {
        let at = |k: usize| from + (to - from) * k as f64 / PIECES as f64;
        let sections: Vec<(DVec3, f64)> = (0..=PIECES)
            .map(|k| section(bundle, position, fraction, at(k)))
            .collect();
        let mut pieces = Vec::with_capacity(PIECES);
        let mut turned = 0.0;
        for pair in sections.windows(2) {
            let way = pair[1].0 - pair[0].0;
            let turn = way.length() * 2.0 / (pair[0].1 + pair[1].1).max(f64::MIN_POSITIVE);
            pieces.push((way, turned + 0.5 * turn));
            turned += turn;
        }
        let whole = turned.max(f64::MIN_POSITIVE);
        pieces.iter_mut().for_each(|p| p.1 /= whole);
        Line {
            start: sections[0].0,
            end: sections[PIECES].0,
            pieces,
        }
    }
}

/// Where the neutral line passes a section, and the section's bending stiffness, the mean of that about all axes (twice it,
/// N m²).
fn section(bundle: &Bundle, position: &Vectors, fraction: &[f64], at: f64) -> (DVec3, f64) {
    let mut met = Vec::with_capacity(bundle.rods());
    for rod in 0..bundle.rods() {
        let crossed =
            |&j: &usize| bundle.is_edge(j) && (at - fraction[j]) * (at - fraction[j + 1]) <= 0.0;
        if let Some(j) = bundle.rod(rod).find(crossed) {
            let part = (at - fraction[j]) / (fraction[j + 1] - fraction[j]);
            let part = if part.is_finite() { part } else { 0.0 };
            let place = position.get(j).lerp(position.get(j + 1), part);
            met.push((
                place,
                bundle.stretch[j],
                bundle.bend[j].max(bundle.bend[j + 1]),
            ));
        }
    }
    let stretch: f64 = met.iter().map(|m| m.1).sum();
    let middle = met.iter().fold(DVec3::ZERO, |s, m| s + m.0 * m.1) / stretch;
    let stiffness = met
        .iter()
        .map(|(place, stretch, bend)| stretch * place.distance_squared(middle) + 2.0 * bend)
        .sum();
    (middle, stiffness)
}

/// Whether `arc` can be what the scene asks of its clamps.
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

/// Adds to the motion of clamps with `arc` what keeps the neutral line between them as long as it is.
pub(super) fn follow(
    clamps: &mut [Clamp],
    keys: &[ClampKeys],
    bundle: &Bundle,
    position: &Vectors,
    fraction: &[f64],
) -> Result<(), SceneError> {
    let (Some(number), [one, two]) = (keys.iter().position(|k| k.arc), keys) else {
        return Ok(());
    };
    let [base, end] = if one.from <= two.from { [0, 1] } else { [1, 0] };
    // Rods end a clamp at vertices, which are at different places: their mean.
    let held = |clamp: &Clamp, last: bool| {
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
    let range = (held(&clamps[base], true), held(&clamps[end], false));
    if range.0.is_nan() || range.1.is_nan() || range.0 >= range.1 {
        return Err(SceneError::Arc {
            clamp: number,
            problem: "no wood is left free between the two clamps".into(),
        });
    }
    let line = Line::between(bundle, position, fraction, range);
    let mut moved: [Vec<(f64, Pose)>; 2] = Default::default();
    let mut last = DVec3::ZERO;
    for time in times(clamps) {
        let poses = [base, end].map(|c| clamps[c].motion.pose(time));
        let place = |c: usize, pose: Pose, point: DVec3| {
            clamps[c].centre + pose.rotation * (point - clamps[c].centre) + pose.translation
        };
        let turn = nearest(
            rotation_of(poses[1].rotation * poses[0].rotation.conjugate()),
            last,
        );
        last = turn;
        let arc = line
            .pieces
            .iter()
            .fold(place(base, poses[0], line.start), |at, (way, part)| {
                at + rotation_vector(turn * *part) * (poses[0].rotation * *way)
            });
        let off = arc - place(end, poses[1], line.end);
        // Where both follow, the middle between them stays.
        let shares = match (keys[base].arc, keys[end].arc) {
            (true, true) => [-0.5, 0.5],
            (true, false) => [-1.0, 0.0],
            _ => [0.0, 1.0],
        };
        for k in 0..2 {
            let mut pose = poses[k];
            pose.translation += off * shares[k];
            moved[k].push((time, pose));
        }
    }
    for (clamp, poses) in [base, end].into_iter().zip(moved) {
        clamps[clamp].motion = Motion::Keys(poses);
    }
    Ok(())
}

/// The times of all key frames, and as many between as the turns need.
fn times(clamps: &[Clamp]) -> Vec<f64> {
    let mut given: Vec<f64> = clamps
        .iter()
        .flat_map(|c| match &c.motion {
            Motion::Keys(keys) => keys.iter().map(|k| k.0).collect(),
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
                rotation_of(b * a.conjugate()).length()
            })
            .sum();
        let parts = (turned / POSE).ceil().max(1.0);
        let mut k = 0.0;
        while k < parts {
            all.push(pair[0] + (pair[1] - pair[0]) * (k / parts));
            k += 1.0;
        }
    }
    all.extend(given.last());
    all
}

/// Of all vectors of the same rotation the one nearest to that before.
fn nearest(turn: DVec3, last: DVec3) -> DVec3 {
    let angle = turn.length();
    if angle == 0.0 {
        return turn;
    }
    let round = turn * (TAU / angle);
    let times = ((last - turn).dot(round) / round.length_squared()).round();
    turn + round * times
}
