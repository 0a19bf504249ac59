//! The effect of a species on the relief of a face.

use crate::report::{BreakNote, SpeciesReport};
use greenstick_fracture::recipe::Recipe;
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::species::{DEFAULT_BUNDLE_DIAMETER, HeightRule, UnknownSpecies};

/// Median over the Wood Handbook's species of the shear-lag length over the bundle's width: the wood that the relief
/// of the parameters stands for.
const TYPICAL_SLENDERNESS: f64 = 2.87;

/// The effect of a species on the relief of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesRelief {
    /// Factor on the torn relief.
    pub factor: f64,
    /// Where the factor comes from, if a species is named and has the values.
    pub report: Option<SpeciesReport>,
    /// Why the factor is 1 although a species is named.
    pub note: Option<BreakNote>,
}

impl SpeciesRelief {
    /// Returns the effect of no species.
    fn none(note: Option<BreakNote>) -> Self {
        SpeciesRelief {
            factor: 1.0,
            report: None,
            note,
        }
    }

    /// Returns the effect on a face whose heights decide how far the wood splinters: none.
    pub fn decided_by_heights() -> Self {
        SpeciesRelief::none(None)
    }

    /// Returns the effect of a recipe's species on the face of a stem of `radius` (m). `relief_range` gives the range of
    /// heights from the 5th to the 95th percentile with a factor on the torn relief (m); it is called where the species has
    /// a rule for the whole face.
    ///
    /// # Errors
    /// An unknown species, and those of `relief_range`.
    pub fn from_recipe<E: From<UnknownSpecies>>(
        recipe: &Recipe,
        radius: f64,
        relief_range: impl FnMut(f64) -> Result<f64, E>,
    ) -> Result<Self, E> {
        let Some(species) = recipe.species()? else {
            return Ok(SpeciesRelief::none(None));
        };
        let moisture = recipe.moisture.unwrap_or(AIR_DRY_PERCENT);
        let height = match species.fracture_height(
            radius,
            DEFAULT_BUNDLE_DIAMETER,
            moisture,
            Fallback::Estimate,
        ) {
            Ok(height) => height,
            Err(error) => {
                let note = BreakNote::NoSpeciesHeight(error.to_string());
                return Ok(SpeciesRelief::none(Some(note)));
            }
        };
        let factor = match height.rule {
            HeightRule::Eq9 => factor_for(height.ratio * radius, relief_range)?,
            HeightRule::ShearLag => {
                height.ratio * radius / DEFAULT_BUNDLE_DIAMETER / TYPICAL_SLENDERNESS
            }
        };
        let report = SpeciesReport {
            name: species.name.clone(),
            scientific_name: species.scientific_name.clone(),
            moisture_percent: moisture,
            rule: height.rule.to_string(),
            basis: height.basis.to_string(),
            height_m: height.ratio * radius,
            relief: factor,
        };
        Ok(SpeciesRelief {
            factor,
            report: Some(report),
            note: None,
        })
    }
}

/// Fraction by which the range of heights may miss that of the species, and the most corrections of the factor.
const RANGE_TOLERANCE: f64 = 0.005;
const MAX_CORRECTIONS: usize = 8;

/// Returns the factor on the torn relief with which the range of heights is `wanted` (m). What the factor does not change,
/// such as the inclination, counts too, so that the factor is not simply a ratio.
fn factor_for<E>(
    wanted: f64,
    mut relief_range: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let mut factor = 1.0;
    for _ in 0..MAX_CORRECTIONS {
        let ratio = wanted / relief_range(factor)?.max(1e-9);
        if (ratio - 1.0).abs() < RANGE_TOLERANCE {
            break;
        }
        factor *= ratio;
    }
    Ok(factor)
}
