//! The bundle at the start: in the scene's axes, and bent.

use crate::rod_bundle::RodBundle;
use crate::rotation::from_rotation_vector;
use crate::state::State;
use crate::vectors::Vectors;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Rotates and moves a bundle at rest so that the middle of its base is the origin and the middle of its other end is on +x;
/// z stays as close to `up` as possible. `fraction` is each vertex's position along the stem. Returns its length, m, and the map
/// from its coordinates before to those of the scene.
pub(super) fn align_with_axes(
    bundle: &mut RodBundle,
    fraction: &[f64],
    up: DVec3,
) -> (f64, DAffine3) {
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
    let upright = x.dot(up).abs() >= 0.9;
    let up = match (upright, up == DVec3::Z) {
        (false, _) => up,
        (true, true) => DVec3::X,
        (true, false) => DVec3::Z,
    };
    let z = up.reject_from_normalized(x).normalize();
    let turn = DMat3::from_cols(x, z.cross(x), z).transpose();
    let all = |v: &Vectors, f: &dyn Fn(DVec3) -> DVec3| v.iter().map(f).collect::<Vectors>();
    bundle.rest = all(&bundle.rest, &|p| turn * (p - base));
    bundle.rest_director = all(&bundle.rest_director, &|d| turn * d);
    let map = DAffine3::from_mat3(turn) * DAffine3::from_translation(-base);
    (base.distance(end), map)
}

/// Returns the directions of a scene's loads for a stem whose scene has the vertical `up`: the columns are what x, y and z of a
/// level stem become. y stays as level as possible.
pub(super) fn level_frame(up: DVec3) -> DMat3 {
    let y = DVec3::Y.reject_from_normalized(up).normalize();
    DMat3::from_cols(y.cross(up), y, up)
}

/// Bends a bundle of a given length (m) into an arc of `angle` rad about y, with its middle fixed and its ends upwards.
pub(super) fn bend(bundle: &RodBundle, state: &mut State, length: f64, angle: f64) {
    if angle == 0.0 {
        return;
    }
    // In small steps, so that frames can be transported.
    const STEPS: u32 = 32;
    for part in 1..=STEPS {
        let radius = length / (angle * f64::from(part) / f64::from(STEPS));
        for i in 0..bundle.vertices() {
            let p = bundle.rest.get(i);
            let (sin, cos) = libm::sincos((p.x - 0.5 * length) / radius);
            let position = DVec3::new(
                0.5 * length + (radius - p.z) * sin,
                p.y,
                radius - (radius - p.z) * cos,
            );
            state.position.set(i, position);
        }
        state.transport_frames(bundle);
    }
}

/// Returns the rotation of a rotation vector in degrees.
pub(super) fn rotation(degrees: [f64; 3]) -> DQuat {
    from_rotation_vector(DVec3::from_array(degrees.map(f64::to_radians)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_of_a_stem_at_an_angle_pulls_along_it_by_the_sine() {
        for degrees in [-90.0f64, -20.0, 0.0, 35.0, 90.0] {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let frame = level_frame(DVec3::new(sin, 0.0, cos));
            let gravity = frame * DVec3::new(0.0, 0.0, -10.0);
            assert!((gravity - DVec3::new(-10.0 * sin, 0.0, -10.0 * cos)).length() < 1e-12);
            assert!((frame * DVec3::Y - DVec3::Y).length() < 1e-12);
            assert!((frame.determinant() - 1.0).abs() < 1e-12);
        }
        assert_eq!(level_frame(DVec3::Z), DMat3::IDENTITY);
    }
}
