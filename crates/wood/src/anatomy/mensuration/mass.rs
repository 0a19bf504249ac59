//! Mass, density and moisture of a stem's wood.

use crate::moisture::{FIBRE_SATURATION_PERCENT, MoistureError, drying};
use crate::species::{Group, Species};
use serde::{Deserialize, Serialize};

/// Density of water, kg/m³.
const WATER_DENSITY: f64 = 1000.0;

/// What the wood of a stem weighs. Bark is left out: no table has its density.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MassReport {
    /// Oven-dry mass over green volume, kg/m³.
    pub basic_density_kg_m3: f64,
    /// Where it comes from.
    pub basic_density_from: String,
    /// Moisture content of the heartwood (pith included), % of the oven-dry mass.
    pub heartwood_moisture_percent: f64,
    /// Moisture content of the sapwood, % of the oven-dry mass.
    pub sapwood_moisture_percent: f64,
    /// Where these come from.
    pub moisture_from: String,
    /// Volume of the heartwood (pith included), m³.
    pub heartwood_m3: f64,
    /// Volume of the sapwood, m³.
    pub sapwood_m3: f64,
    /// Oven-dry mass of both, kg.
    pub dry_mass_kg: f64,
    /// Mass of both with their water, kg.
    pub mass_kg: f64,
    /// Mass over volume of both, kg/m³.
    pub density_kg_m3: f64,
    /// Water over oven-dry mass of both, %.
    pub moisture_percent: f64,
}

/// Densities of a species' wood, and how wet it is.
#[derive(Debug, Clone, PartialEq)]
pub struct WoodMass {
    /// Oven-dry mass over green volume, kg/m³.
    basic_density: f64,
    basic_density_from: &'static str,
    /// Of heartwood and of sapwood, %.
    moisture: [f64; 2],
    moisture_from: &'static str,
    /// Volume over green volume of heartwood and of sapwood.
    shrunk: [f64; 2],
}

impl WoodMass {
    /// Returns the wood of a species at `moisture` percent, green where it is not given. `None` where the tables have no
    /// density.
    ///
    /// # Errors
    /// [`MoistureError::OutOfRange`].
    pub fn new(species: &Species, moisture: Option<f64>) -> Result<Option<Self>, MoistureError> {
        let (moisture, moisture_from) = moistures(species, moisture);
        let shrinkage = volumetric_shrinkage(species);
        let shrunk = |moisture: f64| -> Result<f64, MoistureError> {
            Ok(1.0 - shrinkage * drying(moisture, FIBRE_SATURATION_PERCENT)?)
        };
        let shrunk_by = [shrunk(moisture[0])?, shrunk(moisture[1])?];
        let green = species.green.as_ref().and_then(|g| g.specific_gravity);
        let dry = species.dry.specific_gravity;
        let (gravity, basic_density_from) = match (green, dry) {
            (Some(green), _) => (green, "the table's specific gravity of green wood"),
            // The mass is the same, the volume at 12 % is smaller than the green one.
            (None, Some(dry)) => (
                dry * shrunk(12.0)?,
                "the table's specific gravity at 12 % moisture, less shrinkage",
            ),
            (None, None) => return Ok(None),
        };
        Ok(Some(WoodMass {
            basic_density: gravity * WATER_DENSITY,
            basic_density_from,
            moisture,
            moisture_from,
            shrunk: shrunk_by,
        }))
    }

    /// Density of heartwood and of sapwood with their water, kg/m³.
    pub fn densities(&self) -> [f64; 2] {
        [0, 1].map(|k| self.dry_density(k) * (1.0 + 0.01 * self.moisture[k]))
    }

    /// Oven-dry mass over volume at this moisture, kg/m³.
    fn dry_density(&self, part: usize) -> f64 {
        self.basic_density / self.shrunk[part]
    }

    /// Returns the mass of volumes (m³) of heartwood and sapwood.
    pub(super) fn report(&self, volumes: [f64; 2]) -> MassReport {
        let sum = |of: &dyn Fn(usize) -> f64| of(0) + of(1);
        let dry_mass = sum(&|k| self.dry_density(k) * volumes[k]);
        let mass = sum(&|k| self.densities()[k] * volumes[k]);
        let volume = volumes[0] + volumes[1];
        let over = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        MassReport {
            basic_density_kg_m3: self.basic_density,
            basic_density_from: self.basic_density_from.to_owned(),
            heartwood_moisture_percent: self.moisture[0],
            sapwood_moisture_percent: self.moisture[1],
            moisture_from: self.moisture_from.to_owned(),
            heartwood_m3: volumes[0],
            sapwood_m3: volumes[1],
            dry_mass_kg: dry_mass,
            mass_kg: mass,
            density_kg_m3: over(mass, volume),
            moisture_percent: 100.0 * over(mass - dry_mass, dry_mass),
        }
    }
}

/// Moisture of heartwood and sapwood, %, and where it comes from.
fn moistures(species: &Species, given: Option<f64>) -> ([f64; 2], &'static str) {
    if let Some(moisture) = given {
        return ([moisture; 2], "given");
    }
    let own = [
        species.green_heartwood_percent,
        species.green_sapwood_percent,
    ];
    let mean = |of: fn(&Species) -> Option<f64>| group_mean(species.group, of);
    match own {
        [Some(heartwood), Some(sapwood)] => {
            ([heartwood, sapwood], "Wood Handbook, Table 4-1, green wood")
        }
        [heartwood, sapwood] => (
            [
                heartwood.unwrap_or_else(|| mean(|s| s.green_heartwood_percent)),
                sapwood.unwrap_or_else(|| mean(|s| s.green_sapwood_percent)),
            ],
            "an estimate: the mean of its group's species in Wood Handbook, Table 4-1, green wood",
        ),
    }
}

/// Mean over the species of a group that have a value.
fn group_mean(group: Group, of: fn(&Species) -> Option<f64>) -> f64 {
    let of_group = Species::all().iter().filter(|s| s.group == group);
    let known: Vec<f64> = of_group.filter_map(of).collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

/// Shrinkage of the volume from green to oven-dry; the sum of both directions where it is not known, as along the grain
/// wood hardly shrinks, or 0 where that is not known either.
fn volumetric_shrinkage(species: &Species) -> f64 {
    let s = species.shrinkage;
    let sum = s.radial.zip(s.tangential).map(|(r, t)| r + t);
    s.volumetric.or(sum).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn green_and_dry_wood_weigh_what_the_tables_say() {
        let ash = Species::find("white ash").unwrap();
        let green = WoodMass::new(ash, None).unwrap().unwrap();
        let report = green.report([1.0, 1.0]);
        // Specific gravity 0.55 green; 46 % moisture in heartwood, 44 % in sapwood.
        assert_eq!(report.basic_density_kg_m3, 550.0);
        assert!((report.dry_mass_kg - 1100.0).abs() < 1e-9);
        assert!((report.mass_kg - 550.0 * (1.46 + 1.44)).abs() < 1e-9);
        assert!((report.moisture_percent - 45.0).abs() < 1e-9);
        // At 12 % its density is that of the table: 0.60 × 1.12.
        let dry = WoodMass::new(ash, Some(12.0)).unwrap().unwrap();
        let density = dry.report([0.5, 0.5]).density_kg_m3;
        assert!((density / 672.0 - 1.0).abs() < 0.02, "{density}");
        assert!(WoodMass::new(ash, Some(300.0)).is_err());
    }

    #[test]
    fn what_no_table_has_is_called_an_estimate() {
        let spruce = Species::find("red spruce").unwrap();
        let mass = WoodMass::new(spruce, None).unwrap().unwrap();
        let report = mass.report([1.0, 1.0]);
        assert!(report.moisture_from.contains("estimate"));
        assert!(report.sapwood_moisture_percent > report.heartwood_moisture_percent);
    }
}
