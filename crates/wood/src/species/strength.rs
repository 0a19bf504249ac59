//! Strength that no table has: tension along the grain from bending, and the height of a broken
//! face.
//!
//! # Tension from bending
//! A rectangular section of depth h bends until its outermost fibre in tension reaches f_t. Wood is
//! linear in tension; in compression it is linear with the same modulus up to f_c and yields there
//! (elastic, perfectly plastic). With m = f_t/f_c ≥ 1 and plane sections, the tension zone is x_t
//! deep, elastic compression x_t/m, and plastic compression takes the rest:
//!
//! - forces: ½ m f_c x_t = ½ f_c x_t/m + f_c (h − x_t − x_t/m), hence x_t = 2m h/(m + 1)², elastic
//!   compression 2h/(m + 1)², plastic compression h (m − 1)/(m + 1);
//! - moment about the neutral axis, over the section modulus h²/6 per width:
//!   **MOR = f_c (3m − 1)/(m + 1)**.
//!
//! Solved for the tensile strength: **f_t = f_c (MOR + f_c)/(3 f_c − MOR)** for f_c ≤ MOR < 3 f_c.
//! At MOR = f_c nothing yields and f_t = MOR; below that the section breaks in tension while still
//! linear, and f_t = MOR too. At MOR ≥ 3 f_c no tensile strength is high enough: the two values do
//! not belong together.

use super::{Property, Species};
use crate::moisture::{Adjusted, Fallback, MoistureError};
use serde::{Deserialize, Serialize};

/// Diameter of the fibre bundle that pulls out whole, m: about the width of one annual ring, since
/// earlywood lets go before latewood does.
pub const DEFAULT_BUNDLE_DIAMETER: f64 = 1e-3;

/// Why a strength or a height cannot be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StrengthError {
    /// A table value is missing, or cannot be had at this moisture content.
    #[error(transparent)]
    Moisture(#[from] MoistureError),
    /// Section analysis has no answer.
    #[error(
        "a modulus of rupture of {rupture} Pa with a compression strength of {compression} Pa gives no tensile \
         strength: the first must be above 0 and below three times the second"
    )]
    Section {
        /// Modulus of rupture, Pa.
        rupture: f64,
        /// Compression strength along the grain, Pa.
        compression: f64,
    },
    /// Eq. 9 was asked for a species outside its fit.
    #[error(
        "Eq. 9 (Yang 2019) is fitted to four species (temple juniper, Chinese juniper, tree-of-heaven, goldenrain \
         tree) and gives negative heights for others, so not for {0}; use the shear-lag length"
    )]
    OutsideFit(String),
    /// A length that must be above zero is not.
    #[error("{what} is {value} m, but it must be a length above 0")]
    Length {
        /// Which length.
        what: &'static str,
        /// The value found, m.
        value: f64,
    },
}

/// Where a fracture height comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeightRule {
    /// Yang's regression, for its four species.
    Eq9,
    /// Pull-out of a fibre bundle, ℓ = f_t d/(4 f_v).
    ShearLag,
}

impl std::fmt::Display for HeightRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            HeightRule::Eq9 => "Eq. 9 of Yang 2019",
            HeightRule::ShearLag => "shear-lag length of a fibre bundle",
        })
    }
}

/// How high a broken face stands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FractureHeight {
    /// Which rule gave it.
    pub rule: HeightRule,
    /// Height over the stem's radius.
    pub ratio: f64,
    /// What is known of the table values behind it.
    pub basis: crate::moisture::Basis,
}

/// Modulus of rupture (Pa) of a rectangular section whose wood fails at `tension` and yields at
/// `compression` (both Pa, above 0).
pub fn nominal_bending_strength(tension: f64, compression: f64) -> f64 {
    let m = tension / compression;
    if m <= 1.0 {
        tension
    } else {
        compression * (3.0 * m - 1.0) / (m + 1.0)
    }
}

/// Tensile strength along the grain (Pa) from modulus of rupture and compression strength (Pa), by
/// the section analysis above.
///
/// # Errors
/// [`StrengthError::Section`] unless 0 < `rupture` < 3 `compression`.
pub fn tensile_strength_from_bending(rupture: f64, compression: f64) -> Result<f64, StrengthError> {
    if !(rupture > 0.0 && rupture < 3.0 * compression) {
        return Err(StrengthError::Section {
            rupture,
            compression,
        });
    }
    if rupture <= compression {
        return Ok(rupture);
    }
    Ok(compression * (rupture + compression) / (3.0 * compression - rupture))
}

impl Species {
    /// Tensile strength along the grain, Pa, at `moisture` percent, from modulus of rupture and
    /// compression strength.
    ///
    /// # Errors
    /// Where either is missing or has no value at this moisture content, or both do not fit
    /// together.
    pub fn tensile_strength_at(
        &self,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<Adjusted, StrengthError> {
        let rupture = self.property_at(Property::ModulusOfRupture, moisture, fallback)?;
        let crushing = self.property_at(Property::CompressionParallel, moisture, fallback)?;
        Ok(Adjusted {
            value: tensile_strength_from_bending(rupture.value, crushing.value)?,
            basis: rupture.basis.max(crushing.basis),
        })
    }

    /// Shear-lag length ℓ = f_t d/(4 f_v), m: how far a fibre bundle of diameter `bundle_diameter`
    /// (m; see [`DEFAULT_BUNDLE_DIAMETER`]) pulls out of the wood around it.
    ///
    /// # Errors
    /// As [`Species::tensile_strength_at`]; also where shear strength is missing (Yang's four
    /// species, and a few more).
    pub fn shear_lag_length(
        &self,
        bundle_diameter: f64,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<Adjusted, StrengthError> {
        positive("the fibre bundle's diameter", bundle_diameter)?;
        let tension = self.tensile_strength_at(moisture, fallback)?;
        let shear = self.property_at(Property::ShearParallel, moisture, fallback)?;
        Ok(Adjusted {
            value: tension.value * bundle_diameter / (4.0 * shear.value),
            basis: tension.basis.max(shear.basis),
        })
    }

    /// Height over radius by Yang's Eq. 9, for air-dry branches of about 1 cm of its four species.
    ///
    /// The paper writes the equation with the diameter; its numbers are reproduced with the radius.
    ///
    /// # Errors
    /// [`StrengthError::OutsideFit`] for every other species.
    pub fn equation_9(&self) -> Result<f64, StrengthError> {
        let outside = || StrengthError::OutsideFit(self.name.clone());
        let splitting = self.splitting_resistance.ok_or_else(outside)?;
        let density = self.air_dry_density.ok_or_else(outside)?;
        let rupture = self.dry.modulus_of_rupture.ok_or_else(outside)?;
        let elasticity = self.dry.modulus_of_elasticity.ok_or_else(outside)?;
        // The fit's units: g/cm³, MPa, GPa and kgf/cm.
        Ok(39.5271 * (density / 1000.0)
            - 0.2121 * (rupture / 1e6)
            - 0.3708 * (elasticity / 1e9)
            - 0.2409 * (splitting / 980.665))
    }

    /// Height of the broken face over the radius of a stem of `radius` m: by Eq. 9 for its four
    /// species when air-dry (12 %), by the shear-lag length otherwise.
    ///
    /// # Errors
    /// As [`Species::shear_lag_length`], or a radius that is not above 0.
    pub fn fracture_height(
        &self,
        radius: f64,
        bundle_diameter: f64,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<FractureHeight, StrengthError> {
        positive("the stem's radius", radius)?;
        if let Ok(ratio) = self.equation_9() {
            // The fit knows air-dry wood only; asking for the modulus of rupture says what that
            // means at this moisture.
            let known = self.property_at(Property::ModulusOfRupture, moisture, fallback)?;
            return Ok(FractureHeight {
                rule: HeightRule::Eq9,
                ratio,
                basis: known.basis,
            });
        }
        let length = self.shear_lag_length(bundle_diameter, moisture, fallback)?;
        Ok(FractureHeight {
            rule: HeightRule::ShearLag,
            ratio: length.value / radius,
            basis: length.basis,
        })
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), StrengthError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(StrengthError::Length { what, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moisture::Basis;

    #[test]
    fn equation_9_gives_the_measured_ratios_of_its_four_species_and_no_others() {
        for (name, ratio) in [
            ("Juniperus rigida", 6.6835),
            ("Juniperus virginiana", 6.6835),
            ("Juniperus chinensis", 3.025),
            ("Ailanthus altissima", 0.7462),
            ("Koelreuteria paniculata", 0.5625),
        ] {
            let got = Species::find(name).unwrap().equation_9().unwrap();
            assert!((got - ratio).abs() < 5e-3, "{name}: {got}");
        }
        assert_eq!(
            Species::all()
                .iter()
                .filter(|s| s.equation_9().is_ok())
                .count(),
            4
        );
        for name in ["white oak", "Sitka spruce"] {
            let refused = Species::find(name).unwrap().equation_9();
            assert!(matches!(refused, Err(StrengthError::OutsideFit(_))));
        }
    }

    /// Bending strength by slicing the section and bisecting for the neutral axis, with no closed
    /// form.
    fn integrated(tension: f64, compression: f64) -> f64 {
        const SLICES: usize = 20_000;
        // y from the tension edge; strain in units of failure; `axis` is the neutral axis' depth.
        let stress = |y: f64, axis: f64| (tension * (axis - y) / axis).max(-compression);
        let sum = |axis: f64, arm: bool| -> f64 {
            (0..SLICES)
                .map(|i| (i as f64 + 0.5) / SLICES as f64)
                .map(|y| stress(y, axis) * if arm { axis - y } else { 1.0 })
                .sum::<f64>()
                / SLICES as f64
        };
        let (mut low, mut high) = (1e-6, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sum(middle, false) > 0.0 {
                high = middle
            } else {
                low = middle
            }
        }
        6.0 * sum(low, true)
    }

    #[test]
    fn section_analysis_agrees_with_integrating_the_section() {
        for (tension, compression) in [(60e6, 60e6), (90e6, 50e6), (150e6, 40e6), (40e6, 60e6)] {
            let closed = nominal_bending_strength(tension, compression);
            let slices = integrated(tension, compression);
            assert!(
                (closed / slices - 1.0).abs() < 1e-6,
                "{tension} {compression}: {slices}"
            );
            let back = tensile_strength_from_bending(slices, compression).unwrap();
            assert!((back / tension - 1.0).abs() < 1e-5, "{back}");
        }
        assert!(tensile_strength_from_bending(120e6, 40e6).is_err());
        assert!(tensile_strength_from_bending(f64::NAN, 40e6).is_err());
    }

    #[test]
    fn tension_from_bending_is_near_what_is_measured_in_tension() {
        // Wood Handbook Table 5-7, tension parallel to the grain of green wood, MPa: tests in
        // tension, where here only bending and compression go in. The handbook gives tension a
        // coefficient of variation of 25 %.
        let measured = [
            ("maple, sugar", 108.2),
            ("yellow-poplar", 109.6),
            ("Douglas-fir, interior north", 107.6),
            ("fir, California red", 77.9),
            ("fir, Pacific silver", 95.1),
            ("hemlock, western", 89.6),
            ("larch, western", 111.7),
            ("pine, loblolly", 80.0),
            ("spruce, Engelmann", 84.8),
        ];
        let mut sum = 0.0;
        for (name, megapascals) in measured {
            let species = Species::find(name).unwrap();
            let got = species
                .tensile_strength_at(60.0, Fallback::Refuse)
                .unwrap()
                .value
                / 1e6;
            sum += got / megapascals;
            assert!(
                (0.6..1.4).contains(&(got / megapascals)),
                "{name}: {got} MPa"
            );
        }
        let mean = sum / measured.len() as f64;
        assert!((0.75..0.9).contains(&mean), "mean ratio {mean}");
    }

    #[test]
    fn shear_lag_by_hand_and_its_order_over_all_species() {
        // Coast Douglas-fir at 12 %: f_t = 49.9 × (85 + 49.9)/(149.7 − 85) = 104.04 MPa; /(4 × 7.8)
        // × 1 mm = 3.335 mm.
        let fir = Species::find("Douglas-fir, coast").unwrap();
        let length = fir.shear_lag_length(1e-3, 12.0, Fallback::Refuse).unwrap();
        assert!((length.value - 3.3347e-3).abs() < 1e-6, "{length:?}");
        let h = fir
            .fracture_height(5e-3, 1e-3, 12.0, Fallback::Refuse)
            .unwrap();
        assert_eq!((h.rule, h.basis), (HeightRule::ShearLag, Basis::TableDry));
        assert!((h.ratio - 0.667).abs() < 1e-3);
        let known = |s: &&Species| s.dry.shear_parallel.is_some();
        for s in Species::all().iter().filter(known) {
            let l = s
                .shear_lag_length(1e-3, 12.0, Fallback::Refuse)
                .unwrap()
                .value;
            assert!((1e-3..10e-3).contains(&l), "{}: {l}", s.name);
        }
        assert!(fir.shear_lag_length(0.0, 12.0, Fallback::Refuse).is_err());
        let ailanthus = Species::find("tree of heaven").unwrap();
        let h = ailanthus
            .fracture_height(5e-3, 1e-3, 12.0, Fallback::Refuse)
            .unwrap();
        assert_eq!(h.rule, HeightRule::Eq9);
        assert!(
            ailanthus
                .fracture_height(5e-3, 1e-3, 60.0, Fallback::Refuse)
                .is_err()
        );
    }
}
