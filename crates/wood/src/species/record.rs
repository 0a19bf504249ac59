//! A species' record: what has been measured of its wood, in SI units.

use super::genus::{HeartwoodColour, RingCharacter};
use serde::{Deserialize, Serialize};

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

/// A row of Tables 5-1 and 5-2: E_R, E_T, G_LR, G_LT, G_RT over E_L, then ν_LR, ν_LT, ν_RT.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ElasticRow {
    pub name: &'static str,
    pub group: Group,
    pub ratios: [Option<f64>; 8],
}

/// Shrinkage in the three measures, as fractions of the green size; `None` where the table has no
/// value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Shrinkage {
    /// Across the rings, ε_R.
    pub radial: Option<f64>,
    /// Along the rings, ε_T.
    pub tangential: Option<f64>,
    /// Of the volume.
    pub volumetric: Option<f64>,
}

/// A species and the measured properties of its wood.
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
    /// Whether the heartwood stands out from the sapwood.
    pub heartwood_colour: Option<HeartwoodColour>,
}
