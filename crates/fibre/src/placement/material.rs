//! What a species' table values are for rods and bonds (`model.md` §3).

use greenstick_wood::moisture::{Fallback, MoistureError};
use greenstick_wood::species::StrengthError;
use greenstick_wood::species::{Group, Property, Species};
use serde::{Deserialize, Serialize};

/// The true modulus along the grain over the one of bending tests, whose deflection at a span of 14 depths is in part
/// from shear (Wood Handbook, chapter 5: "increased by 10 percent").
const BENDING_TO_TRUE: f64 = 1.1;
/// Means of the elastic ratios over E_L of the hardwoods in Wood Handbook Table 5-1 without balsa: E_R, E_T, G_LR, G_LT.
const HARDWOOD: [f64; 4] = [0.119, 0.060, 0.092, 0.069];
/// The same of its softwoods.
const SOFTWOOD: [f64; 4] = [0.096, 0.057, 0.082, 0.077];
/// Energy of fracture across the grain from density (kg/m³): G = 1.04 ρ − 146 J/m² (Larsen and Gustafsson 1990, for
/// softwoods; taken for all, as no table has it).
const FRACTURE_SLOPE: f64 = 1.04;
const FRACTURE_OFFSET: f64 = 146.0;
/// The lightest woods are below where that line was measured, J/m².
const LEAST_FRACTURE_ENERGY: f64 = 50.0;

/// Tension across the grain (Pa) at 12 % as a G^b of specific gravity G, (a, b) of hardwoods and of softwoods: Wood
/// Handbook, Table 5-11.
const TENSION_ACROSS: [(f64, f64); 2] = [(10.1e6, 1.30), (6.0e6, 1.11)];
/// The same of shear along the grain.
const SHEAR: [(f64, f64); 2] = [(21.9e6, 1.13), (16.6e6, 0.85)];

/// Elasticity and strength of wood, Pa but where said.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WoodMaterial {
    /// Density as it is, kg/m³.
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
    /// Shear strength along the grain.
    pub shear: f64,
    /// Energy of fracture across the grain, J/m².
    pub fracture_energy: f64,
}

/// Strength across and along the grain from specific gravity, where a species' row has none.
fn estimate(
    species: &Species,
    missing: MoistureError,
    [hardwood, softwood]: [(f64, f64); 2],
) -> Result<f64, MoistureError> {
    let (factor, power) = match species.group {
        Group::Hardwood => hardwood,
        Group::Softwood => softwood,
    };
    match (&missing, species.dry.specific_gravity) {
        (MoistureError::NoValue { .. }, Some(gravity)) => Ok(factor * libm::pow(gravity, power)),
        _ => Err(missing),
    }
}

impl WoodMaterial {
    /// The wood of a species at `moisture` percent.
    ///
    /// # Errors
    /// [`StrengthError`] where a table value is missing or modulus of rupture and crushing strength do not fit together.
    pub fn of(species: &Species, moisture: f64, fallback: Fallback) -> Result<Self, StrengthError> {
        let value = |p| species.property_at(p, moisture, fallback).map(|a| a.value);
        let ratios = match species.group {
            Group::Hardwood => HARDWOOD,
            Group::Softwood => SOFTWOOD,
        };
        let longitudinal = BENDING_TO_TRUE * value(Property::ModulusOfElasticity)?;
        // Mass at this moisture in the volume at 12 %.
        let dry = species.air_dry_density.map(|d| d / 1.12);
        let basic = species.dry.specific_gravity.unwrap_or(0.5) * 1000.0;
        let density = dry.unwrap_or(basic) * (1.0 + 0.01 * moisture);
        Ok(WoodMaterial {
            density,
            longitudinal,
            radial: ratios[0] * longitudinal,
            tangential: ratios[1] * longitudinal,
            shear_radial: ratios[2] * longitudinal,
            shear_tangential: ratios[3] * longitudinal,
            tension: species.tensile_strength_at(moisture, fallback)?.value,
            compression: value(Property::CompressionParallel)?,
            tension_across: value(Property::TensionPerpendicular)
                .or_else(|e| estimate(species, e, TENSION_ACROSS))?,
            shear: value(Property::ShearParallel).or_else(|e| estimate(species, e, SHEAR))?,
            fracture_energy: (FRACTURE_SLOPE * density - FRACTURE_OFFSET)
                .max(LEAST_FRACTURE_ENERGY),
        })
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
            let mut ratios: Vec<f64> = Species::all()[..112]
                .iter()
                .filter_map(|s| {
                    let missing = MoistureError::NoValue {
                        species: s.name.clone(),
                        property,
                        source_table: s.source.clone(),
                    };
                    Some(estimate(s, missing, by).ok()? / s.dry.get(property)?)
                })
                .collect();
            ratios.sort_by(f64::total_cmp);
            let (count, median) = (ratios.len(), ratios[ratios.len() / 2]);
            assert!(
                count > 60 && (0.93..1.07).contains(&median),
                "{name}: {count} {median}"
            );
        }
    }
}
