//! Species: what has been measured of the wood of 116 of them, and what follows for how it breaks.
//!
//! Values are those of clear, straight-grained wood; a species has only what its table has. Tables
//! and their terms are listed in `data/SOURCES.md`.

mod anatomy;
mod names;
mod strength;
mod table;

pub use anatomy::{HeartwoodColour, RingCharacter};
pub use names::{UnknownSpecies, nearest, suggestion};
pub use strength::{
    DEFAULT_BUNDLE_DIAMETER, FractureHeight, HeightRule, StrengthError, nominal_bending_strength,
    tensile_strength_from_bending,
};

use crate::moisture::Shrinkage;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Broadleaved or coniferous.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Broadleaved trees.
    Hardwood,
    /// Conifers.
    Softwood,
}

/// The columns of Table 5-3a in SI units; `None` where the table has no value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MechanicalProperties {
    /// Oven-dry mass over the volume at the stated moisture, relative to water.
    pub specific_gravity: Option<f64>,
    /// Modulus of rupture in static bending, Pa.
    pub modulus_of_rupture: Option<f64>,
    /// Modulus of elasticity in static bending, Pa.
    pub modulus_of_elasticity: Option<f64>,
    /// Work to maximum load in static bending, J/m³.
    pub work_to_maximum_load: Option<f64>,
    /// Height of drop of the 22.7 kg hammer that breaks the specimen, m.
    pub impact_height: Option<f64>,
    /// Crushing strength along the grain, Pa.
    pub compression_parallel: Option<f64>,
    /// Stress at the proportional limit in compression across the grain, Pa.
    pub compression_perpendicular: Option<f64>,
    /// Shear strength along the grain, Pa.
    pub shear_parallel: Option<f64>,
    /// Tensile strength across the grain, Pa.
    pub tension_perpendicular: Option<f64>,
    /// Side hardness (Janka), N.
    pub side_hardness: Option<f64>,
}

/// A column of [`MechanicalProperties`] that depends on moisture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Property {
    /// Pa.
    ModulusOfRupture,
    /// Pa.
    ModulusOfElasticity,
    /// J/m³.
    WorkToMaximumLoad,
    /// m.
    ImpactHeight,
    /// Pa.
    CompressionParallel,
    /// Pa.
    CompressionPerpendicular,
    /// Pa.
    ShearParallel,
    /// Pa.
    TensionPerpendicular,
    /// N.
    SideHardness,
}

impl Property {
    /// All properties in the table's order.
    pub const ALL: [Property; 9] = [
        Property::ModulusOfRupture,
        Property::ModulusOfElasticity,
        Property::WorkToMaximumLoad,
        Property::ImpactHeight,
        Property::CompressionParallel,
        Property::CompressionPerpendicular,
        Property::ShearParallel,
        Property::TensionPerpendicular,
        Property::SideHardness,
    ];

    /// The field's name of the property.
    pub const fn name(self) -> &'static str {
        match self {
            Property::ModulusOfRupture => "modulus of rupture",
            Property::ModulusOfElasticity => "modulus of elasticity",
            Property::WorkToMaximumLoad => "work to maximum load",
            Property::ImpactHeight => "impact bending height",
            Property::CompressionParallel => "compression strength parallel to the grain",
            Property::CompressionPerpendicular => "compression strength perpendicular to the grain",
            Property::ShearParallel => "shear strength parallel to the grain",
            Property::TensionPerpendicular => "tension strength perpendicular to the grain",
            Property::SideHardness => "side hardness",
        }
    }

    /// Symbol of the SI unit.
    pub const fn unit(self) -> &'static str {
        match self {
            Property::WorkToMaximumLoad => "J/m³",
            Property::ImpactHeight => "m",
            Property::SideHardness => "N",
            _ => "Pa",
        }
    }

    /// The Wood Handbook keeps work to maximum load, impact bending and tension across the grain
    /// out of Eq. 5-3, because they respond erratically to moisture.
    pub const fn follows_equation_5_3(self) -> bool {
        !matches!(
            self,
            Property::WorkToMaximumLoad | Property::ImpactHeight | Property::TensionPerpendicular
        )
    }
}

impl std::fmt::Display for Property {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl MechanicalProperties {
    /// The value of `property` in its SI unit; `None` where the table has none.
    pub fn get(&self, property: Property) -> Option<f64> {
        match property {
            Property::ModulusOfRupture => self.modulus_of_rupture,
            Property::ModulusOfElasticity => self.modulus_of_elasticity,
            Property::WorkToMaximumLoad => self.work_to_maximum_load,
            Property::ImpactHeight => self.impact_height,
            Property::CompressionParallel => self.compression_parallel,
            Property::CompressionPerpendicular => self.compression_perpendicular,
            Property::ShearParallel => self.shear_parallel,
            Property::TensionPerpendicular => self.tension_perpendicular,
            Property::SideHardness => self.side_hardness,
        }
    }
}

/// A species and what is known of its wood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Species {
    /// Common name as in the table: "Alder, red".
    pub name: String,
    /// Scientific name without author.
    pub scientific_name: String,
    /// Broadleaved or coniferous.
    pub group: Group,
    /// The table that the dry values are from.
    pub source: String,
    /// The table that the green values are from.
    pub green_source: Option<String>,
    /// Mass over volume at 12 % moisture, kg/m³.
    pub air_dry_density: Option<f64>,
    /// Properties at 12 % moisture ("air-dry" for Yang's four species).
    pub dry: MechanicalProperties,
    /// Properties of green wood; `None` for species whose green row is not in the tables.
    pub green: Option<MechanicalProperties>,
    /// Hardness of the end grain, N; known for Yang's four species only.
    pub end_hardness: Option<f64>,
    /// Load per width that splits the wood, R_C of Eq. 9, N/m; known for Yang's four species only.
    pub splitting_resistance: Option<f64>,
    /// Total shrinkage, green to oven-dry.
    pub shrinkage: Shrinkage,
    /// Moisture content of green heartwood, percent.
    pub green_heartwood_percent: Option<f64>,
    /// Moisture content of green sapwood, percent.
    pub green_sapwood_percent: Option<f64>,
    /// Mp of Table 5-13, percent; see [`Species::intersection_percent`] for the one to use.
    pub intersection_percent: Option<f64>,
    /// How rings look.
    pub ring_character: Option<RingCharacter>,
    /// Whether heartwood stands out.
    pub heartwood_colour: Option<HeartwoodColour>,
}

static ALL: LazyLock<Vec<Species>> = LazyLock::new(table::read);

impl Species {
    /// All species: the 112 of the Wood Handbook in its order, then the four of Yang's Table 1.
    pub fn all() -> &'static [Species] {
        &ALL
    }

    /// The species of a name: "alder, red", "red alder" or "Alnus rubra"; case, hyphens and spaces
    /// do not matter. Where several rows share a scientific name the first in the table is meant.
    ///
    /// # Errors
    /// [`UnknownSpecies`] with up to three names that are near.
    pub fn find(name: &str) -> Result<&'static Species, UnknownSpecies> {
        names::find(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_have_116_species_of_which_27_are_known_green() {
        let all = Species::all();
        assert_eq!(all.len(), 116);
        assert_eq!(
            all.iter().filter(|s| s.source.contains("5-3a")).count(),
            112
        );
        assert_eq!(all.iter().filter(|s| s.green.is_some()).count(), 27);
        // 79 rows of Table 4-3 of which nine are no species of Table 5-3a, and Yang's four.
        assert_eq!(
            all.iter().filter(|s| s.shrinkage.radial.is_some()).count(),
            70 + 4
        );
        assert_eq!(
            all.iter()
                .filter(|s| s.green_heartwood_percent.is_some())
                .count(),
            16
        );
        // Thirteen names, one of which joins four Douglas-firs and one two redwoods.
        assert_eq!(
            all.iter()
                .filter(|s| s.intersection_percent.is_some())
                .count(),
            17
        );
        assert!(all.iter().all(|s| s.ring_character.is_some()));
        assert!(
            all.iter()
                .all(|s| s.dry.modulus_of_rupture.is_some_and(f64::is_finite))
        );
    }

    #[test]
    fn every_name_finds_its_species() {
        for s in Species::all() {
            assert_eq!(Species::find(&s.name).unwrap().name, s.name);
            assert_eq!(Species::find(&s.name.to_uppercase()).unwrap().name, s.name);
            let by_science = Species::find(&s.scientific_name).unwrap();
            let shared = s.name.starts_with("Douglas-fir") || s.name.starts_with("Redwood");
            let yang = s.name == "Cedar, eastern redcedar";
            assert!(
                by_science.name == s.name || shared || yang,
                "{}",
                s.scientific_name
            );
        }
        for (alias, target) in names::ALIASES {
            assert_eq!(Species::find(alias).unwrap().name, *target);
        }
        let name = |n| Species::find(n).map(|s| s.name.as_str());
        assert_eq!(name("red  Alder"), Ok("Alder, red"));
        assert_eq!(name("pignut hickory"), Ok("Hickory (true), pignut"));
        assert_eq!(name("yellow poplar"), Ok("Yellow-poplar"));
        assert_eq!(name("Pseudotsuga menziesii"), Ok("Douglas-fir, coast"));
        assert_eq!(name("Eastern redcedar"), Ok("Cedar, eastern redcedar"));
    }

    #[test]
    fn a_misspelt_name_suggests_the_right_one() {
        let nearest = |n: &str| Species::find(n).unwrap_err().nearest;
        assert_eq!(nearest("sitka spurce")[0], "Spruce, Sitka");
        assert_eq!(nearest("Quercus albs")[0], "Oak, white");
        assert!(nearest("oak").iter().all(|n| n.starts_with("Oak")));
        assert!(nearest("xyzzy plugh").is_empty());
        let message = Species::find("whit ash").unwrap_err().to_string();
        assert!(message.starts_with("unknown species \"whit ash\"; did you mean \"Ash, white\""));
    }

    #[test]
    fn values_are_in_si_units() {
        let oak = Species::find("white oak").unwrap();
        assert_eq!(oak.dry.modulus_of_rupture, Some(105e6));
        assert_eq!(oak.dry.modulus_of_elasticity, Some(12.3e9));
        assert_eq!(oak.dry.work_to_maximum_load, Some(102e3));
        assert_eq!(oak.dry.impact_height, Some(940.0 * 1e-3));
        assert_eq!(oak.green.as_ref().unwrap().side_hardness, Some(4700.0));
        assert_eq!(oak.air_dry_density.map(f64::round), Some(762.0));
        assert_eq!(oak.shrinkage.tangential, Some(0.105));
    }
}
