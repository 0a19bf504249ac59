//! The wood of single specimens: how each differs from the mean of its species.
//!
//! - Density is normally distributed about the species' mean, with the coefficient of variation of Wood Handbook Table 5-6.
//! - Stiffness and strength follow it with the slopes of Table 5-11
//!   ([`ClearWoodVariation`](greenstick_wood::species::ClearWoodVariation)).
//! - What remains of the coefficients of variation of Table 5-6 is drawn for each specimen: independent factors of its moduli
//!   and of its strength along the grain, lognormally distributed. (The distributions are those of the JCSS Probabilistic Model
//!   Code, part 3.5, "Properties of Timber".) Of the modulus of rupture it is what density and [flaws](super::flaws) leave.
//! - Strength across the grain and in shear follows density alone.
//!
//! In real wood the rests of stiffness and strength are correlated, since both suffer from the same grain; here they are not.

use super::error::BendingError;
use super::flaws::weibull_variation;
use crate::placement::RelativeWood;
use greenstick_wood::noise::unit;
use greenstick_wood::species::ClearWoodVariation;
use std::f64::consts::TAU;

/// Standard deviations from the mean at which density is cut off: once in 16,000 specimens.
const MAX_DEVIATIONS: f64 = 4.0;
/// Stream of random numbers for the wood of specimens.
const WOOD_STREAM: u64 = 0x9_00d5;

/// The distribution of the wood of a species' specimens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WoodDistribution {
    variation: ClearWoodVariation,
    /// Coefficient of variation of the modulus of elasticity of specimens of one density.
    modulus: f64,
    /// The same of strength along the grain, apart from flaws.
    strength: f64,
}

/// Returns the coefficient of variation of a factor that, independent of others, makes the whole vary by `total`; `None` where
/// the others vary by more.
fn remaining_variation(total: f64, others: &[f64]) -> Option<f64> {
    // 1 + c² of a product of independent factors is the product of theirs.
    let product: f64 = others.iter().map(|c| 1.0 + c * c).product();
    let square = (1.0 + total * total) / product - 1.0;
    (square >= 0.0).then(|| square.sqrt())
}

impl WoodDistribution {
    /// Returns the distribution where flaws have a Weibull modulus.
    ///
    /// # Errors
    /// [`BendingError::Flaws`] where flaws alone scatter more than density leaves of the modulus of rupture.
    pub fn new(variation: ClearWoodVariation, flaws: f64) -> Result<Self, BendingError> {
        let ClearWoodVariation {
            coefficients,
            slopes,
        } = variation;
        let by_density = |slope: f64| slope * coefficients.density;
        let by_flaws = weibull_variation(flaws);
        let rupture = by_density(slopes.modulus_of_rupture);
        let left = remaining_variation(coefficients.modulus_of_rupture, &[rupture]).unwrap_or(0.0);
        let others = [by_density(slopes.modulus_of_elasticity)];
        Ok(WoodDistribution {
            variation,
            modulus: remaining_variation(coefficients.modulus_of_elasticity, &others)
                .unwrap_or(0.0),
            strength: remaining_variation(left, &[by_flaws]).ok_or(BendingError::Flaws {
                modulus: flaws,
                scatter: 100.0 * by_flaws,
                most: 100.0 * left,
            })?,
        })
    }

    /// Returns the wood of a specimen by its number.
    pub fn draw(&self, seed: u64, number: u32) -> RelativeWood {
        let normal = |purpose: i64| standard_normal(seed ^ WOOD_STREAM, i64::from(number), purpose);
        let ClearWoodVariation {
            coefficients,
            slopes,
        } = self.variation;
        let denser = coefficients.density * normal(0).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS);
        let by_density = |slope: f64| 1.0 + slope * denser;
        RelativeWood {
            density: 1.0 + denser,
            modulus: by_density(slopes.modulus_of_elasticity) * lognormal(self.modulus, normal(1)),
            strength: by_density(slopes.modulus_of_rupture) * lognormal(self.strength, normal(2)),
            tension_across: by_density(slopes.tension_perpendicular),
            shear: by_density(slopes.shear_parallel),
        }
    }
}

/// Returns a normally distributed number with mean 0 and standard deviation 1 (Box and Muller 1958).
fn standard_normal(seed: u64, number: i64, purpose: i64) -> f64 {
    let [radial, angular] = [0, 1].map(|part| unit(seed, number, purpose, part));
    (-2.0 * libm::log1p(-radial)).sqrt() * libm::cos(TAU * angular)
}

/// Returns a lognormally distributed factor with mean 1 and a coefficient of variation, for a standard normal number.
fn lognormal(variation: f64, normal: f64) -> f64 {
    let variance = libm::log1p(variation * variation);
    libm::exp(variance.sqrt() * normal - 0.5 * variance)
}

#[cfg(test)]
mod tests {
    use super::super::statistics::{Statistics, correlation};
    use super::*;
    use greenstick_wood::species::Species;

    #[test]
    fn drawn_wood_scatters_as_the_tables_say() {
        let birch = Species::find("yellow birch").unwrap();
        let variation = birch.clear_wood_variation().unwrap();
        let wood = WoodDistribution::new(variation, 18.0).unwrap();
        let drawn: Vec<RelativeWood> = (0..20_000).map(|n| wood.draw(1, n)).collect();
        let column = |f: fn(&RelativeWood) -> f64| drawn.iter().map(f).collect::<Vec<f64>>();
        let [density, modulus, strength] = [
            column(|w| w.density),
            column(|w| w.modulus),
            column(|w| w.strength),
        ];
        let variation = |values: &[f64]| {
            let s = Statistics::new(values).unwrap();
            assert!((s.mean - 1.0).abs() < 5e-3, "{s:?}");
            s.coefficient_of_variation.unwrap()
        };
        assert!((variation(&density) - 0.10).abs() < 2e-3);
        assert!((variation(&modulus) - 0.22).abs() < 4e-3);
        // Flaws add 6.9 % to the scatter of the modulus of rupture.
        let with_flaws = variation(&strength).hypot(weibull_variation(18.0));
        assert!((with_flaws - 0.16).abs() < 3e-3, "{with_flaws}");
        // Slope times density's scatter over the whole scatter.
        let expected = [0.70 * 0.10 / 0.22, 1.13 * 0.10 / variation(&strength)];
        for (values, expected) in [(&modulus, expected[0]), (&strength, expected[1])] {
            let found = correlation(&density, values);
            assert!((found - expected).abs() < 0.02, "{found} {expected}");
        }
        assert!(correlation(&modulus, &strength) < 0.3);
    }

    #[test]
    fn flaws_that_scatter_more_than_the_table_are_refused() {
        let birch = Species::find("yellow birch").unwrap();
        let variation = birch.clear_wood_variation().unwrap();
        let error = WoodDistribution::new(variation, 5.0)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("22.9 %") && error.contains("11.3 %"),
            "{error}"
        );
    }
}
