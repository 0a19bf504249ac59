//! How much clear wood varies within a species, and how its stiffness and strength follow its density (Wood Handbook, Tables
//! 5-6 and 5-11).
//!
//! Table 5-6 is the mean of about 50 species: the handbook has no row for each. Its coefficients are of green wood and are said
//! to hold for wood at 12 % moisture too. The source of the European species quotes the same ones (`data/SOURCES.md`).
//!
//! Table 5-11 gives mechanical properties as powers of specific gravity, *a* G^*b*, fitted to the means of species. Within a
//! species, says the handbook (chapter 5, "Specific Gravity"), properties tend to be linear in specific gravity. The line taken
//! here touches that power at the species' mean, where its slope is *b*: a specimen denser by 10 % is stronger by *b* × 10 %.
//! Older work finds a slightly higher power within a species than between species (Forest Products Laboratory, *Specific
//! gravity-strength relations for wood*, No. 1303, 1941), so that the slope is rather too small.

use super::record::{Group, Species};
use serde::{Deserialize, Serialize};

/// Coefficients of variation of clear wood within a species: standard deviation over mean.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoefficientsOfVariation {
    /// Of specific gravity, and so of density at one moisture content.
    pub density: f64,
    /// Of the modulus of elasticity in static bending.
    pub modulus_of_elasticity: f64,
    /// Of the modulus of rupture in static bending.
    pub modulus_of_rupture: f64,
    /// Of work to maximum load in static bending.
    pub work_to_maximum_load: f64,
}

/// Relative change of a property over the relative change of density that goes with it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DensitySlopes {
    /// Of the modulus of elasticity in static bending.
    pub modulus_of_elasticity: f64,
    /// Of the modulus of rupture in static bending.
    pub modulus_of_rupture: f64,
    /// Of shear strength along the grain.
    pub shear_parallel: f64,
    /// Of tensile strength across the grain.
    pub tension_perpendicular: f64,
}

/// How clear wood varies within a species.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClearWoodVariation {
    /// Table 5-6.
    pub coefficients: CoefficientsOfVariation,
    /// Table 5-11.
    pub slopes: DensitySlopes,
}

/// The table of a species' values says nothing of small clear specimens, so neither does Table 5-6 of the species.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the scatter of {species} is not known: its values are those of branches ({source_table}), and the coefficients of \
     variation in Wood Handbook Table 5-6 are of small clear specimens; choose a species of another table"
)]
pub struct UnknownVariation {
    /// The species' name.
    pub species: String,
    /// Where its values come from.
    pub source_table: String,
}

/// Wood Handbook, Table 5-6.
const TABLE_5_6: CoefficientsOfVariation = CoefficientsOfVariation {
    density: 0.10,
    modulus_of_elasticity: 0.22,
    modulus_of_rupture: 0.16,
    work_to_maximum_load: 0.34,
};

/// Exponents of Wood Handbook Table 5-11 at 12 % moisture.
const HARDWOOD_SLOPES: DensitySlopes = DensitySlopes {
    modulus_of_elasticity: 0.70,
    modulus_of_rupture: 1.13,
    shear_parallel: 1.13,
    tension_perpendicular: 1.30,
};
/// The same of softwoods.
const SOFTWOOD_SLOPES: DensitySlopes = DensitySlopes {
    modulus_of_elasticity: 0.84,
    modulus_of_rupture: 1.01,
    shear_parallel: 0.85,
    tension_perpendicular: 1.11,
};

impl Species {
    /// Returns how the clear wood of the species varies, at every moisture content: the exponents of Table 5-11 for green wood
    /// differ from those at 12 %, which are taken here, by at most 0.12 but across the grain.
    ///
    /// ```
    /// use greenstick_wood::species::Species;
    ///
    /// let birch = Species::find("yellow birch")?.clear_wood_variation()?;
    /// assert_eq!(birch.coefficients.modulus_of_rupture, 0.16);
    /// assert_eq!(birch.slopes.modulus_of_rupture, 1.13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`UnknownVariation`] for Yang's four species, whose values are of branches.
    pub fn clear_wood_variation(&self) -> Result<ClearWoodVariation, UnknownVariation> {
        if self.splitting_resistance.is_some() {
            return Err(UnknownVariation {
                species: self.name.clone(),
                source_table: self.source.clone(),
            });
        }
        Ok(ClearWoodVariation {
            coefficients: TABLE_5_6,
            slopes: match self.group {
                Group::Hardwood => HARDWOOD_SLOPES,
                Group::Softwood => SOFTWOOD_SLOPES,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::Property;

    /// Slope of the logarithm of a property over that of specific gravity, by least squares over a group's species.
    fn exponent(group: Group, property: Property) -> f64 {
        let american = Species::all().iter().filter(|s| s.source.contains("5-3a"));
        let logarithms: Vec<[f64; 2]> = american
            .filter(|s| s.group == group)
            .filter_map(|s| Some([s.dry.specific_gravity?.ln(), s.dry.get(property)?.ln()]))
            .collect();
        let n = logarithms.len() as f64;
        assert!(n > 20.0);
        let mean = |k: usize| logarithms.iter().map(|p| p[k]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let (xy, xx) = logarithms.iter().fold((0.0, 0.0), |(xy, xx), p| {
            (xy + (p[0] - x) * (p[1] - y), xx + (p[0] - x).powi(2))
        });
        xy / xx
    }

    #[test]
    fn the_exponents_are_near_those_of_the_species_of_table_5_3a() {
        for (group, slopes) in [
            (Group::Hardwood, HARDWOOD_SLOPES),
            (Group::Softwood, SOFTWOOD_SLOPES),
        ] {
            for (property, slope) in [
                (Property::ModulusOfElasticity, slopes.modulus_of_elasticity),
                (Property::ModulusOfRupture, slopes.modulus_of_rupture),
                (Property::ShearParallel, slopes.shear_parallel),
                (Property::TensionPerpendicular, slopes.tension_perpendicular),
            ] {
                let fitted = exponent(group, property);
                println!("{group:?} {property}: {fitted:.2}, table {slope}");
                assert!(
                    (fitted - slope).abs() < 0.02,
                    "{group:?} {property}: {fitted}"
                );
            }
        }
    }

    #[test]
    fn branches_have_no_scatter_of_clear_specimens() {
        let error = Species::find("tree of heaven")
            .unwrap()
            .clear_wood_variation();
        let text = error.unwrap_err().to_string();
        assert!(text.contains("branches") && text.contains("5-6"), "{text}");
    }
}
