//! Moisture: strength and shrinkage of wood at a moisture content (Wood Handbook, chapters 4 and
//! 5).
//!
//! Moisture contents are percent of the oven-dry mass, as the field writes them.

use crate::species::{GreenEstimate, Property, Shrinkage, Species};
use serde::{Deserialize, Serialize};

/// Moisture content at which the tables give dry wood, percent.
pub const AIR_DRY_PERCENT: f64 = 12.0;
/// Fibre saturation: shrinkage begins below it (Wood Handbook, chapter 4), percent.
pub const FIBRE_SATURATION_PERCENT: f64 = 30.0;
/// The lower value of fibre saturation in use, percent.
pub const FIBRE_SATURATION_LOW_PERCENT: f64 = 28.0;
/// Mp of Eq. 5-3 for species that are not in Table 5-13, percent.
pub const INTERSECTION_PERCENT: f64 = 25.0;
/// Below this Eq. 5-3 is not supported by tests, percent.
pub const EQUATION_LOWER_PERCENT: f64 = 8.0;
/// The wettest wood in use: green sapwood of light species holds up to about this, percent.
pub const WETTEST_PERCENT: f64 = 200.0;

/// Words that stand for moisture contents: green wood holds more water than its cell walls take up.
pub const MOISTURE_WORDS: &[(&str, f64)] = &[("green", FIBRE_SATURATION_PERCENT)];

/// What went wrong when a property was asked for at a moisture content.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MoistureError {
    /// Not a number, or outside 0..=200 %.
    #[error(
        "moisture content is {0} %, but it must be above 0 and at most 200 % of the oven-dry mass"
    )]
    OutOfRange(f64),
    /// The tables have no dry value of this property.
    #[error("{species} has no {property} in {source_table}")]
    NoValue {
        /// The species' name.
        species: String,
        /// What was asked for.
        property: Property,
        /// Where the species' values come from.
        source_table: String,
    },
    /// Eq. 5-3 needs the green value.
    #[error(
        "{species} has no green {property} in the tables, so it is known at 12 % moisture only, not at \
         {moisture} %; ask at 12 %, or accept an estimate"
    )]
    NoGreenValue {
        /// The species' name.
        species: String,
        /// What was asked for.
        property: Property,
        /// The moisture content asked for, percent.
        moisture: f64,
    },
    /// The Wood Handbook excludes this property from Eq. 5-3.
    #[error(
        "{property} does not follow Eq. 5-3 of the Wood Handbook, so for {species} it is known at 12 % and \
         in the green state only, not at {moisture} %"
    )]
    NotAdjustable {
        /// The species' name.
        species: String,
        /// What was asked for.
        property: Property,
        /// The moisture content asked for, percent.
        moisture: f64,
    },
    /// Fibre saturation outside 28..=30 %.
    #[error("fibre saturation is {0} %, but it must be from 28 to 30 %")]
    FibreSaturation(f64),
}

/// What to do for a species that is known at 12 % only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fallback {
    /// Fail, saying which value is missing.
    Refuse,
    /// Estimate the green value by its group's mean ratio ([`Species::estimate_green`]) and say so in [`Adjusted::basis`]; take the 12 %
    /// value unchanged between 12 % and green where Eq. 5-3 does not hold.
    Estimate,
}

/// How a value at a moisture content came about, from the best supported to the least. Its
/// `Display` is a note for a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Basis {
    /// The table's value at 12 %.
    TableDry,
    /// The table's green value; the moisture content is at or above Mp.
    TableGreen,
    /// Eq. 5-3 between the dry and the green value.
    Equation,
    /// Eq. 5-3 below the 8 % down to which tests support it.
    EquationBelowRange,
    /// From the 12 % value and the mean ratio of green to dry wood in the species' group, for want of a green value.
    Estimate {
        /// Leave-one-out error, in percent of the value.
        error_percent: u8,
    },
    /// The 12 % value, unchanged, for want of a rule.
    Unadjusted,
}

impl std::fmt::Display for Basis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Basis::Estimate { error_percent } => {
                return write!(
                    f,
                    "estimated from the 12 % value by the mean ratio of green to dry wood in its group, ± {error_percent} %"
                );
            }
            Basis::TableDry => "table value at 12 % moisture",
            Basis::TableGreen => "table value of green wood",
            Basis::Equation => "adjusted for moisture by Eq. 5-3 of the Wood Handbook",
            Basis::EquationBelowRange => {
                "adjusted for moisture by Eq. 5-3 of the Wood Handbook, below the 8 % to which it is tested"
            }
            Basis::Unadjusted => "table value at 12 % moisture, not adjusted for want of a rule",
        })
    }
}

/// A property at a moisture content, and how it came about.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Adjusted {
    /// The value in the property's SI unit.
    pub value: f64,
    /// Where it comes from.
    pub basis: Basis,
}

/// Wood Handbook Eq. 5-3: P = P12 (P12/Pg)^((12 − M)/(Mp − 12)), and Pg at and above Mp.
///
/// `dry` and `green` are the property at 12 % and green, both above 0; `moisture` and
/// `intersection` (Mp) in percent, Mp above 12.
pub fn equation_5_3(dry: f64, green: f64, moisture: f64, intersection: f64) -> f64 {
    if moisture >= intersection {
        return green;
    }
    dry * (dry / green).powf((AIR_DRY_PERCENT - moisture) / (intersection - AIR_DRY_PERCENT))
}

/// The part of the total shrinkage (green to oven-dry) that has happened at `moisture`: 0 at fibre
/// saturation and above, 1 oven-dry, linear between. All in percent.
///
/// # Errors
/// A moisture content outside 0..=200 %, or fibre saturation outside 28..=30 %.
pub fn drying(moisture: f64, fibre_saturation: f64) -> Result<f64, MoistureError> {
    if !(0.0..=WETTEST_PERCENT).contains(&moisture) {
        return Err(MoistureError::OutOfRange(moisture));
    }
    if !(FIBRE_SATURATION_LOW_PERCENT..=FIBRE_SATURATION_PERCENT).contains(&fibre_saturation) {
        return Err(MoistureError::FibreSaturation(fibre_saturation));
    }
    Ok(((fibre_saturation - moisture) / fibre_saturation).max(0.0))
}

impl Species {
    /// Mp of Eq. 5-3 in percent: Table 5-13's, or 25 % for species that are not in it.
    pub fn intersection_percent(&self) -> f64 {
        self.intersection_percent.unwrap_or(INTERSECTION_PERCENT)
    }

    /// `property` at `moisture` percent (0 < M ≤ 200).
    ///
    /// # Errors
    /// [`MoistureError::NoValue`] where the tables have none; [`MoistureError::NoGreenValue`] and
    /// [`MoistureError::NotAdjustable`] where only 12 % is known, or no rule leads from it, and `fallback` is
    /// [`Fallback::Refuse`].
    pub fn property_at(
        &self,
        property: Property,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<Adjusted, MoistureError> {
        if !(moisture > 0.0 && moisture <= WETTEST_PERCENT) {
            return Err(MoistureError::OutOfRange(moisture));
        }
        let Some(dry) = self.dry.get(property) else {
            return Err(MoistureError::NoValue {
                species: self.name.clone(),
                property,
                source_table: self.source.clone(),
            });
        };
        if (moisture - AIR_DRY_PERCENT).abs() < 1e-9 {
            return Ok(Adjusted {
                value: dry,
                basis: Basis::TableDry,
            });
        }
        let green = self.green.as_ref().and_then(|g| g.get(property));
        let intersection = self.intersection_percent();
        let failure = match green {
            Some(value) if moisture >= intersection => {
                return Ok(Adjusted {
                    value,
                    basis: Basis::TableGreen,
                });
            }
            Some(green) if property.follows_equation_5_3() => {
                let basis = if moisture < EQUATION_LOWER_PERCENT {
                    Basis::EquationBelowRange
                } else {
                    Basis::Equation
                };
                return Ok(Adjusted {
                    value: equation_5_3(dry, green, moisture, intersection),
                    basis,
                });
            }
            Some(_) => MoistureError::NotAdjustable {
                species: self.name.clone(),
                property,
                moisture,
            },
            None => MoistureError::NoGreenValue {
                species: self.name.clone(),
                property,
                moisture,
            },
        };
        match fallback {
            Fallback::Refuse => Err(failure),
            Fallback::Estimate => Ok(self.estimate_at(property, dry, moisture)),
        }
    }

    /// Returns an estimate of `property` at `moisture` percent from its 12 % value; that value itself where there is no rule.
    fn estimate_at(&self, property: Property, dry: f64, moisture: f64) -> Adjusted {
        let known = self.green.as_ref().and_then(|g| g.get(property));
        let intersection = self.intersection_percent();
        let is_green = moisture >= intersection;
        let estimate = (self.estimate_green(property))
            .filter(|_| known.is_none() && (is_green || property.follows_equation_5_3()));
        let Some(GreenEstimate { value, error }) = estimate else {
            return Adjusted {
                value: dry,
                basis: Basis::Unadjusted,
            };
        };
        // The error of the green value enters Eq. 5-3 by the same power.
        let part = (moisture - AIR_DRY_PERCENT) / (intersection - AIR_DRY_PERCENT);
        let error = 100.0 * error * part.abs().min(1.0);
        Adjusted {
            value: equation_5_3(dry, value, moisture, intersection),
            basis: Basis::Estimate {
                error_percent: error.round() as u8,
            },
        }
    }

    /// Shrinkage from green down to `moisture` percent: the species' total times [`drying`].
    ///
    /// # Errors
    /// Those of [`drying`].
    pub fn shrinkage_at(
        &self,
        moisture: f64,
        fibre_saturation: f64,
    ) -> Result<Shrinkage, MoistureError> {
        let part = drying(moisture, fibre_saturation)?;
        Ok(Shrinkage {
            radial: self.shrinkage.radial.map(|e| e * part),
            tangential: self.shrinkage.tangential.map(|e| e * part),
            volumetric: self.shrinkage.volumetric.map(|e| e * part),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn species(name: &str) -> &'static Species {
        Species::find(name).unwrap()
    }

    #[test]
    fn white_ash_at_18_percent_is_the_geometric_mean_of_dry_and_green() {
        // Mp of white ash is 24 %, so 18 % is half way in the exponent: sqrt(103 × 66) MPa.
        let ash = species("white ash");
        let r = ash
            .property_at(Property::ModulusOfRupture, 18.0, Fallback::Refuse)
            .unwrap();
        assert!((r.value - (103e6_f64 * 66e6).sqrt()).abs() < 1.0, "{r:?}");
        assert_eq!(r.basis, Basis::Equation);
        let g = ash
            .property_at(Property::ModulusOfRupture, 60.0, Fallback::Refuse)
            .unwrap();
        assert_eq!(
            g,
            Adjusted {
                value: 66e6,
                basis: Basis::TableGreen
            }
        );
        let d = ash
            .property_at(Property::ModulusOfRupture, 6.0, Fallback::Refuse)
            .unwrap();
        assert!((d.value - 103e6 * (103.0_f64 / 66.0).sqrt()).abs() < 1.0);
        assert_eq!(d.basis, Basis::EquationBelowRange);
    }

    #[test]
    fn species_without_green_values_refuses_or_says_so() {
        let alder = species("red alder");
        let ask = |f| alder.property_at(Property::ModulusOfRupture, 60.0, f);
        let message = ask(Fallback::Refuse).unwrap_err().to_string();
        assert!(
            message.contains("Alder, red") && message.contains("60 %"),
            "{message}"
        );
        // The mean of six hardwoods is 1.169 times their crushing strength at 12 %, and each misses that of the other five by
        // 8 % (root mean square).
        let estimate = ask(Fallback::Estimate).unwrap();
        assert!(
            (estimate.value / 40.1e6 - 1.1685).abs() < 5e-4,
            "{estimate:?}"
        );
        assert_eq!(estimate.basis, Basis::Estimate { error_percent: 8 });
        // Half way between 12 % and Mp, in the exponent of Eq. 5-3, the error is half as large.
        let middle = 0.5 * (12.0 + alder.intersection_percent());
        let half = alder
            .property_at(Property::ModulusOfRupture, middle, Fallback::Estimate)
            .unwrap();
        assert!((half.value / (estimate.value * 68e6).sqrt() - 1.0).abs() < 1e-9);
        assert_eq!(half.basis, Basis::Estimate { error_percent: 4 });
        assert!(
            alder
                .property_at(Property::ModulusOfRupture, 12.0, Fallback::Refuse)
                .is_ok()
        );
    }

    #[test]
    fn estimated_green_wood_has_a_ratio_of_strengths_that_was_measured() {
        // The two hardwoods and the softwood with the highest ratio of rupture to crushing strength at 12 %, and the lowest.
        for (name, range) in [
            ("hickory, nutmeg", 2.24..2.41),
            ("oak, water", 2.24..2.41),
            ("Fraxinus excelsior", 2.24..2.41),
            ("cedar, Atlantic white", 1.97..2.29),
        ] {
            let species = Species::find(name).unwrap();
            let green = |p| {
                species
                    .property_at(p, 60.0, Fallback::Estimate)
                    .unwrap()
                    .value
            };
            let ratio = green(Property::ModulusOfRupture) / green(Property::CompressionParallel);
            assert!(range.contains(&ratio), "{name}: {ratio}");
        }
        // And in no species is green wood stronger than dry wood.
        for species in Species::all() {
            let at = |moisture| {
                let value =
                    species.property_at(Property::ModulusOfRupture, moisture, Fallback::Estimate);
                value.map(|v| v.value)
            };
            if let (Ok(dry), Ok(green)) = (at(12.0), at(60.0)) {
                let ratio = green / dry;
                let unknown = (ratio - 1.0).abs() < 1e-12;
                assert!(
                    unknown || (0.40..0.85).contains(&ratio),
                    "{}: {ratio}",
                    species.name
                );
            }
        }
    }

    #[test]
    fn erratic_properties_and_bad_moistures_are_refused() {
        let ash = species("white ash");
        let work = |m| ash.property_at(Property::WorkToMaximumLoad, m, Fallback::Refuse);
        assert!(matches!(
            work(18.0),
            Err(MoistureError::NotAdjustable { .. })
        ));
        assert_eq!(work(40.0).unwrap().value, 108e3);
        let between = ash.property_at(Property::WorkToMaximumLoad, 18.0, Fallback::Estimate);
        assert_eq!(between.unwrap().basis, Basis::Unadjusted);
        for bad in [0.0, -1.0, 201.0, f64::NAN] {
            assert!(
                matches!(work(bad), Err(MoistureError::OutOfRange(_))),
                "{bad}"
            );
        }
    }

    #[test]
    fn shrinkage_follows_drying() {
        let oak = species("oak, white");
        let at = |m| oak.shrinkage_at(m, FIBRE_SATURATION_PERCENT).unwrap();
        assert!((at(12.0).tangential.unwrap() - 0.105 * 0.6).abs() < 1e-12);
        assert_eq!(at(80.0).radial, Some(0.0));
        assert_eq!(at(0.0).volumetric, Some(0.163));
        assert_eq!(
            species("tamarack").shrinkage_at(12.0, 28.0).unwrap().radial,
            None
        );
        assert!(oak.shrinkage_at(12.0, 25.0).is_err());
    }
}
