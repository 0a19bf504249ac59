//! What beam theory says of the specimens.
//!
//! An arm is not clamped at the tip of the crack but turns and shears a little beyond it, as if it were longer by χ h (Hashemi,
//! Kinloch and Williams 1990, *Proceedings of the Royal Society A* 427; 0.42 χ h in end-notched flexure, Wang and Williams 1992,
//! *Composites Science and Technology* 43).

use super::specimen::{CrackSystem, FractureTest, FractureTestKind};
use crate::placement::WoodMaterial;

/// Root correction of end-notched flexure over that of the double cantilever beam.
const SLIDING_ROOT_RATIO: f64 = 0.42;

/// Beam theory of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BeamTheory {
    kind: FractureTestKind,
    /// Half of the length from support to support, height of an arm, and width, m.
    half_span: f64,
    arm: f64,
    width: f64,
    /// Modulus along the grain and shear modulus, Pa.
    longitudinal: f64,
    shear: f64,
    /// What is added to the crack, m.
    pub root: f64,
}

impl BeamTheory {
    pub fn new(test: &FractureTest, wood: &WoodMaterial) -> Self {
        let (across, shear) = match test.system {
            CrackSystem::Rl => (wood.radial, wood.shear_radial),
            CrackSystem::Tl => (wood.tangential, wood.shear_tangential),
        };
        let longitudinal = wood.longitudinal;
        let ratio = 1.18 * (longitudinal * across).sqrt() / shear;
        let part = ratio / (1.0 + ratio);
        let chi = (longitudinal / (11.0 * shear) * (3.0 - 2.0 * part * part)).sqrt();
        let root = match test.kind {
            FractureTestKind::DoubleCantileverBeam => chi,
            FractureTestKind::EndNotchedFlexure => SLIDING_ROOT_RATIO * chi,
        };
        BeamTheory {
            kind: test.kind,
            half_span: 0.5 * test.length,
            arm: test.arm(),
            width: test.width,
            longitudinal,
            shear,
            root: root * test.arm(),
        }
    }

    /// Returns the compliance with a crack of a length (m), m/N.
    pub fn compliance(&self, crack: f64) -> f64 {
        let cube = (crack + self.root).powi(3);
        let stiffness = self.longitudinal * self.width * self.arm.powi(3);
        match self.kind {
            FractureTestKind::DoubleCantileverBeam => 8.0 * cube / stiffness,
            FractureTestKind::EndNotchedFlexure => {
                let span = self.half_span;
                (2.0 * span.powi(3) + 3.0 * cube) / (8.0 * stiffness)
                    + 3.0 * span / (10.0 * self.shear * self.width * self.arm)
            }
        }
    }

    /// Returns the energy release rate under a load (N) with a crack of a length (m), J/m².
    pub fn energy_release_rate(&self, load: f64, crack: f64) -> f64 {
        let moment = load * (crack + self.root);
        let stiffness = self.longitudinal * self.width * self.width * self.arm.powi(3);
        let factor = match self.kind {
            FractureTestKind::DoubleCantileverBeam => 12.0,
            FractureTestKind::EndNotchedFlexure => 9.0 / 16.0,
        };
        factor * moment * moment / stiffness
    }

    /// Returns the crack, with its correction of the root, that a compliance (m/N) tells (de Moura, Morais and Dourado 2008,
    /// *Engineering Fracture Mechanics* 75): with the process zone before it, which is softer than whole wood.
    fn equivalent_crack(&self, compliance: f64) -> f64 {
        let stiffness = self.longitudinal * self.width * self.arm.powi(3);
        let cube = match self.kind {
            FractureTestKind::DoubleCantileverBeam => compliance * stiffness / 8.0,
            FractureTestKind::EndNotchedFlexure => {
                let whole = self.compliance(-self.root);
                (compliance - whole) * 8.0 * stiffness / 3.0
            }
        };
        cube.cbrt()
    }

    /// Returns the energy release rate under a load (N) with the crack that the compliance (m/N) tells, J/m².
    pub fn energy_release_rate_by_compliance(&self, load: f64, compliance: f64) -> f64 {
        self.energy_release_rate(load, self.equivalent_crack(compliance) - self.root)
    }

    /// Returns the load at which a crack of a length (m) has an energy release rate (J/m²), N.
    pub fn load(&self, rate: f64, crack: f64) -> f64 {
        (rate / self.energy_release_rate(1.0, crack)).sqrt()
    }
}
