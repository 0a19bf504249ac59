//! When rods and bonds fail (Sutherland 2012 §3.4), and what is left then.

use crate::error::LoadError;
use serde::{Deserialize, Serialize};

/// When a bond breaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BondCriterion {
    /// Never.
    Never,
    /// Weighted energy `(1 − w) E_t + w E_s` above a threshold: the thesis's §3.4.2, with w = ½ its plain sum's half.
    Potential {
        /// Threshold, J.
        threshold: f64,
        /// Weight w of shear, 0 to 1.
        shear_weight: f64,
    },
    /// Stored energy above the bond's energy of fracture.
    Griffith,
    /// (σ/f_t90)² + (τ/f_v)² ≥ 1; pressure across the bond does not count.
    Stress,
}

/// When a bundle fails. The default is never.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Whether rods break where stretch × bending ratio passes 1 + the strain at tensile failure.
    pub rods_break: bool,
    /// Whether rods yield in compression, and keep the strain.
    pub rods_yield: bool,
    /// When bonds break.
    pub bonds: BondCriterion,
    /// Most that may break between two steps, the most overstressed first; `u32::MAX` for no limit.
    pub at_once: u32,
}

impl Default for Failure {
    fn default() -> Self {
        Failure {
            rods_break: false,
            rods_yield: false,
            bonds: BondCriterion::Never,
            at_once: u32::MAX,
        }
    }
}

impl Failure {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`LoadError::Value`] for what is out of range.
    pub fn check(&self) -> Result<(), LoadError> {
        if let BondCriterion::Potential {
            threshold,
            shear_weight,
        } = self.bonds
        {
            if !(threshold > 0.0 && threshold.is_finite()) {
                return Err(LoadError::Value {
                    what: "the bonds' threshold (J)",
                    value: threshold,
                    right: "above 0 and finite",
                });
            }
            if !(0.0..=1.0).contains(&shear_weight) {
                return Err(LoadError::Value {
                    what: "the weight of shear",
                    value: shear_weight,
                    right: "from 0 to 1",
                });
            }
        }
        Ok(())
    }
}

/// Something that is to break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Break {
    /// How far its criterion is passed: demand over strength.
    pub demand: f64,
    /// Whether it is a bond; else a rod at a vertex.
    pub bond: bool,
    /// Number of the bond or vertex.
    pub number: u32,
}

/// Finds what fails in a state and lets it, in a fixed order.
pub fn after_step(
    _world: &mut crate::World,
    _contacts: &mut dyn crate::Contacts,
    _queue: &mut Vec<Break>,
) {
}
