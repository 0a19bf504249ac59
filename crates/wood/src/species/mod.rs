//! Species: the measured properties of the wood of 125 of them, and what follows for how it breaks.
//!
//! Values are those of clear, straight-grained wood; a species has only what its table has. Tables
//! and their terms are listed in `data/SOURCES.md`.
//!
//! ```
//! use greenstick_wood::moisture::Fallback;
//! use greenstick_wood::species::{Property, Species};
//!
//! let oak = Species::find("white oak")?; // or "Oak, white", or "Quercus alba"
//! assert_eq!(oak.dry.modulus_of_rupture, Some(105e6)); // Pa, at 12 % moisture
//!
//! // At 18 % moisture, by Eq. 5-3 of the Wood Handbook.
//! let rupture = oak.property_at(Property::ModulusOfRupture, 18.0, Fallback::Refuse)?;
//! assert!(rupture.value < 105e6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod catalogue;
mod elastic;
mod genus;
mod green;
mod names;
mod record;
mod strength;
mod table;
mod variation;

pub use catalogue::SPECIES_NAME;
pub use elastic::EngineeringConstants;
pub use genus::{HeartwoodColour, RingCharacter};
pub use green::{GreenEstimate, GreenRatio};
pub use names::UnknownSpecies;
pub use record::{Group, MechanicalProperties, Property, Shrinkage, Species};
pub use strength::{
    DEFAULT_BUNDLE_DIAMETER, FractureHeight, HeightRule, StrengthError, nominal_bending_strength,
    tensile_strength_from_bending,
};
pub use variation::{ClearWoodVariation, CoefficientsOfVariation, DensitySlopes, UnknownVariation};
