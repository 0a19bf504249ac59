//! Spiral grain about a break.

use crate::prepared::PreparedStem;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use std::f64::consts::TAU;

/// The length beyond the break over which grain still spirals, radii.
const SPIRAL_MARGIN: f64 = 0.5;

/// How far spiral grain turns from one level to the next, in widths of the outermost bundles. Between levels triangles are
/// straight and off the grain by turn² / 8 radii: here by less than a tenth of a bundle's width. Closer levels cost triangles, which
/// grow as their number, and what closely wound walls have in common with their neighbours is cut into more of them, all of which
/// cross.
const LEVEL_PER_BUNDLE: f64 = 2.5;
/// The least and the greatest turn from one level to the next, rad: closer ones gain nothing, farther ones look angular.
const TURNS_PER_LEVEL: (f64, f64) = (0.07, 0.35);

/// Grain that spirals along a part of a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpiralGrain {
    /// How fast it turns about the axis, rad per m.
    pub turn: f64,
    /// The lengths between which it does, m.
    pub between: (f64, f64),
    /// How far it turns from one level to the next at most, rad.
    pub per_level: f64,
}

impl SpiralGrain {
    /// Returns the grain of a break whose heights are in a range (m from its location): it spirals there and a little beyond.
    pub fn around(stem: &PreparedStem, p: &BreakParameters, (low, high): (f64, f64)) -> Self {
        let stem = &stem.found.stem;
        let margin = SPIRAL_MARGIN * stem.radius;
        SpiralGrain {
            turn: p.spiral_angle.to_radians() / stem.radius,
            between: (
                (stem.location + low - margin).max(stem.usable.0),
                (stem.location + high + margin).min(stem.usable.1),
            ),
            per_level: (LEVEL_PER_BUNDLE * TAU / f64::from(p.sectors))
                .clamp(TURNS_PER_LEVEL.0, TURNS_PER_LEVEL.1),
        }
    }
}

/// Whether a break requests spiral grain and the stem can have it: a fibrous face of a round stem.
pub fn has_spiral_grain(stem: &PreparedStem, p: &BreakParameters) -> bool {
    let round = !stem.found.stem.kind.is_sawn();
    p.spiral_angle != 0.0 && p.surface == SurfaceStyle::Fibrous && round
}
