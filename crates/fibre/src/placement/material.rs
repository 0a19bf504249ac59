//! Elasticity and strength of rods and bonds from a species' table values.

use crate::rod_bundle::RodMaterial;
use greenstick_wood::moisture::{Fallback, MoistureError};
use greenstick_wood::species::StrengthError;
use greenstick_wood::species::{GreenRatio, Group, Property, Species};
use greenstick_wood::structure::{
    COMPRESSION_EXPONENT, MODULUS_EXPONENT, TENSION_EXPONENT, hankinson,
};
use serde::{Deserialize, Serialize};

/// The true modulus along the grain over that of bending tests, whose deflection at a span of 14 depths is partly shear (Wood
/// Handbook, chapter 5: "increased by 10 percent").
const TRUE_OVER_BENDING_MODULUS: f64 = 1.1;
/// Means of the elastic ratios over E_L of the hardwoods in Wood Handbook Table 5-1 without balsa: E_R, E_T, G_LR, G_LT.
const HARDWOOD: [f64; 4] = [0.119, 0.060, 0.092, 0.069];
/// The same of its softwoods.
const SOFTWOOD: [f64; 4] = [0.096, 0.057, 0.082, 0.077];
/// Fracture energy across the grain from density (kg/m³): G = 1.04 ρ − 146 J/m² (Larsen and Gustafsson 1990, for softwoods;
/// used for all species, as no table has it).
const FRACTURE_ENERGY_SLOPE: f64 = 1.04;
const FRACTURE_ENERGY_OFFSET: f64 = 146.0;
/// Least fracture energy, J/m²: the lightest woods are below the densities for which that line was measured.
const MIN_FRACTURE_ENERGY: f64 = 50.0;
/// Fracture energy in shear along the grain over that in opening. In maritime pine it is some 0.6 to 0.9 kJ/m² (Silva, de Moura,
/// Dourado et al. 2006, end-notched flexure) against 0.2 (de Moura, Morais and Dourado 2008, double cantilever beam).
const SHEAR_FRACTURE_RATIO: f64 = 3.0;
/// Compressive strength across the grain over that along it, where no table has it: within the 0.03 to 0.40 that the Wood
/// Handbook (chapter 5, Hankinson's formula) gives.
const COMPRESSION_ACROSS_RATIO: f64 = 0.2;

/// A strength (Pa) as a power law a G^b of specific gravity G.
#[derive(Debug, Clone, Copy)]
struct PowerLaw {
    a: f64,
    b: f64,
}

const fn power_law(a: f64, b: f64) -> PowerLaw {
    PowerLaw { a, b }
}

/// A strength from specific gravity (Wood Handbook, Table 5-11), of hardwoods and of softwoods.
struct StrengthFromGravity {
    /// At 12 % moisture.
    dry: [PowerLaw; 2],
    /// Of green wood.
    green: [PowerLaw; 2],
}

const TENSION_ACROSS: StrengthFromGravity = StrengthFromGravity {
    dry: [power_law(10.1e6, 1.30), power_law(6.0e6, 1.11)],
    green: [power_law(10.5e6, 1.37), power_law(3.8e6, 0.78)],
};
const SHEAR: StrengthFromGravity = StrengthFromGravity {
    dry: [power_law(21.9e6, 1.13), power_law(16.6e6, 0.85)],
    green: [power_law(17.8e6, 1.24), power_law(11.0e6, 0.73)],
};

/// Elasticity and strength of wood, in Pa unless noted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WoodMaterial {
    /// Density at this moisture, kg/m³.
    pub density: f64,
    /// Modulus along the grain E_L.
    pub longitudinal: f64,
    /// Modulus across the rings E_R.
    pub radial: f64,
    /// Modulus along the rings E_T.
    pub tangential: f64,
    /// Shear modulus G_LR.
    pub shear_radial: f64,
    /// Shear modulus G_LT.
    pub shear_tangential: f64,
    /// Tensile strength along the grain.
    pub tension: f64,
    /// Crushing strength along the grain.
    pub compression: f64,
    /// Tensile strength across the grain.
    pub tension_across: f64,
    /// Compressive strength across the grain: the stress at the proportional limit.
    pub compression_across: f64,
    /// Shear strength along the grain.
    pub shear: f64,
    /// Fracture energy across the grain, J/m².
    pub fracture_energy: f64,
}

/// Estimates a strength from specific gravity, where a species' row at this moisture has none.
fn estimate(
    species: &Species,
    moisture: f64,
    missing: MoistureError,
    by: &StrengthFromGravity,
) -> Result<f64, MoistureError> {
    let wet = moisture >= species.intersection_percent();
    let green = species.green.as_ref().filter(|_| wet);
    let (laws, gravity) = match (&missing, green) {
        (MoistureError::NoValue { .. } | MoistureError::NoGreenValue { .. }, Some(green)) => {
            (by.green, green.specific_gravity)
        }
        (MoistureError::NoValue { .. }, None) if wet => {
            let ratio = GreenRatio::of_specific_gravity(species.group);
            let dry = species.dry.specific_gravity;
            (by.green, ratio.zip(dry).map(|(r, dry)| r.ratio * dry))
        }
        (MoistureError::NoValue { .. }, None) => (by.dry, species.dry.specific_gravity),
        _ => return Err(missing),
    };
    let law = match species.group {
        Group::Hardwood => laws[0],
        Group::Softwood => laws[1],
    };
    gravity.map_or(Err(missing), |g| Ok(law.a * libm::pow(g, law.b)))
}

/// Returns a strength from the species' row at this moisture; for green wood also where the dry row has none.
///
/// # Errors
/// [`MoistureError`] where there is no value, and no rule for it.
pub fn strength_at(
    species: &Species,
    property: Property,
    moisture: f64,
) -> Result<f64, MoistureError> {
    let wet = moisture >= species.intersection_percent();
    let green = species.green.as_ref().filter(|_| wet);
    match green.and_then(|g| g.get(property)) {
        Some(value) => Ok(value),
        None => species
            .property_at(property, moisture, Fallback::Refuse)
            .map(|a| a.value),
    }
}

/// Properties of a piece of wood over those of the mean of its species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RelativeWood {
    /// Of density.
    pub density: f64,
    /// Of all moduli of elasticity and of shear.
    pub modulus: f64,
    /// Of tensile and crushing strength along the grain, and crushing strength across it.
    pub strength: f64,
    /// Of tensile strength and fracture energy across the grain.
    pub tension_across: f64,
    /// Of shear strength.
    pub shear: f64,
}

impl WoodMaterial {
    /// Returns a piece of this wood that differs from its mean.
    pub(crate) fn scaled(&self, relative: &RelativeWood) -> Self {
        let RelativeWood {
            density,
            modulus,
            strength,
            tension_across,
            shear,
        } = *relative;
        WoodMaterial {
            density: self.density * density,
            longitudinal: self.longitudinal * modulus,
            radial: self.radial * modulus,
            tangential: self.tangential * modulus,
            shear_radial: self.shear_radial * modulus,
            shear_tangential: self.shear_tangential * modulus,
            tension: self.tension * strength,
            compression: self.compression * strength,
            tension_across: self.tension_across * tension_across,
            compression_across: self.compression_across * strength,
            shear: self.shear * shear,
            fracture_energy: self.fracture_energy * tension_across,
        }
    }

    /// Returns the same wood with properties along a rod whose grain has an angle (rad) to it, by Hankinson's formula.
    pub fn at_grain_angle(&self, angle: f64) -> Self {
        let across = 0.5 * (self.radial + self.tangential);
        WoodMaterial {
            longitudinal: hankinson(self.longitudinal, across, MODULUS_EXPONENT, angle),
            tension: hankinson(self.tension, self.tension_across, TENSION_EXPONENT, angle),
            compression: hankinson(
                self.compression,
                self.compression_across,
                COMPRESSION_EXPONENT,
                angle,
            ),
            ..*self
        }
    }

    /// Returns a rod of this wood whose cell has an area in m².
    pub fn rod(&self, area: f64) -> RodMaterial {
        let shear = 0.5 * (self.shear_radial + self.shear_tangential);
        RodMaterial {
            tension_limit: self.tension / self.longitudinal,
            shear_limit: self.shear / shear,
            yield_strain: self.compression / self.longitudinal,
            ..RodMaterial::solid(area, self.longitudinal, shear, self.density)
        }
    }

    /// Returns the wood of a species at `moisture` percent.
    ///
    /// # Errors
    /// [`StrengthError`] where a table value is missing or modulus of rupture and crushing strength do not fit together.
    pub fn from_species(
        species: &Species,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<Self, StrengthError> {
        let value = |p| species.property_at(p, moisture, fallback).map(|a| a.value);
        // An estimate from Table 5-11 is closer than the value of wood in another state.
        let strength = |p, by: &StrengthFromGravity| {
            strength_at(species, p, moisture)
                .or_else(|e| estimate(species, moisture, e, by))
                .or_else(|_| value(p))
        };
        let ratios = match species.group {
            Group::Hardwood => HARDWOOD,
            Group::Softwood => SOFTWOOD,
        };
        let longitudinal = TRUE_OVER_BENDING_MODULUS * value(Property::ModulusOfElasticity)?;
        // Mass at this moisture in the volume at 12 %.
        let dry = species.air_dry_density.map(|d| d / 1.12);
        let basic = species.dry.specific_gravity.unwrap_or(0.5) * 1000.0;
        let density = dry.unwrap_or(basic) * (1.0 + 0.01 * moisture);
        let compression = value(Property::CompressionParallel)?;
        Ok(WoodMaterial {
            density,
            longitudinal,
            radial: ratios[0] * longitudinal,
            tangential: ratios[1] * longitudinal,
            shear_radial: ratios[2] * longitudinal,
            shear_tangential: ratios[3] * longitudinal,
            tension: species.tensile_strength_at(moisture, fallback)?.value,
            compression,
            compression_across: value(Property::CompressionPerpendicular)
                .unwrap_or(COMPRESSION_ACROSS_RATIO * compression),
            tension_across: strength(Property::TensionPerpendicular, &TENSION_ACROSS)?,
            shear: strength(Property::ShearParallel, &SHEAR)?,
            fracture_energy: (FRACTURE_ENERGY_SLOPE * density - FRACTURE_ENERGY_OFFSET)
                .max(MIN_FRACTURE_ENERGY),
        })
    }

    /// Returns the fracture energy in shear along the grain, J/m².
    pub fn shear_fracture_energy(&self) -> f64 {
        SHEAR_FRACTURE_RATIO * self.fracture_energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_from_density_are_near_the_tables_of_species_that_have_both() {
        for (property, by, name) in [
            (Property::TensionPerpendicular, TENSION_ACROSS, "tension"),
            (Property::ShearParallel, SHEAR, "shear"),
        ] {
            for (moisture, least) in [(12.0, 60), (100.0, 20)] {
                let mut ratios: Vec<f64> = Species::all()[..112]
                    .iter()
                    .filter_map(|s| {
                        let missing = MoistureError::NoValue {
                            species: s.name.clone(),
                            property,
                            source_table: s.source.clone(),
                        };
                        let known = s.property_at(property, moisture, Fallback::Refuse).ok()?;
                        Some(estimate(s, moisture, missing, &by).ok()? / known.value)
                    })
                    .collect();
                ratios.sort_by(f64::total_cmp);
                let (count, median) = (ratios.len(), ratios[ratios.len() / 2]);
                assert!(
                    count > least && (0.93..1.07).contains(&median),
                    "{name} at {moisture} %: {count} {median}"
                );
            }
        }
    }

    #[test]
    fn green_wood_has_no_values_of_dry_wood() {
        // Neither row of these has tension across the grain.
        for name in ["slash pine", "sugar maple"] {
            let species = Species::find(name).unwrap();
            let [dry, green] = [12.0, 100.0]
                .map(|m| WoodMaterial::from_species(species, m, Fallback::Estimate).unwrap());
            let ratio = green.tension_across / dry.tension_across;
            assert!((0.3..0.95).contains(&ratio), "{name}: {ratio}");
        }
        // The green row of this one has it, the dry row has not.
        let hemlock = Species::find("eastern hemlock").unwrap();
        let wood = WoodMaterial::from_species(hemlock, 100.0, Fallback::Estimate).unwrap();
        assert_eq!(wood.tension_across, 1600e3);
    }
}
