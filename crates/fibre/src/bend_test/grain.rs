//! What Hankinson's formula expects of a specimen whose grain is not along it.

use super::specimen::BendTest;
use crate::placement::WoodMaterial;
use greenstick_wood::structure::{BENDING_EXPONENTS, MODULUS_EXPONENT, hankinson};
use serde::Serialize;

/// Modulus and strength of the table at the angle of the grain, by Hankinson's formula (Wood Handbook, Eq. 5-2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopedGrain {
    /// Angle of the grain to the specimen, degrees.
    pub angle_deg: f64,
    /// Modulus of elasticity, Pa: exponent 2.
    pub modulus_of_elasticity_pa: f64,
    /// Least and greatest modulus of rupture, Pa: exponents 1.5 and 2 for bending strength.
    pub modulus_of_rupture_pa: [f64; 2],
}

impl SlopedGrain {
    /// Returns what is expected of `wood`, whose table has these moduli of elasticity and rupture (Pa); `None` for straight
    /// grain.
    pub(super) fn expected(
        test: &BendTest,
        wood: &WoodMaterial,
        [elasticity, rupture]: [f64; 2],
    ) -> Option<Self> {
        let angle = test.grain_angle;
        let across = 0.5 * (wood.radial + wood.tangential) / wood.longitudinal;
        let strength = |n| hankinson(rupture, wood.tension_across, n, angle);
        (angle != 0.0).then(|| SlopedGrain {
            angle_deg: angle.to_degrees(),
            modulus_of_elasticity_pa: hankinson(
                elasticity,
                elasticity * across,
                MODULUS_EXPONENT,
                angle,
            ),
            modulus_of_rupture_pa: BENDING_EXPONENTS.map(strength),
        })
    }
}

impl std::fmt::Display for SlopedGrain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [least, greatest] = self.modulus_of_rupture_pa.map(|pascals| pascals / 1e6);
        write!(
            f,
            "the grain is at {}°, where Hankinson's formula leaves {:.2} GPa and {least:.1} to {greatest:.1} MPa of the table's \
             modulus and rupture",
            self.angle_deg,
            self.modulus_of_elasticity_pa / 1e9
        )
    }
}
