//! Grain that is not along the stem: its angle at a place, and what an angle leaves of stiffness and strength.
//!
//! Hankinson's formula, N = P Q/(P sinⁿ θ + Q cosⁿ θ), gives a property at the angle θ to the grain from those along (P) and
//! across (Q) it (Wood Handbook, chapter 5, Eq. 5-2). The exponents are the middles of the ranges in the table beside it.

use std::f64::consts::TAU;

/// Exponent of the modulus of elasticity (2).
pub const MODULUS_EXPONENT: f64 = 2.0;
/// Exponent of tensile strength (1.5 to 2).
pub const TENSION_EXPONENT: f64 = 1.75;
/// Exponent of crushing strength (2 to 2.5).
pub const COMPRESSION_EXPONENT: f64 = 2.25;
/// Least and greatest exponent of bending strength.
pub const BENDING_EXPONENTS: [f64; 2] = [1.5, 2.0];

/// Returns a property at `angle` (rad) to the grain, by Hankinson's formula.
///
/// ```
/// use greenstick_wood::structure::hankinson;
///
/// let at = |degrees: f64| hankinson(100.0, 5.0, 2.0, degrees.to_radians());
/// assert!((at(0.0) - 100.0).abs() < 1e-9 && (at(90.0) - 5.0).abs() < 1e-9);
/// assert!((at(15.0) - 44.0).abs() < 0.2);
/// ```
pub fn hankinson(along: f64, across: f64, exponent: f64, angle: f64) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let power = |x: f64| libm::pow(x.abs(), exponent);
    along * across / (along * power(sin) + across * power(cos))
}

/// Grain that is not along the stem. Angles add up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GrainAngles {
    /// Spiral grain: angle at the outside of the stem, rad; its tangent grows with the distance from the pith.
    pub spiral: f64,
    /// Wavy grain: the largest angle, rad.
    pub wave: f64,
    /// Length of a wave along the stem, m; above 0.
    pub wave_length: f64,
    /// Interlocked grain: the largest angle, rad, left and right in turn from the pith outwards.
    pub interlock: f64,
    /// Annual rings from one turn to the left to the next; above 0.
    pub interlock_rings: f64,
}

impl GrainAngles {
    /// Whether the grain is along the stem everywhere.
    pub fn is_straight(&self) -> bool {
        self.spiral == 0.0 && self.wave == 0.0 && self.interlock == 0.0
    }

    /// Returns the angle (rad) at a ring coordinate, in a ring (counted from the pith, with fractions) and at a length along
    /// the stem, m.
    pub fn angle(&self, rho: f64, ring: f64, along: f64) -> f64 {
        let wave = |amplitude: f64, turns: f64| {
            if amplitude == 0.0 {
                0.0
            } else {
                amplitude * libm::sin(TAU * turns)
            }
        };
        libm::atan(rho * libm::tan(self.spiral))
            + wave(self.wave, along / self.wave_length)
            + wave(self.interlock, ring / self.interlock_rings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_each_kind_of_grain() {
        let spiral = GrainAngles {
            spiral: 0.2,
            ..GrainAngles::default()
        };
        assert!((spiral.angle(1.0, 5.0, 0.3) - 0.2).abs() < 1e-12);
        assert!((libm::tan(spiral.angle(0.5, 2.0, 0.1)) - 0.5 * libm::tan(0.2)).abs() < 1e-12);
        let wavy = GrainAngles {
            wave: 0.1,
            wave_length: 0.04,
            ..GrainAngles::default()
        };
        assert!((wavy.angle(0.7, 3.0, 0.01) - 0.1).abs() < 1e-12);
        assert!(wavy.angle(0.7, 3.0, 0.02).abs() < 1e-12);
        let interlocked = GrainAngles {
            interlock: 0.15,
            interlock_rings: 8.0,
            ..GrainAngles::default()
        };
        let [left, right] = [2.0, 6.0].map(|ring| interlocked.angle(0.5, ring, 0.0));
        assert!((left - 0.15).abs() < 1e-12 && (right + 0.15).abs() < 1e-12);
        assert!(GrainAngles::default().is_straight() && !interlocked.is_straight());
    }
}
