//! Density of earlywood and latewood, from the species' ring character and the width of the ring.
//!
//! Latewood is about two and a half times as dense as earlywood in conifers with abrupt latewood (Douglas-fir, southern
//! pines, larches), twice in conifers with gradual latewood (spruces, firs), half as dense again in ring-porous hardwoods,
//! and hardly denser in diffuse-porous ones (Kollmann and Côté, *Principles of Wood Science and Technology* I, 1968, on the
//! structure of annual rings; Panshin and de Zeeuw, *Textbook of Wood Technology*, 1980).
//!
//! A wide ring of a conifer is light, since its latewood is about as wide as in other years; a wide ring of a ring-porous
//! hardwood is heavy, since its earlywood is. The rings of diffuse-porous woods are equally dense at any width (same sources).

use crate::rings::{LATEWOOD_FRACTION, RingPart};
use crate::species::{Group, RingCharacter, Species};

/// The least and greatest part of a ring that its width makes latewood.
const LATEWOOD_RANGE: (f64, f64) = (0.1, 0.6);

/// Densities within annual rings, relative to the mean of a ring of mean width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingDensity {
    character: RingCharacter,
    /// Density of latewood over that of earlywood.
    latewood_ratio: f64,
}

impl RingDensity {
    /// The densities of a species' rings. Where its ring character is not known, a conifer has gradual latewood and a
    /// hardwood is diffuse-porous.
    pub fn new(species: &Species) -> Self {
        let character = species.ring_character.unwrap_or(match species.group {
            Group::Softwood => RingCharacter::GradualLatewood,
            Group::Hardwood => RingCharacter::DiffusePorous,
        });
        RingDensity {
            character,
            latewood_ratio: match character {
                RingCharacter::AbruptLatewood => 2.5,
                RingCharacter::GradualLatewood => 2.0,
                RingCharacter::RingPorous => 1.5,
                RingCharacter::SemiRingPorous => 1.3,
                RingCharacter::DiffusePorous => 1.1,
            },
        }
    }

    /// Returns the relative density of a part of a ring that is `width` times as wide as the mean ring.
    ///
    /// Rings are shown with the same part of latewood whatever their width, so that a ring's mean density, not that part,
    /// follows the width.
    pub fn relative(&self, part: RingPart, width: f64) -> f64 {
        let mean = |latewood: f64| 1.0 + latewood * (self.latewood_ratio - 1.0);
        let (low, high) = LATEWOOD_RANGE;
        let width = width.max(f64::MIN_POSITIVE);
        let latewood = match self.character {
            RingCharacter::AbruptLatewood | RingCharacter::GradualLatewood => {
                (LATEWOOD_FRACTION / width).clamp(low, high)
            }
            RingCharacter::RingPorous | RingCharacter::SemiRingPorous => {
                (1.0 - (1.0 - LATEWOOD_FRACTION) / width).clamp(low, high)
            }
            RingCharacter::DiffusePorous => LATEWOOD_FRACTION,
        };
        let earlywood = mean(latewood) / (mean(LATEWOOD_FRACTION) * mean(LATEWOOD_FRACTION));
        match part {
            RingPart::Earlywood => earlywood,
            RingPart::Latewood => earlywood * self.latewood_ratio,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> RingDensity {
        RingDensity::new(Species::find(name).unwrap())
    }

    #[test]
    fn a_ring_of_mean_width_has_the_mean_density() {
        for species in Species::all() {
            let rings = RingDensity::new(species);
            let [early, late] =
                [RingPart::Earlywood, RingPart::Latewood].map(|p| rings.relative(p, 1.0));
            let mean = (1.0 - LATEWOOD_FRACTION) * early + LATEWOOD_FRACTION * late;
            assert!((mean - 1.0).abs() < 1e-12, "{}: {mean}", species.name);
            assert!(late > early);
        }
    }

    #[test]
    fn wide_rings_are_light_in_conifers_and_heavy_in_ring_porous_wood() {
        let change = |name: &str| {
            let rings = of(name);
            rings.relative(RingPart::Earlywood, 2.0) / rings.relative(RingPart::Earlywood, 0.6)
        };
        assert!(change("Douglas-fir, coast") < 0.85);
        assert!(change("Sitka spruce") < 0.9);
        assert!(change("white oak") > 1.15);
        assert_eq!(change("sugar maple"), 1.0);
    }
}
