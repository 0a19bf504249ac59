//! The bundle in the scene's axes, and how it is bent and moves at the start.

use crate::bundle::Bundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Turns and moves a bundle at rest so that the middle of its base is the origin, the middle of its other end is on +x,
/// and what was most upright stays so. `fraction` is each vertex's place along the stem. Returns its length, m, and the
/// movement.
pub(super) fn lay(bundle: &mut Bundle, fraction: &[f64]) -> (f64, DAffine3) {
    let middle = |end: f64| {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for rod in 0..bundle.rods() {
            let nearest = bundle.rod(rod).min_by(|&a, &b| {
                (fraction[a] - end)
                    .abs()
                    .total_cmp(&(fraction[b] - end).abs())
            });
            if let Some(v) = nearest {
                sum += bundle.rest.get(v);
                count += 1.0;
            }
        }
        sum / f64::max(count, 1.0)
    };
    let (base, end) = (middle(0.0), middle(1.0));
    let x = (end - base).normalize_or(DVec3::X);
    let up = if x.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
    let z = up.reject_from_normalized(x).normalize();
    let turn = DMat3::from_cols(x, z.cross(x), z).transpose();
    let all = |v: &Vectors, f: &dyn Fn(DVec3) -> DVec3| v.iter().map(f).collect::<Vectors>();
    bundle.rest = all(&bundle.rest, &|p| turn * (p - base));
    bundle.rest_director = all(&bundle.rest_director, &|d| turn * d);
    let moved = DAffine3::from_mat3(turn) * DAffine3::from_translation(-base);
    (base.distance(end), moved)
}

/// Bends a bundle of some length into an arc of `angle` rad about y, its middle where it is, its ends upwards.
pub(super) fn bend(bundle: &Bundle, state: &mut State, length: f64, angle: f64) {
    if angle == 0.0 {
        return;
    }
    // In small turns, so that frames are carried along.
    const TURNS: u32 = 32;
    for part in 1..=TURNS {
        let radius = length / (angle * f64::from(part) / f64::from(TURNS));
        for i in 0..bundle.vertices() {
            let p = bundle.rest.get(i);
            let (sin, cos) = libm::sincos((p.x - 0.5 * length) / radius);
            let place = DVec3::new(
                0.5 * length + (radius - p.z) * sin,
                p.y,
                radius - (radius - p.z) * cos,
            );
            state.position.set(i, place);
        }
        state.carry_frames(bundle);
    }
}

/// The rotation along a vector as long as its angle in degrees.
pub(super) fn turn(degrees: [f64; 3]) -> DQuat {
    crate::loads::rotation_vector(DVec3::from_array(degrees.map(f64::to_radians)))
}
