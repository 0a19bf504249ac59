//! Wood below dips of the skin, such as deep furrows of the bark.

use super::angle::wrap_angle;
use super::bundles::LayoutOptions;
use std::f64::consts::{PI, TAU};

/// How far below the bark wood gives way where the skin dips, in depths of the dip: farther in, bundles part at the edges of rings there too.
const GIVES_WAY: f64 = 1.4;

/// Returns where what has the ring coordinate `rho` elsewhere lies at an angle (rad), so that the bark begins below the dips of the skin.
pub(super) fn below_skin(options: &LayoutOptions, rho: f64, angle: f64) -> f64 {
    let values = &options.bark_below;
    let place = (wrap_angle(angle) + PI) / TAU * values.len() as f64 + values.len() as f64 - 0.5;
    let value = |k: usize| values.get((place as usize + k) % values.len().max(1));
    let below = value(0)
        .zip(value(1))
        .map(|(a, b)| a + (b - a) * place.fract());
    match (options.bark, below) {
        (Some(bark), Some(below)) if below < bark => {
            let dip = bark - below;
            let part = 1.0 - (bark - rho) / (GIVES_WAY * dip);
            rho - dip * part.clamp(0.0, 1.0)
        }
        _ => rho,
    }
}
