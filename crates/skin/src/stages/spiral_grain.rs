//! Spiral grain about a break.

use crate::prepared::PreparedStem;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};

/// The length beyond the break over which grain still spirals, radii.
const SPIRAL_MARGIN: f64 = 0.5;

/// Grain that spirals along a part of a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpiralGrain {
    /// How fast it turns about the axis, rad per m.
    pub turn: f64,
    /// The lengths between which it does, m.
    pub between: (f64, f64),
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
        }
    }
}

/// Whether a break requests spiral grain and the stem can have it: a fibrous face of a round stem.
pub fn has_spiral_grain(stem: &PreparedStem, p: &BreakParameters) -> bool {
    let round = !stem.found.stem.kind.is_sawn();
    p.spiral_angle != 0.0 && p.surface == SurfaceStyle::Fibrous && round
}
