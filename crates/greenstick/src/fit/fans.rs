//! Fans of the section (Yang 2019, Eqs. 2 to 7) that part it best: a search over direction, angle and rings.

use greenstick_fracture::parameters::Sector;

/// Steps of the search, degrees.
pub(super) const STEP_DEGREES: u32 = 10;
/// Steps of the search in the part of the rings, of the whole.
const RING_STEPS: u32 = 10;
/// Scores nearer than this part of the best one are the same, summed in another order.
const SAME: f64 = 1e-9;

/// A place in the section: angle (degrees) and ring coordinate.
pub(super) type Address = (f64, f64);

/// What a fan holds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held {
    /// Places.
    pub count: usize,
    /// Sum of their weights.
    pub weight: f64,
    /// Sum of weight times value.
    pub sum: f64,
}

/// What of the places, each with weight and value, lies in `fan`.
pub(super) fn held(fan: &Sector, places: &[Address], values: &[(f64, f64)]) -> Held {
    let mut held = Held::default();
    for (&(angle, rho), &(weight, value)) in places.iter().zip(values) {
        if fan.contains(angle, rho) {
            held.count += 1;
            held.weight += weight;
            held.sum += weight * value;
        }
    }
    held
}

/// The fan with the highest `score` above zero. Of fans that score alike, as they hold the same places, the one in the
/// middle.
pub(super) fn best(
    places: &[Address],
    values: &[(f64, f64)],
    score: impl Fn(&Held) -> f64,
) -> Option<Sector> {
    let mut best = 0.0;
    let mut alike: Vec<Sector> = Vec::new();
    for rings in 1..=RING_STEPS {
        for angle in 1..=360 / STEP_DEGREES {
            for direction in 0..360 / STEP_DEGREES {
                let fan = Sector {
                    direction: f64::from(direction * STEP_DEGREES),
                    angle: f64::from(angle * STEP_DEGREES),
                    rings: f64::from(rings) / f64::from(RING_STEPS),
                };
                let found = score(&held(&fan, places, values));
                if found > best * (1.0 + SAME) {
                    best = found;
                    alike.clear();
                }
                if found > 0.0 && found >= best * (1.0 - SAME) {
                    alike.push(fan);
                }
            }
        }
    }
    let count = alike.len() as f64;
    let (mut x, mut y, mut angle, mut rings) = (0.0, 0.0, 0.0, 0.0);
    for fan in &alike {
        let (sin, cos) = libm::sincos(fan.direction.to_radians());
        (x, y) = (x + cos, y + sin);
        (angle, rings) = (angle + fan.angle, rings + fan.rings);
    }
    // All around there is no direction.
    let around = libm::hypot(x, y) < SAME * count.max(1.0);
    let middle = Sector {
        direction: if around {
            0.0
        } else {
            libm::atan2(y, x).to_degrees().rem_euclid(360.0)
        },
        angle: angle / count,
        rings: rings / count,
    };
    if score(&held(&middle, places, values)) >= best * (1.0 - SAME) && !alike.is_empty() {
        return Some(middle);
    }
    let off = |fan: &Sector| {
        let turn = (fan.direction - middle.direction + 180.0).rem_euclid(360.0) - 180.0;
        turn.abs() + (fan.angle - middle.angle).abs() + 360.0 * (fan.rings - middle.rings).abs()
    };
    alike.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))
}
