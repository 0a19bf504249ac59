//! The criteria by which rods and bonds fail (Sutherland 2012 §3.4).

use crate::error::LoadError;
use serde::{Deserialize, Serialize};

/// When a bond breaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BondCriterion {
    /// Never.
    Never,
    /// Weighted energy `(1 − w) E_t + w E_s` above a threshold, with compression counted like tension (§3.4.2; w = ½ is
    /// half its plain sum).
    Potential {
        /// Threshold, J.
        threshold: f64,
        /// Weight w of shear, 0 to 1.
        shear_weight: f64,
    },
    /// Stored energy above the bond's fracture energy.
    Griffith,
    /// (σ/f_t90)² + (τ/f_v)² ≥ 1; compression across the bond does not count.
    Stress,
    /// Softening from (σ/f_t90)² + (τ/f_v)² = 1 on, until the work done is the fracture energy.
    Cohesive,
}

/// When a bundle fails. The default is never.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FailureCriteria {
    /// Whether rods break where ε² + γ² ≥ 1: ε is the strain of stretch × bending ratio over that at tensile failure, γ the shear
    /// strain of torsion over that at failure in shear along the grain. Rods without twist have only the first.
    pub rods_break: bool,
    /// Whether rods yield in compression and retain the plastic strain.
    pub rods_yield: bool,
    /// Whether rods break where the demand along them is greatest, which lies between vertices; otherwise at vertices.
    pub between_vertices: bool,
    /// When bonds break.
    pub bonds: BondCriterion,
    /// Number of steps from one check for failure to the next; 1 checks after every step.
    pub check_interval: u32,
    /// Largest number of elements that break in one check, the most overstressed first; `u32::MAX` for no limit.
    pub max_breaks: u32,
}

impl Default for FailureCriteria {
    fn default() -> Self {
        FailureCriteria {
            rods_break: false,
            rods_yield: false,
            between_vertices: false,
            bonds: BondCriterion::Never,
            check_interval: 1,
            max_breaks: u32::MAX,
        }
    }
}

impl FailureCriteria {
    /// Whether bonds soften before they break.
    pub(crate) fn is_cohesive(&self) -> bool {
        self.bonds == BondCriterion::Cohesive
    }

    /// Returns the criteria of what lets go at once when it fails: all but cohesive bonds.
    pub(crate) fn sudden(&self) -> Self {
        let bonds = if self.is_cohesive() {
            BondCriterion::Never
        } else {
            self.bonds
        };
        FailureCriteria { bonds, ..*self }
    }

    /// Checks that the numbers are in range.
    ///
    /// # Errors
    /// [`LoadError::Value`] for the first that is not.
    pub fn check(&self) -> Result<(), LoadError> {
        if let BondCriterion::Potential {
            threshold,
            shear_weight,
        } = self.bonds
        {
            if !(threshold > 0.0 && threshold.is_finite()) {
                return Err(LoadError::Value {
                    what: "the bonds' energy threshold (J)",
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
